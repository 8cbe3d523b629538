"""Measure a marker on bent or creased paper: the pose of the plane that touches the middle, and the paper's shape.

Paper bends about one axis, or is folded along a line. The fit moves a cylinder, and two planes, in the camera's frame
until the edges of the cells agree with the image (edge_alignment.py), from both poses of the flat marker and some
directions of the axis. The better one counts.
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
from alvar_core.detection.light import LINEAR, Light
from alvar_core.rotations import angle_between

FIRST_PLACES = np.array([0.0])  # along an edge, [cells], while the axis is fixed
PLACES = np.array([-0.3, 0.0, 0.3])
STEP = 1e-3  # rad, for the derivatives by bend and axis
SCALE = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2])  # of the parameters of a Curved marker


class Sheet(NamedTuple):
    """A bent marker.

    ``rotation`` (3, 3), ``position`` (3,) [m] of the plane that touches its middle; ``bend`` [rad]: how much the paper
    turns over the marker's width, or at a crease, positive for a bulge towards the camera; ``corners`` (4, 2)
    [ideal px]; ``error`` [px]: typical residual of the edges; ``turn_error`` [rad]: standard deviation of the rotation;
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


class Curved(Model):
    """A curved marker with ``cells`` cells per side: rotation vector, position [widths], then what its shape is."""

    def __init__(self, camera: Camera, cells: int) -> None:
        self._camera, self._cells = camera, cells
        self._to_widths = np.array([[1 / cells], [-1 / cells]])

    def places(self, theta: Floats, points: Floats) -> Floats:
        """Return the ideal pixels (K, P, 2) of points (P, 2) [cells] with parameters ``theta`` (K, n)."""
        paper, _ = self._bent(theta[:, 6:], self._to_widths * points.T)
        turns = np.array([cv2.Rodrigues(row)[0] for row in theta[:, :3]])
        place = turns @ paper + theta[:, 3:6, None]
        return (place[:, :2] / place[:, 2:]).transpose(0, 2, 1) * self._camera.focal + self._camera.centre

    def edges(self, theta: Floats, points: EdgePoints) -> SeenEdges:
        """Return the SeenEdges with parameters ``theta`` (K, n)."""
        shape, st = theta[:, 6:], self._to_widths * points.middle.T
        paper, ways = self._bent(shape, st, self._to_widths * points.along, self._to_widths * points.across)
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
        moved = [(self._bent(shape + more, st)[0] - paper) / STEP for more in STEP * np.eye(shape.shape[1])]
        jacobian = np.concatenate([(turned * towards[:, None]).sum(2), towards,
                                   np.stack([(each * on_paper).sum(1) for each in moved], 1)], 1)
        return SeenEdges(rays * focal + self._camera.centre[:, None], direction, jacobian)

    def _bent(self, shape: Floats, st: Floats, *ways: Floats) -> tuple[Floats, list[Floats]]:
        """Return where points ``st`` (2, P) [widths] of the paper are (K, 3, P), and the same of ``ways`` from them."""
        c, n = np.cos(shape[:, 1:2]), np.sin(shape[:, 1:2])
        arc, v = st[0] * c + st[1] * n, st[1] * c - st[0] * n
        u, z, turn = self._profile(shape, arc)
        out = []
        for way in ways:
            along, beside = way[0] * c + way[1] * n, way[1] * c - way[0] * n
            rising = np.cos(turn) * along
            out.append(np.stack([rising * c - beside * n, rising * n + beside * c, -np.sin(turn) * along], 1))
        return np.stack([u * c - v * n, u * n + v * c, z], 1), out

    def of_middle(self, theta: Floats) -> Floats:
        """Return the parameters (n,) of the same paper whose pose is that of the plane that touches the middle."""
        return theta

    def bend(self, theta: Floats) -> float:
        """Return how much the paper turns [rad]."""
        return float(theta[6])

    def _profile(self, shape: Floats, arc: Floats) -> tuple[Floats, Floats, Floats]:
        """Return places across the bend, heights [widths] and slopes [rad] at ``arc`` (K, P) [widths] from the middle.

        All are (K, P).
        """
        raise NotImplementedError


class Cylinder(Curved):
    """A marker bent as a cylinder, by: bend [rad], axis [rad].

    The paper is straight along the direction at axis + pi / 2 to the marker's x axis.
    """

    def _profile(self, shape: Floats, arc: Floats) -> tuple[Floats, Floats, Floats]:
        bend = shape[:, :1]
        turn = bend * arc
        return arc * np.sinc(turn / np.pi), -0.5 * bend * (arc * np.sinc(turn / (2 * np.pi))) ** 2, turn


class Crease(Curved):
    """A marker folded once, by: fold [rad], direction [rad] across the crease, its distance [widths] from the middle.

    The pose is that of the plane on which the marker's middle lies.
    """

    def of_middle(self, theta: Floats) -> Floats:
        """Return the parameters (n,) of the same paper whose pose is that of the plane with the middle."""
        fold, way, offset = theta[6:]
        if offset >= 0:
            return theta
        across, turn = np.array([np.cos(way), np.sin(way), 0]), cv2.Rodrigues(theta[:3])[0]
        middle = offset * (1 - np.cos(fold)) * across + [0, 0, offset * np.sin(fold)]
        folded = turn @ cv2.Rodrigues(fold * np.array([-across[1], across[0], 0]))[0]
        return np.array([*cv2.Rodrigues(folded)[0][:, 0], *(turn @ middle + theta[3:6]), fold, way + np.pi, -offset])

    def bend(self, theta: Floats) -> float:
        """Return the angle by which the paper turns within the marker [rad]."""
        return float(theta[6]) if theta[8] < thresholds.MAX_CREASE else 0.0

    def _profile(self, shape: Floats, arc: Floats) -> tuple[Floats, Floats, Floats]:
        fold, offset = shape[:, :1], shape[:, 2:]
        beyond = np.maximum(arc - offset, 0)
        return np.minimum(arc, offset) + beyond * np.cos(fold), -beyond * np.sin(fold), np.where(beyond > 0, fold, 0)


class Fit(NamedTuple):
    """An EdgeFit and the model that it fits."""

    model: Curved
    edges: EdgeFit

    @property
    def rotation(self) -> Floats:
        """Return the rotation (3, 3)."""
        return cv2.Rodrigues(self.edges.parameters[:3])[0].astype(np.float64)


class BentPaper:
    """Measures bent markers with ``cells`` cells per side."""

    def __init__(self, cells: int) -> None:
        self.cells, self._aligner = cells, EdgeAligner()
        self._square = drawing.UNIT_CORNERS[:, :2] * [cells, -cells]

    def measure(self, grey: Image, camera: Camera, black: Bools, poses: Sequence[tuple[Floats, Floats]], size: float,
                reach: float, max_error: float, light: Light = LINEAR) -> Sheet | None:
        """Return the Sheet of a marker; None if its edges cannot be followed.

        ``black`` (n, n) are its upright cells, ``poses`` (rotation, position [m]) those of a flat marker there,
        ``size`` [m] its width, ``reach`` [px] half the width that is read across an edge; with a larger error than
        ``max_error`` [px] it is doubtful.
        """
        axes = np.arange(thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES
        ways = np.arange(2 * thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES  # a crease has two sides
        flat = [[*cv2.Rodrigues(rotation)[0][:, 0], *position / size] for rotation, position in poses]
        bent = [[bend, axis] for bend in thresholds.BEND_STARTS for axis in axes]
        folded = [[fold, way, thresholds.CREASE_START] for fold in thresholds.FOLD_STARTS for way in ways]
        found: list[Fit] = []
        for model, shapes in (Cylinder(camera, self.cells), bent), (Crease(camera, self.cells), folded):
            found += self._fits(grey, camera, model, black, flat, shapes, reach, light)
        found = [each for each in found if each.edges.parameters[5] > 0]
        if not found:
            return None
        best = min(found, key=lambda each: each.edges.cost)
        return self._sheet(best, self._sure(best, found), size, max_error)

    def _fits(self, grey: Image, camera: Camera, model: Curved, black: Bools, flat: Sequence[Sequence[float]],
              shapes: Sequence[Sequence[float]], reach: float, light: Light) -> list[Fit]:
        """Return the Fits of a model from each of the poses ``flat`` and each of ``shapes``."""
        starts = np.array([[*pose, *shape] for pose in flat for shape in shapes])
        # the axis or crease stays fixed until the end, because flat paper has none
        fits = self._aligner.fit(grey, camera, model, starts, edge_points(black, FIRST_PLACES), SCALE[:7], reach,
                                 thresholds.BEND_STEPS, light=light)
        best = [fit.parameters for k in range(0, len(fits), len(shapes))
                for fit in _best_first(fits[k:k + len(shapes)])[:thresholds.BEND_FREED]]
        if not best:
            return []
        fits = self._aligner.fit(grey, camera, model, np.array(best), edge_points(black, PLACES),
                                 SCALE[:starts.shape[1]], reach, thresholds.BEND_STEPS, light=light)
        found = _best_first(fits)
        for fit in found:
            fit.parameters = model.of_middle(fit.parameters)
        return [Fit(model, fit) for fit in found]

    def _sure(self, best: Fit, found: Sequence[Fit]) -> bool:
        """Return whether no fit with another rotation is nearly as good."""
        for fit in found:
            turn = angle_between(best.rotation, fit.rotation)
            if turn > thresholds.BEND_OTHER_TURN and fit.edges.cost < thresholds.BEND_OTHER_COST * best.edges.cost:
                return False
        return True

    def _sheet(self, best: Fit, sure: bool, size: float, max_error: float) -> Sheet:
        fit, theta = best.edges, best.edges.parameters
        corners = best.model.places(theta[None], self._square)[0]
        turn_error = float(np.sqrt(np.trace(fit.covariance[:3, :3])))
        bend = best.model.bend(theta)
        unknown = abs(bend) > thresholds.MIN_BEND and turn_error > thresholds.MAX_BENT_TURN  # flat paper has no axis
        doubtful = unknown or fit.error > max_error or fit.seen < thresholds.MIN_BENT_SEEN
        return Sheet(best.rotation, theta[3:6] * size, bend, corners, fit.error, turn_error, sure, doubtful)


def _best_first(fits: Sequence[EdgeFit | None]) -> list[EdgeFit]:
    """Return the fits that have enough edges, best first."""
    return sorted((each for each in fits if each is not None), key=lambda each: each.cost)
