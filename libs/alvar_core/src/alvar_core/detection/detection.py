"""What a Detector finds: one marker each."""
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
from alvar_core.detection.pose import Solution
from alvar_core.rotations import quaternion_from_matrix


@dataclass
class Detection:
    """One marker.

    id: its number, or its text; corners: (4, 2) real px, top left, top right, bottom right, bottom left as drawn;
    rotation (3, 3) and position (3,) m: the marker in the camera's optical frame; confidence: 0..1; ambiguity: 0..0.5,
    probability of the other pose; ambiguous: this image cannot tell the two poses apart; error: rms reprojection error
    of the corners, px; solutions: both poses, best first; features: what it was accepted for; information: (8, 8)
    inverse covariance of the corners, 1/px^2.
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

    @cached_property
    def centre(self) -> tuple[float, float]:
        """Mean of the corners, real px."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return (ax + bx + cx + dx) / 4, (ay + by + cy + dy) / 4

    @cached_property
    def side(self) -> float:
        """Side of a square of the same area, px."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return math.sqrt(abs((ax - cx) * (by - dy) - (ay - cy) * (bx - dx)) / 2)

    def covers(self, point: tuple[float, float]) -> bool:
        """Whether a point, real px, lies on the marker."""
        if math.dist(point, self.centre) > 4 * self.side:  # a square that is seen at all is not longer
            return False
        return cv2.pointPolygonTest(self.corners.astype(np.float32), point, False) >= 0

    @property
    def quaternion(self) -> Floats:
        """Orientation x y z w in the camera's optical frame."""
        return quaternion_from_matrix(self.rotation)


def best_of_overlapping(found: Sequence[Detection]) -> list[Detection]:
    """Of Detections that overlap the one with the highest confidence: the cells of a marker are not a marker."""
    kept: list[Detection] = []
    for d in sorted(found, key=lambda d: -d.confidence):
        if all(math.dist(d.centre, k.centre) > thresholds.OVERLAP * d.side and not k.covers(d.centre) for k in kept):
            kept.append(d)
    return kept
