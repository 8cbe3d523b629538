"""Measure a marker on bent paper: the pose of the plane that touches the middle, and a cylinder.

Paper bends about one axis. The fit moves a cylinder in the camera's frame until the edges of the cells agree with the
image (edge_alignment.py), from both poses of the flat marker and some directions of the axis.
"""
from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from alvar_core import drawing
from alvar_core.arrays import Bools, Floats, Image
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.detection.edge_alignment import EdgeAligner, EdgeFit, Model, edge_points

PLACES = np.array([-0.3, 0.0, 0.3])
SCALE = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-2, 1e-2])


class Sheet(NamedTuple):
    """A bent marker.

    ``rotation`` (3, 3), ``position`` (3,) [m] of the plane that touches its middle; ``bend`` [rad]: how much the paper
    turns over the marker's width, positive for a bulge towards the camera; ``corners`` (4, 2) [ideal px];
    ``error`` [px]: typical residual of the edges; ``turn_error`` [rad]: standard deviation of the rotation;
    ``sure``: the pose is better by far than the second best; ``doubtful``: it may be off by more than 5 degrees.
    """

    rotation: Floats
    position: Floats
    bend: float
    corners: Floats
    error: float
    turn_error: float
    sure: bool
    doubtful: bool


def cylinder(camera: Camera, cells: int, axis: float) -> Model:
    """Return the Model of a bent marker: rotation vector, position [widths], bend [rad], change of the axis [rad].

    The paper is straight along the direction at ``axis`` + pi / 2 [rad] to the marker's x axis. Without the last
    parameter the axis stays.
    """
    def model(theta: Floats, points: Floats) -> Floats:
        s, t = points[:, 0] / cells, -points[:, 1] / cells
        out = np.empty((len(theta), len(points), 2))
        for b, row in enumerate(theta):
            angle = axis + (row[7] if len(row) > 7 else 0.0)
            c, n = np.cos(angle), np.sin(angle)
            arc, v = s * c + t * n, t * c - s * n
            u = arc * np.sinc(row[6] * arc / np.pi)
            z = -0.5 * row[6] * (arc * np.sinc(row[6] * arc / (2 * np.pi))) ** 2
            place = np.stack([u * c - v * n, u * n + v * c, z], 1) @ cv2.Rodrigues(row[:3])[0].T + row[3:6]
            out[b] = place[:, :2] / place[:, 2:] * camera.focal + camera.centre
        return out
    return model


class BentPaper:
    """Measures bent markers with ``cells`` cells per side."""

    def __init__(self, cells: int) -> None:
        self.cells, self._aligner = cells, EdgeAligner()
        self._square = drawing.UNIT_CORNERS[:, :2] * [cells, -cells]

    def measure(self, grey: Image, camera: Camera, black: Bools, poses: Sequence[tuple[Floats, Floats]], size: float,
                reach: float) -> Sheet | None:
        """Return the Sheet of a marker; None if its edges cannot be followed.

        ``black`` (n, n) are its upright cells, ``poses`` (rotation, position [m]) those of a flat marker there,
        ``size`` [m] its width, ``reach`` [px] half the width that is read across an edge.
        """
        points = edge_points(black, PLACES)
        found: list[tuple[float, float, EdgeFit]] = []
        for rotation, position in poses:
            start = np.concatenate([cv2.Rodrigues(rotation)[0][:, 0], position / size, [0.0]])
            for axis in np.arange(thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES:
                fit = self._aligner.fit(grey, camera, cylinder(camera, self.cells, axis), start, points, SCALE[:7],
                                        reach, thresholds.BEND_STEPS)
                if fit is not None:
                    found.append((fit.cost, axis, fit))
        if not found:
            return None
        found.sort(key=lambda each: each[0])
        _, axis, first = found[0]
        fit = self._aligner.fit(grey, camera, cylinder(camera, self.cells, axis), np.append(first.parameters, 0.0),
                                points, SCALE, reach, thresholds.BEND_STEPS)
        if fit is None or not fit.parameters[5] > 0:
            return None
        return self._sheet(camera, axis, fit, self._sure(fit, found), size)

    def _sure(self, best: EdgeFit, found: Sequence[tuple[float, float, EdgeFit]]) -> bool:
        """Return whether no fit with another rotation is nearly as good."""
        here = cv2.Rodrigues(best.parameters[:3])[0]
        for cost, _, fit in found:
            turn = np.arccos(np.clip((np.trace(here.T @ cv2.Rodrigues(fit.parameters[:3])[0]) - 1) / 2, -1, 1))
            if turn > thresholds.BEND_OTHER_TURN and cost < thresholds.BEND_OTHER_COST * best.cost:
                return False
        return True

    def _sheet(self, camera: Camera, axis: float, fit: EdgeFit, sure: bool, size: float) -> Sheet:
        theta = fit.parameters
        corners = cylinder(camera, self.cells, axis)(theta[None], self._square)[0]
        turn_error = float(np.sqrt(np.trace(fit.covariance[:3, :3])))
        doubtful = (fit.error > thresholds.MAX_BENT_ERROR or turn_error > thresholds.MAX_BENT_TURN
                    or fit.seen < thresholds.MIN_BENT_SEEN)
        rotation: Floats = cv2.Rodrigues(theta[:3])[0].astype(np.float64)
        return Sheet(rotation, theta[3:6] * size, float(theta[6]), corners, fit.error, turn_error,
                     sure, doubtful)
