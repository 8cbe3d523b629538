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
from alvar_core.detection.edge_alignment import (
    EdgeAligner,
    EdgeFit,
    EdgePoints,
    Model,
    SeenEdges,
    directions,
    edge_points,
)

FIRST_PLACES = np.array([0.0])  # along an edge, [cells], while the axis is fixed
PLACES = np.array([-0.3, 0.0, 0.3])
STEP = 1e-3  # rad, for the derivatives by bend and axis
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


class Cylinder(Model):
    """A bent marker with ``cells`` cells per side: rotation vector, position [widths], bend [rad], axis [rad].

    The paper is straight along the direction at axis + pi / 2 to the marker's x axis.
    """

    def __init__(self, camera: Camera, cells: int) -> None:
        self._camera, self._cells = camera, cells
        self._to_widths = np.array([[1 / cells], [-1 / cells]])

    def places(self, theta: Floats, points: Floats) -> Floats:
        """Return the ideal pixels (K, P, 2) of points (P, 2) [cells] with parameters ``theta`` (K, 8)."""
        paper, _ = self._bent(theta[:, 6:7], theta[:, 7:], self._to_widths * points.T)
        turns = np.array([cv2.Rodrigues(row)[0] for row in theta[:, :3]])
        place = turns @ paper + theta[:, 3:6, None]
        return (place[:, :2] / place[:, 2:]).transpose(0, 2, 1) * self._camera.focal + self._camera.centre

    def edges(self, theta: Floats, points: EdgePoints) -> SeenEdges:
        """Return the SeenEdges with parameters ``theta`` (K, 8)."""
        bend, axis, st = theta[:, 6:7], theta[:, 7:], self._to_widths * points.middle.T
        paper, ways = self._bent(bend, axis, st, self._to_widths * points.along, self._to_widths * points.across)
        turns, by_turn = zip(*(cv2.Rodrigues(row) for row in theta[:, :3]))
        turn = np.array(turns)
        place = turn @ paper + theta[:, 3:6, None]
        depth, focal = place[:, 2:], self._camera.focal[:, None]
        rays = place[:, :2] / depth
        along, outward = (focal * (way[:, :2] - rays * way[:, 2:]) for way in (turn @ each for each in ways))
        direction = directions(along, outward)
        towards = direction * (focal / depth)
        towards = np.concatenate([towards, -(towards * rays).sum(1, keepdims=True)], 1)
        on_paper = turn.transpose(0, 2, 1) @ towards
        turned = np.array(by_turn).reshape(len(theta), 3, 3, 3) @ paper[:, None]
        moved = [(self._bent(bend + more, axis + turn_of_axis, st)[0] - paper) / STEP
                 for more, turn_of_axis in ((STEP, 0), (0, STEP))]
        jacobian = np.concatenate([(turned * towards[:, None]).sum(2), towards,
                                   np.stack([(each * on_paper).sum(1) for each in moved], 1)], 1)
        return SeenEdges(rays * focal + self._camera.centre[:, None], direction, jacobian)

    def _bent(self, bend: Floats, axis: Floats, st: Floats, *ways: Floats) -> tuple[Floats, list[Floats]]:
        """Return where points ``st`` (2, P) [widths] of the paper are (K, 3, P), and the same of ``ways`` from them."""
        c, n = np.cos(axis), np.sin(axis)
        arc, v = st[0] * c + st[1] * n, st[1] * c - st[0] * n
        u = arc * np.sinc(bend * arc / np.pi)
        z = -0.5 * bend * (arc * np.sinc(bend * arc / (2 * np.pi))) ** 2
        out = []
        for way in ways:
            along, beside = way[0] * c + way[1] * n, way[1] * c - way[0] * n
            rising = np.cos(bend * arc) * along
            out.append(np.stack([rising * c - beside * n, rising * n + beside * c, -np.sin(bend * arc) * along], 1))
        return np.stack([u * c - v * n, u * n + v * c, z], 1), out


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
        model, points = Cylinder(camera, self.cells), edge_points(black, FIRST_PLACES)
        axes = np.arange(thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES
        flat = [[*cv2.Rodrigues(rotation)[0][:, 0], *position / size] for rotation, position in poses]
        starts = np.array([[*start, bend, axis] for start in flat for bend in thresholds.BEND_STARTS for axis in axes])
        # the axis is free at the end only: of flat paper it has none
        fits = self._aligner.fit(grey, camera, model, starts, points, SCALE[:7], reach, thresholds.BEND_STEPS)
        each_pose = len(starts) // len(flat)
        best = [fit.parameters for k in range(0, len(fits), each_pose)
                for fit in _best_first(fits[k:k + each_pose])[:thresholds.BEND_FREED]]
        if not best:
            return None
        points = edge_points(black, PLACES)
        found = _best_first(self._aligner.fit(grey, camera, model, np.array(best), points, SCALE, reach,
                                              thresholds.BEND_STEPS))
        found = [each for each in found if each.parameters[5] > 0]
        if not found:
            return None
        fit = found[0]
        return self._sheet(model, fit, self._sure(fit, found), size)

    def _sure(self, best: EdgeFit, found: Sequence[EdgeFit]) -> bool:
        """Return whether no fit with another rotation is nearly as good."""
        here = cv2.Rodrigues(best.parameters[:3])[0]
        for fit in found:
            turn = np.arccos(np.clip((np.trace(here.T @ cv2.Rodrigues(fit.parameters[:3])[0]) - 1) / 2, -1, 1))
            if turn > thresholds.BEND_OTHER_TURN and fit.cost < thresholds.BEND_OTHER_COST * best.cost:
                return False
        return True

    def _sheet(self, model: Cylinder, fit: EdgeFit, sure: bool, size: float) -> Sheet:
        theta = fit.parameters
        corners = model.places(theta[None], self._square)[0]
        turn_error = float(np.sqrt(np.trace(fit.covariance[:3, :3])))
        doubtful = (fit.error > thresholds.MAX_BENT_ERROR or turn_error > thresholds.MAX_BENT_TURN
                    or fit.seen < thresholds.MIN_BENT_SEEN)
        rotation: Floats = cv2.Rodrigues(theta[:3])[0].astype(np.float64)
        return Sheet(rotation, theta[3:6] * size, float(theta[6]), corners, fit.error, turn_error,
                     sure, doubtful)


def _best_first(fits: Sequence[EdgeFit | None]) -> list[EdgeFit]:
    """Return the fits that have enough edges, best first."""
    return sorted((each for each in fits if each is not None), key=lambda each: each.cost)
