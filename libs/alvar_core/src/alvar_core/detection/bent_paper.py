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
from alvar_core.detection.edge_alignment import EdgeAligner, EdgeFit, EdgePoints, Model, edge_points

PLACES = np.array([-0.3, 0.0, 0.3])
SCALE = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-2, 1e-2])  # of the parameters of a cylinder


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


def cylinder(camera: Camera, cells: int) -> Model:
    """Return the Model of a bent marker: rotation vector, position [widths], bend [rad], axis [rad].

    The paper is straight along the direction at axis + pi / 2 to the marker's x axis.
    """
    def model(theta: Floats, points: Floats) -> Floats:
        s, t = points[:, 0] / cells, -points[:, 1] / cells
        c, n, bend = np.cos(theta[:, 7:]), np.sin(theta[:, 7:]), theta[:, 6:7]
        arc, v = s * c + t * n, t * c - s * n
        u = arc * np.sinc(bend * arc / np.pi)
        z = -0.5 * bend * (arc * np.sinc(bend * arc / (2 * np.pi))) ** 2
        turns = np.array([cv2.Rodrigues(row)[0] for row in theta[:, :3]])
        place = np.stack([u * c - v * n, u * n + v * c, z], 2) @ turns.transpose(0, 2, 1) + theta[:, None, 3:6]
        seen: Floats = place[..., :2] / place[..., 2:] * camera.focal + camera.centre
        return seen
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
        points, model = edge_points(black, PLACES), cylinder(camera, self.cells)
        axes = np.arange(thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES
        found: list[EdgeFit] = []
        for rotation, position in poses:
            start = [*cv2.Rodrigues(rotation)[0][:, 0], *position / size]
            starts = np.array([[*start, bend, axis] for bend in thresholds.BEND_STARTS for axis in axes])
            # the axis is free at the end only: of flat paper it has none
            fits = self._fits(grey, camera, model, starts, points, SCALE[:7], reach)[:thresholds.BEND_FREED]
            if fits:
                starts = np.array([each.parameters for each in fits])
                found += self._fits(grey, camera, model, starts, points, SCALE, reach)
        found = sorted((each for each in found if each.parameters[5] > 0), key=lambda each: each.cost)
        if not found:
            return None
        fit = found[0]
        return self._sheet(model, fit, self._sure(fit, found), size)

    def _fits(self, grey: Image, camera: Camera, model: Model, starts: Floats, points: EdgePoints, scale: Floats,
              reach: float) -> list[EdgeFit]:
        """Return the fits from all starts that have one, best first."""
        fits = self._aligner.fit(grey, camera, model, starts, points, scale, reach, thresholds.BEND_STEPS)
        return sorted((each for each in fits if each is not None), key=lambda each: each.cost)

    def _sure(self, best: EdgeFit, found: Sequence[EdgeFit]) -> bool:
        """Return whether no fit with another rotation is nearly as good."""
        here = cv2.Rodrigues(best.parameters[:3])[0]
        for fit in found:
            turn = np.arccos(np.clip((np.trace(here.T @ cv2.Rodrigues(fit.parameters[:3])[0]) - 1) / 2, -1, 1))
            if turn > thresholds.BEND_OTHER_TURN and fit.cost < thresholds.BEND_OTHER_COST * best.cost:
                return False
        return True

    def _sheet(self, model: Model, fit: EdgeFit, sure: bool, size: float) -> Sheet:
        theta = fit.parameters
        corners = model(theta[None], self._square)[0]
        turn_error = float(np.sqrt(np.trace(fit.covariance[:3, :3])))
        doubtful = (fit.error > thresholds.MAX_BENT_ERROR or turn_error > thresholds.MAX_BENT_TURN
                    or fit.seen < thresholds.MIN_BENT_SEEN)
        rotation: Floats = cv2.Rodrigues(theta[:3])[0].astype(np.float64)
        return Sheet(rotation, theta[3:6] * size, float(theta[6]), corners, fit.error, turn_error,
                     sure, doubtful)
