"""Measure a marker on bent or creased paper: the pose of the plane that touches the middle, and the paper's shape.

Paper bends about one axis, or is folded along a line. The fit moves a cylinder, and two planes, in the camera's frame
until the edges of the cells agree with the image (edge_alignment.py), from both poses of the flat marker and some
directions of the axis. The better one counts.
"""
from __future__ import annotations

from typing import NamedTuple, Sequence

import cv2
import numpy as np

from alvar_core import drawing, native
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.detection.edge_alignment import EdgeFit, EdgePoints, edge_points
from alvar_core.detection.light import LINEAR, Light
from alvar_core.rotations import angle_between

FIRST_PLACES = np.array([0.0])  # along an edge, [cells], while the axis is fixed
PLACES = np.array([-0.3, 0.0, 0.3])
SCALE = np.array([1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2])  # of the parameters of a Curved marker


class Sheet(NamedTuple):
    """A bent marker.

    ``rotation`` (3, 3), ``position`` (3,) [m] of the plane that touches its middle; ``bend`` [rad]: how much the paper
    turns over the marker's width, or at a crease, positive for a bulge towards the camera; ``corners`` (4, 2)
    [ideal px]; ``error`` [px]: typical residual of the edges; ``turn_error`` [rad]: standard deviation of the rotation;
    ``sure``: the pose is better by far than the second best; ``doubtful``: it may be off by more than 5 degrees;
    ``shape``: the parameters of a Cylinder (2) or a Crease (3); ``age``: how many images ago it was fitted.
    """

    rotation: Floats
    position: Floats
    bend: float
    corners: Floats
    error: float
    turn_error: float
    sure: bool
    doubtful: bool
    shape: Floats
    age: int = 0

    @property
    def is_bent(self) -> bool:
        """Return whether the paper is surely not flat."""
        return not self.doubtful and abs(self.bend) > thresholds.MIN_BEND


class Curved:
    """A curved marker with ``cells`` cells per side: rotation vector, position [widths], then what its shape is."""

    def __init__(self, camera: Camera, cells: int) -> None:
        self._camera, self._cells = camera, cells

    def places(self, theta: Floats, points: Floats) -> Floats:
        """Return the ideal pixels (P, 2) of points (P, 2) [cells] with parameters ``theta`` (n,)."""
        return native.steps.curved_places(lens=self._camera.lens, cells=self._cells, theta=theta, points=points)

    def fit(self, grey: Image, starts: Floats, points: EdgePoints, free: int, reach: float, steps: int,
            first_reach: float, light: Light) -> list[EdgeFit | None]:
        """Return the EdgeFit from each of ``starts`` (K, n), of which the first ``free`` parameters move.

        It is None if too few edges are seen. ``reach`` [px]: half the width that is read across an edge,
        ``first_reach`` that of the first step.
        """
        fits = native.steps.fit_curved(
            grey=grey, lens=self._camera.lens, cells=self._cells, starts=starts, middle=points.middle,
            outward=points.outward, scale=SCALE[:free], reach=reach, first_reach=first_reach, steps=steps,
            light=light.steps, limit=native.limit)
        return [None if each is None else EdgeFit(**each) for each in fits]

    def of_middle(self, theta: Floats) -> Floats:
        """Return the parameters (n,) of the same paper whose pose is that of the plane that touches the middle."""
        return theta

    def bend(self, theta: Floats) -> float:
        """Return how much the paper turns [rad]."""
        return float(theta[6])


class Cylinder(Curved):
    """A marker bent as a cylinder, by: bend [rad], axis [rad].

    The paper is straight along the direction at axis + pi / 2 to the marker's x axis.
    """


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
        self.cells = cells
        self._square = drawing.UNIT_CORNERS[:, :2] * [cells, -cells]

    def measure(self, grey: Image, camera: Camera, black: Bools, poses: Sequence[tuple[Floats, Floats]], size: float,
                reach: float, max_error: float, light: Light = LINEAR, before: Sheet | None = None) -> Sheet | None:
        """Return the Sheet of a marker; None if its edges cannot be followed.

        ``black`` (n, n) are its upright cells, ``poses`` (rotation, position [m]) those of a flat marker there,
        ``size`` [m] its width, ``reach`` [px] half the width that is read across an edge; with a larger error than
        ``max_error`` [px] it is doubtful. ``before``: the Sheet in the image before; its shape is tried first.
        """
        axes = np.arange(thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES
        ways = np.arange(2 * thresholds.BEND_AXES) * np.pi / thresholds.BEND_AXES  # a crease has two sides
        flat = [[*cv2.Rodrigues(rotation)[0][:, 0], *position / size] for rotation, position in poses]
        bent = [[bend, axis] for bend in thresholds.BEND_STARTS for axis in axes]
        folded = [[fold, way, thresholds.CREASE_START] for fold in thresholds.FOLD_STARTS for way in ways]
        cylinder, crease = Cylinder(camera, self.cells), Crease(camera, self.cells)
        tries: list[Sequence[tuple[Curved, Sequence[Sequence[float]]]]] = [[(cylinder, bent), (crease, folded)]]
        if before is not None and before.is_bent:
            tries.insert(0, [(cylinder if len(before.shape) == 2 else crease, [before.shape.tolist()])])
        sheet = None
        for models in tries:
            found = [each for model, shapes in models
                     for each in self._fits(grey, model, black, flat, shapes, reach, light)
                     if each.edges.parameters[5] > 0]
            if found:
                best = min(found, key=lambda each: each.edges.cost)
                sheet = self._sheet(best, self._sure(best, found), size, max_error)
                if sheet.is_bent:
                    break
        return sheet

    def _fits(self, grey: Image, model: Curved, black: Bools, flat: Sequence[Sequence[float]],
              shapes: Sequence[Sequence[float]], reach: float, light: Light) -> list[Fit]:
        """Return the Fits of a model from each of the poses ``flat`` and each of ``shapes``."""
        starts = np.array([[*pose, *shape] for pose in flat for shape in shapes])
        pose_of: Integers = np.repeat(np.arange(len(flat)), len(shapes))
        # the axis or crease stays fixed until the end, because flat paper has none
        far = thresholds.FIRST_LOCAL_REACH * reach
        tried = FIRST_PLACES, 7, thresholds.BEND_TRIED, far, thresholds.BEND_CHOSEN
        followed = FIRST_PLACES, 7, thresholds.BEND_STEPS - thresholds.BEND_TRIED, reach, thresholds.BEND_FREED
        freed = PLACES, starts.shape[1], thresholds.BEND_STEPS, far, len(starts)
        for places, free, steps, first_reach, count in (tried, followed, freed):
            fits = model.fit(grey, starts, edge_points(black, places), free, reach, steps, first_reach, light)
            found, pose_of = _best_of_each(pose_of, fits, count)
            if not found:
                return []
            starts = np.array([each.parameters for each in found])
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
        corners = best.model.places(theta, self._square)
        turn_error = float(np.sqrt(np.trace(fit.covariance[:3, :3])))
        bend = best.model.bend(theta)
        unknown = abs(bend) > thresholds.MIN_BEND and turn_error > thresholds.MAX_BENT_TURN  # flat paper has no axis
        doubtful = unknown or fit.error > max_error or fit.seen < thresholds.MIN_BENT_SEEN
        return Sheet(best.rotation, theta[3:6] * size, bend, corners, fit.error, turn_error, sure, doubtful, theta[6:])


def _best_of_each(pose_of: Integers, fits: Sequence[EdgeFit | None], count: int) -> tuple[list[EdgeFit], Integers]:
    """Return the ``count`` best fits of each pose, of those that have enough edges, and which pose (K,) each has."""
    out: list[tuple[EdgeFit, int]] = []
    for pose in np.unique(pose_of):
        seen = [fit for fit, each in zip(fits, pose_of) if fit is not None and each == pose]
        out += [(fit, pose) for fit in sorted(seen, key=lambda each: each.cost)[:count]]
    return [fit for fit, _ in out], np.array([pose for _, pose in out])
