"""Rays on a floor plan, and a laser scanner that uses them."""
import math
from typing import NamedTuple

import numpy as np

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan
from kinematic_core.worlds.robot_world import SCAN_NOISE

RAYS = 720
FIRST_ANGLE = -math.pi  # [rad] of the first ray, from the scanner's x axis; the last one points the same way
LAST_ANGLE = math.pi
NEAREST = 0.10  # [m]
FARTHEST = 30.0  # [m]
_JOINED = 1.0 - 1e-9  # makes sides slightly longer, so that no ray passes between two of them


class RayCaster:
    """Finds where horizontal rays at one height end on the solids of a FloorPlan."""

    def __init__(self, plan: FloorPlan, height: float, angles: np.ndarray) -> None:
        """Cut the solids with a plane at ``height`` [m]; ``angles`` (rays,) [rad] count from the heading."""
        cut = [solid for solid in plan.bodies() if solid.bottom < height < solid.bottom + solid.height]
        boxes = [solid for solid in cut if isinstance(solid, Box)]
        rounds = [solid for solid in cut if isinstance(solid, Cylinder)]
        self._boxes = np.array([(box.x, box.y, box.yaw, box.length / 2.0, box.width / 2.0) for box in boxes],
                               float).reshape(-1, 5).T
        self._rounds = np.array([(solid.x, solid.y, solid.radius) for solid in rounds],
                                float).reshape(-1, 3).T[:, :, None]
        self._rays = np.array([np.cos(angles), np.sin(angles)])  # directions from the heading, (2, rays)

    def ranges(self, x: float, y: float, yaw: float) -> np.ndarray:
        """Return the distance (rays,) [m] from (x, y), heading yaw, to the first solid; inf: none, 0: inside one."""
        found = np.full(self._rays.shape[1], np.inf)
        if self._boxes.size:
            np.minimum(found, self._to_boxes(x, y, yaw), out=found)
        if self._rounds.size:
            np.minimum(found, self._to_rounds(x, y, yaw), out=found)
        return found

    def _to_boxes(self, x: float, y: float, yaw: float) -> np.ndarray:
        """Return the distances (rays,) to the nearest box.

        In a box's frame the scanner is at (along, across), and a ray's direction (a, b) is made of its cos and sin by
        the factors ``ahead`` and ``aside``. The ray crosses the line of a side that is ``beyond`` away at the inverse
        distance u = a / beyond, and does so within the side, w wide to both hands, where abs(across u + b) <= w u.
        """
        box_x, box_y, box_yaw, half_length, half_width = self._boxes
        cos, sin = np.cos(box_yaw), np.sin(box_yaw)
        along, across = cos * (x - box_x) + sin * (y - box_y), cos * (y - box_y) - sin * (x - box_x)
        cos, sin = np.cos(yaw - box_yaw), np.sin(yaw - box_yaw)
        ahead, aside = np.array([cos, -sin]), np.array([sin, cos])
        sides = [_sides(along, half_length, across, half_width, ahead, aside),
                 _sides(across, half_width, along, half_length, aside, ahead)]
        if np.any(~sides[0].seen & ~sides[1].seen):
            return np.zeros(self._rays.shape[1])
        inverse = np.concatenate([side.inverse for side in sides], axis=1).T @ self._rays  # (sides, rays)
        offset = np.concatenate([side.offset for side in sides], axis=1).T @ self._rays
        inverse *= np.abs(offset, out=offset) <= inverse
        best = inverse.max(axis=0)
        distances: np.ndarray = np.divide(1.0, best, out=np.full(best.shape, np.inf), where=best > 0.0)
        return distances

    def _to_rounds(self, x: float, y: float, yaw: float) -> np.ndarray:
        """Return the distances (rays,) to the nearest cylinder, from the ray's nearest point to the axis backwards."""
        round_x, round_y, radius = self._rounds
        cos, sin = self._rays
        to_x, to_y = round_x - x, round_y - y
        axis_x = math.cos(yaw) * to_x + math.sin(yaw) * to_y  # the axes in the scanner's frame, (cylinders, 1)
        axis_y = math.cos(yaw) * to_y - math.sin(yaw) * to_x
        nearest = axis_x * cos + axis_y * sin
        square = radius * radius - (axis_x * sin - axis_y * cos) ** 2
        half = np.sqrt(np.maximum(square, 0.0))
        entry = nearest - half
        entry[(square < 0.0) | (nearest + half < 0.0)] = np.inf
        distances: np.ndarray = np.maximum(entry.min(axis=0), 0.0)
        return distances


class _Sides(NamedTuple):
    """One pair of opposite sides of each box: which of them are visible, and factors of the rays' cos and sin."""

    seen: np.ndarray  # (boxes,), bool
    inverse: np.ndarray  # (2, visible sides) of the inverse distance [1/m]
    offset: np.ndarray  # (2, visible sides) of the position along the side, in half widths, times the inverse distance


def _sides(out: np.ndarray, half_depth: np.ndarray, along: np.ndarray, half_width: np.ndarray,
           outwards: np.ndarray, sidewards: np.ndarray) -> _Sides:
    """Return the pair of sides across one axis; ``out`` (boxes,) [m]: the scanner's coordinate on that axis."""
    beyond = np.abs(out) - half_depth
    seen = beyond > 0.0
    inverse = outwards[:, seen] * (np.copysign(1.0, -out[seen]) / beyond[seen])
    offset = (along[seen] * inverse + sidewards[:, seen]) * (_JOINED / half_width[seen])
    return _Sides(seen, inverse, offset)


class LaserScanner:
    """A scanner of RAYS rays all around, with gaussian noise from a generator of its own."""

    def __init__(self, plan: FloorPlan, height: float, noise: float = SCAN_NOISE, seed: int = 0) -> None:
        """Scan ``plan`` at ``height`` [m]; ``noise`` [m] is the standard deviation of each range."""
        self._height, self._noise = height, noise
        self._random = np.random.default_rng(seed)
        self.set_plan(plan)

    def set_plan(self, plan: FloorPlan) -> None:
        """Scan another plan from now on."""
        self._caster = RayCaster(plan, self._height, np.linspace(FIRST_ANGLE, LAST_ANGLE, RAYS))

    def scan(self, x: float, y: float, yaw: float) -> np.ndarray:
        """Return the ranges (RAYS,) float64 [m] that a scanner at (x, y) [m] with heading yaw [rad] measures.

        They are inf beyond FARTHEST and never less than NEAREST.
        """
        ranges = self._caster.ranges(x, y, yaw)
        if self._noise:
            ranges += self._random.normal(0.0, self._noise, RAYS)
        np.maximum(ranges, NEAREST, out=ranges)
        ranges[ranges > FARTHEST] = np.inf
        return ranges
