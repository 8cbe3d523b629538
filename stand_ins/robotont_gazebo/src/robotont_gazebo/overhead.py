"""A map of a floor plan seen from above, with paths, robots and markers: for demos, reports and graders. No ROS.

The world's x points to the right and its y up; metres and radians in, a uint8 RGB picture out.
"""
import math
from itertools import cycle
from typing import NamedTuple

import cv2
import numpy as np

from kinematic_core.checks import InvalidInput
from kinematic_core.floor_plan import Box, corners
from kinematic_core.robot_world import ROBOT_RADIUS

PIXELS_PER_METRE, LARGEST = 120.0, 1600  # the scale, and the longest side [px] for which it is made smaller
MARGIN = 56  # [px] around everything: the title stands in it above, the scale and the paths' names below
SMALLEST = 3 * MARGIN  # [px] that `largest` may be
SHIFT = 4  # OpenCV's fractional bits
PAPER, GRID, INK, FAINT = (252, 252, 250), (228, 230, 232), (40, 44, 52), (130, 134, 140)
LOW = 0.1  # [m]: lower solids are drawn pale
MARKER_INK = (176, 32, 40)
PATH_COLOURS = ((22, 96, 196), (222, 120, 20), (34, 140, 84), (140, 60, 170))  # by turns, of paths without a colour
ROBOT_COLOUR = (34, 110, 210)
FONT = cv2.FONT_HERSHEY_SIMPLEX


class Path(NamedTuple):
    """A line to draw: points [(x, y)] [m], gaps where they are not finite; without a colour it gets one by turns."""

    points: object
    colour: tuple = None  # (r, g, b)
    label: str = ''
    dashed: bool = False


class Overhead:
    """The map of a FloorPlan in which `also`, further points [(x, y)] [m], must have room, too.

    width, height [px]; pixels_per_metre: its scale, made smaller where the longer side would exceed `largest` px.
    Raises InvalidInput for a scale or a size that cannot be.
    """

    def __init__(self, plan, also=(), pixels_per_metre=PIXELS_PER_METRE, largest=LARGEST):
        if not (math.isfinite(pixels_per_metre) and pixels_per_metre > 0.0 and largest >= SMALLEST):
            raise InvalidInput(f'a map with {pixels_per_metre!r} px/m and at most {largest!r} px: the scale must be '
                               f'more than 0, the size at least {SMALLEST} px')
        self._plan = plan
        low, high = _bounds(plan, also)
        self.pixels_per_metre = min(float(pixels_per_metre), (largest - 2 * MARGIN) / max((high - low).max(), 1e-3))
        self.width, self.height = (math.ceil(side * self.pixels_per_metre) + 2 * MARGIN for side in high - low)
        self._left, self._upper = low[0] - MARGIN / self.pixels_per_metre, high[1] + MARGIN / self.pixels_per_metre
        self._ground = self._draw_plan()

    def pixel(self, x, y):
        """Return where (x, y) [m] is in the picture: column, row [px], as floats."""
        return (x - self._left) * self.pixels_per_metre - 0.5, (self._upper - y) * self.pixels_per_metre - 0.5

    def draw(self, paths=(), robots=(), title=''):
        """Return the map, (height, width, 3) uint8 RGB, with Paths, and robots (x, y, yaw) as discs with a heading."""
        picture = self._ground.copy()
        paths = [path._replace(colour=path.colour or colour) for path, colour in zip(paths, cycle(PATH_COLOURS))]
        for path in paths:
            self._draw_path(picture, path)
        for robot in robots:
            self._draw_robot(picture, *robot)
        self._draw_words(picture, title, [path for path in paths if path.label])
        return picture

    # -------------------------------------------------------------------------------------------------- the plan

    def _draw_plan(self):
        picture = np.empty((self.height, self.width, 3), np.uint8)
        picture[:] = PAPER
        self._draw_grid(picture)
        solids = sorted((*self._plan.boxes, *self._plan.cylinders), key=lambda shape: shape.bottom + shape.height)
        for shape in solids:
            pale = 0.6 if shape.bottom + shape.height <= LOW else 0.0
            fill = tuple(part + (255 - part) * pale for part in shape.colour)
            rim = FAINT if pale else INK
            if isinstance(shape, Box):
                self._polygon(picture, corners(shape), fill, rim)
            else:
                self._disc(picture, shape.x, shape.y, shape.radius, fill, rim)
        for panel in self._plan.panels:
            self._draw_panel(picture, panel)
        self._draw_scale(picture)
        return picture

    def _draw_grid(self, picture):
        right = self._left + self.width / self.pixels_per_metre
        lower = self._upper - self.height / self.pixels_per_metre
        step = max(1, math.ceil(20.0 / self.pixels_per_metre))
        for x in range(math.ceil(self._left / step) * step, math.floor(right) + 1, step):
            self._line(picture, [(x, lower), (x, self._upper)], FAINT if x == 0 else GRID, 1)
        for y in range(math.ceil(lower / step) * step, math.floor(self._upper) + 1, step):
            self._line(picture, [(self._left, y), (right, y)], FAINT if y == 0 else GRID, 1)

    def _draw_panel(self, picture, panel):
        along = -math.sin(panel.yaw) * panel.size / 2, math.cos(panel.yaw) * panel.size / 2
        ends = [(panel.x - along[0], panel.y - along[1]), (panel.x + along[0], panel.y + along[1])]
        self._line(picture, ends, MARKER_INK, max(2, round(0.04 * self.pixels_per_metre)))
        look = -math.cos(panel.yaw), -math.sin(panel.yaw)
        tip = panel.x + 0.1 * look[0], panel.y + 0.1 * look[1]
        self._line(picture, [(panel.x, panel.y), tip], MARKER_INK, 2)
        self._text(picture, panel.x + 0.24 * look[0], panel.y + 0.24 * look[1], str(panel.marker_id), MARKER_INK)

    def _scale_length(self):
        return max(1, math.ceil(30.0 / self.pixels_per_metre))  # [m]

    def _draw_scale(self, picture):
        length, row = self._scale_length(), self.height - 14
        right = 14 + round(length * self.pixels_per_metre)
        cv2.line(picture, (14, row), (right, row), INK, 2)
        for column in (14, right):
            cv2.line(picture, (column, row - 4), (column, row + 4), INK, 2)
        _write(picture, f'{length} m', (20, row - 6), 0.42, INK)

    # ------------------------------------------------------------------------------------------- what is on top of it

    def _draw_path(self, picture, path):
        points = np.asarray(list(path.points), float).reshape(-1, 2)
        finite = np.isfinite(points).all(1)
        starts = np.flatnonzero(finite & ~np.concatenate([[False], finite[:-1]]))
        for start in starts:
            end = start + int(np.argmin(np.append(finite[start:], False)))
            part = points[start:end]
            for piece in (_dashes(part, 10 / self.pixels_per_metre) if path.dashed else [part]):
                self._line(picture, piece, path.colour, 2)
        if len(starts):
            self._disc(picture, *points[starts[0]], 4.5 / self.pixels_per_metre, PAPER, path.colour, 2)

    def _draw_robot(self, picture, x, y, yaw):
        if not all(map(math.isfinite, (x, y, yaw))):
            raise InvalidInput(f'robot at {(x, y, yaw)!r}: x, y [m] and yaw [rad] must be finite')
        self._disc(picture, x, y, ROBOT_RADIUS, ROBOT_COLOUR, INK)
        cos, sin = math.cos(yaw), math.sin(yaw)
        arrow = [(0.9, 0.0), (-0.35, 0.5), (-0.1, 0.0), (-0.35, -0.5)]
        self._polygon(picture, [(x + ROBOT_RADIUS * (a * cos - b * sin), y + ROBOT_RADIUS * (a * sin + b * cos))
                                for a, b in arrow], (255, 255, 255), None)

    def _draw_words(self, picture, title, paths):
        _write(picture, title, (14, 24), 0.55, INK)
        column, row = 2 * 14 + round(self._scale_length() * self.pixels_per_metre) + 14, self.height - 12
        for path in paths:
            cv2.line(picture, (column, row - 4), (column + 22, row - 4), path.colour, 2, cv2.LINE_AA)
            column += 28 + _write(picture, path.label, (column + 28, row), 0.45, INK) + 16

    # ---------------------------------------------------------------------------------------------------- OpenCV's own

    def _fine(self, points):
        pixels = np.array([self.pixel(x, y) for x, y in points])
        return np.round(np.clip(pixels, -8000, 8000) * 2 ** SHIFT).astype(np.int32)

    def _line(self, picture, points, colour, width):
        cv2.polylines(picture, [self._fine(points)], False, colour, width, cv2.LINE_AA, SHIFT)

    def _polygon(self, picture, points, colour, rim):
        cv2.fillPoly(picture, [self._fine(points)], colour, cv2.LINE_AA, SHIFT)
        if rim:
            cv2.polylines(picture, [self._fine(points)], True, rim, 1, cv2.LINE_AA, SHIFT)

    def _disc(self, picture, x, y, radius, colour, rim, width=1):
        (middle,), size = self._fine([(x, y)]), round(radius * self.pixels_per_metre * 2 ** SHIFT)
        cv2.circle(picture, middle.tolist(), size, colour, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(picture, middle.tolist(), size, rim, width, cv2.LINE_AA, SHIFT)

    def _text(self, picture, x, y, text, colour, size=0.6):
        (width, height), _ = cv2.getTextSize(text, FONT, size, 1)
        column, row = self.pixel(x, y)
        _write(picture, text, (round(column - width / 2), round(row + height / 2)), size, colour)


def picture(plan, paths=(), robots=(), title='', **size):
    """Return the map of a FloorPlan with all of these in it, (height, width, 3) uint8 RGB; see Overhead and draw."""
    also = [point for path in paths for point in path.points] + [robot[:2] for robot in robots]
    return Overhead(plan, also, **size).draw(paths, robots, title)


def _write(picture, text, place, size, colour):
    """Write a text with a pale rim from `place` (column, row) on; return its width [px]."""
    for ink, width in ((PAPER, 4), (colour, 1)):
        cv2.putText(picture, text, place, FONT, size, ink, width, cv2.LINE_AA)
    return cv2.getTextSize(text, FONT, size, 1)[0][0]


def _bounds(plan, also):
    """Return the lowest and the highest (x, y) [m] of the map."""
    points = [corner for box in plan.boxes for corner in corners(box)]
    points += [(c.x + side * c.radius, c.y + side * c.radius) for c in plan.cylinders for side in (-1, 1)]
    points += [(panel.x, panel.y) for panel in plan.panels]
    points += [(float(x), float(y)) for x, y in also if math.isfinite(x) and math.isfinite(y)]
    points = np.array(points or [(-1.0, -1.0), (1.0, 1.0)])
    return points.min(0), points.max(0)


def _dashes(points, length):
    """Return every other piece, `length` long, of the line through points (N, 2)."""
    if len(points) < 2:
        return []
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    pieces = []
    for start in np.arange(0.0, way[-1], 2 * length):
        stop = min(start + length, way[-1])
        at = np.concatenate([[start], way[(way > start) & (way < stop)], [stop]])
        pieces.append(np.stack([np.interp(at, way, points[:, k]) for k in (0, 1)], 1))
    return pieces
