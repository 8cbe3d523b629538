"""The result of a Detector: a Detection for each marker."""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Sequence

import cv2
import numpy as np

from alvar_core.arrays import Floats
from alvar_core.detection import thresholds
from alvar_core.detection.acceptance import Features
from alvar_core.detection.bent_paper import Sheet
from alvar_core.detection.pose import Solution
from alvar_core.rotations import quaternion_from_matrix


@dataclass(eq=False)
class Detection:
    """One marker in an image; equal to itself alone.

    ``id`` is its number or text. ``corners`` (4, 2) [real px]: top left, top right, bottom right, bottom left, as
    drawn. ``rotation`` (3, 3) and ``position`` (3,) [m] are its pose in the camera's optical frame. ``confidence``:
    0 to 1. ``ambiguity``, 0 to 0.5, is the probability of the other pose; ``ambiguous``: the image does not decide
    between the two. ``error`` [px] is the rms reprojection error of the corners. ``solutions`` holds both poses, best
    first, ``features`` what the acceptance has measured, ``information`` (8, 8) [1/px^2] the inverse covariance of the
    corners. ``bend`` [rad]: how much the paper turns over the marker's width, positive for a bulge towards the camera;
    the pose is then that of the plane that touches the middle. ``doubtful``: the pose may be off by more than 5
    degrees, and ``reason`` says why: the corners do not fit a flat square, or no paper shape agrees with the edges.
    ``thin_margin``: the white margin is too narrow to measure the rim of the black square. ``sheet``: the last fit of
    bent paper, if there was one.
    """

    id: int | str
    corners: Floats
    rotation: Floats
    position: Floats
    confidence: float
    ambiguity: float
    ambiguous: bool
    error: float
    solutions: list[Solution] = field(repr=False)
    features: Features | None = field(repr=False, default=None)
    information: Floats | None = field(repr=False, default=None)
    bend: float = 0.0
    doubtful: bool = False
    reason: str = ''
    thin_margin: bool = field(repr=False, default=False)
    sheet: Sheet | None = field(repr=False, default=None)

    @cached_property
    def centre(self) -> tuple[float, float]:
        """Return the mean of the corners [real px]."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return (ax + bx + cx + dx) / 4, (ay + by + cy + dy) / 4

    @cached_property
    def side(self) -> float:
        """Return the side [px] of a square with the same area."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return math.sqrt(abs((ax - cx) * (by - dy) - (ay - cy) * (bx - dx)) / 2)

    def doubt_size(self, error: float) -> None:
        """Add to the errors of the corners that all of them may lie ``error`` [px] farther out or in together."""
        if self.information is not None:
            outward = self.corners - self.corners.mean(0)
            outward = (outward / np.linalg.norm(outward, axis=1, keepdims=True)).ravel() * error
            weighted = self.information @ outward  # of the covariance plus this error (Sherman-Morrison formula)
            self.information = self.information - np.outer(weighted, weighted) / (1 + outward @ weighted)

    def forget_size(self) -> None:
        """Forget centre and side, because the corners have changed."""
        for name in ('centre', 'side'):
            self.__dict__.pop(name, None)

    def covers(self, point: tuple[float, float]) -> bool:
        """Return whether a point [real px] lies on the marker."""
        if math.dist(point, self.centre) > 4 * self.side:  # no visible square is longer
            return False
        return cv2.pointPolygonTest(self.corners.astype(np.float32), point, False) >= 0

    @property
    def quaternion(self) -> Floats:
        """Return the orientation x y z w in the camera's optical frame."""
        return quaternion_from_matrix(self.rotation)


def best_of_overlapping(found: Sequence[Detection]) -> list[Detection]:
    """Return, of Detections that overlap, only the one with the highest confidence.

    The others are cells of a marker that look like a marker.
    """
    if len(found) < 2:
        return list(found)
    order = sorted(found, key=lambda d: -d.confidence)
    corners = np.array([d.corners for d in order])
    centre = corners.mean(1)
    reach = np.linalg.norm(corners - centre[:, None], axis=2).max(1)
    near = thresholds.OVERLAP * np.array([d.side for d in order])
    close = np.tril((np.abs(centre[:, None] - centre) < (reach + near[:, None])[..., None]).all(2), -1)
    kept = np.ones(len(order), bool)
    for m in np.flatnonzero(close.any(1)).tolist():
        d = order[m]
        kept[m] = not any(math.dist(d.centre, order[k].centre) <= near[m] or order[k].covers(d.centre)
                          for k in np.flatnonzero(close[m] & kept).tolist())
    return [d for d, keep in zip(order, kept.tolist()) if keep]
