"""Draw a map of a floor plan from above, with paths, robots and markers, for demos, reports and graders. No ROS.

The world's x points to the right and its y up. Positions are in metres, headings in radians; images are uint8 RGB.
"""
import math
from typing import Iterable, List, NamedTuple, Optional, Sequence, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.floor_plan import Box, Colour, FloorPlan, Panel, Solid, corners
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.robot_world import ROBOT_RADIUS

PIXELS_PER_METRE = 120.0  # the default scale
LARGEST = 1600  # [px] the longest side; the scale is reduced for larger maps
MARGIN = 56  # [px] around everything: the title is in the upper one, the scale and the paths' labels in the lower one
NARROWEST = 420  # [px] wide, for the scale and a path's label side by side
SHIFT = 4  # fractional bits of OpenCV's drawing coordinates
PAPER, GRID, INK, FAINT = (252, 252, 250), (228, 230, 232), (40, 44, 52), (130, 134, 140)
LOW = 0.1  # [m] solids lower than this are drawn pale
MARKER_INK = (176, 32, 40)
PATH_COLOUR = (22, 96, 196)
ROBOT_COLOUR = (34, 110, 210)
FONT = cv2.FONT_HERSHEY_SIMPLEX

XY = Sequence[float]  # x, y [m]


class Path(NamedTuple):
    """A path through points [(x, y)] [m]."""

    points: Sequence[XY]
    label: str = ''


class FloorPlanMap:
    """The map of a FloorPlan, large enough to show the points ``also`` [(x, y)] [m], or only a part of the plan.

    between: lower left and upper right corner of that part [(x, y)] [m]; around it, the margin shows the plan, too.
    width, height [px]; pixels_per_metre: its scale, reduced if the longer side would exceed LARGEST px.
    """

    def __init__(self, plan: FloorPlan, also: Iterable[XY] = (), pixels_per_metre: float = PIXELS_PER_METRE,
                 between: Optional[Sequence[XY]] = None) -> None:
        self._plan = plan
        low, high = _bounds(plan, also) if between is None else np.array(between, float)
        self.pixels_per_metre = min(float(pixels_per_metre), (LARGEST - 2 * MARGIN) / max((high - low).max(), 1e-3))
        width, self.height = (math.ceil(side * self.pixels_per_metre) + 2 * MARGIN for side in high - low)
        self.width = max(width, NARROWEST)
        self._left = low[0] - (MARGIN + (self.width - width) / 2.0) / self.pixels_per_metre
        self._upper = high[1] + MARGIN / self.pixels_per_metre
        self._ground = self._draw_plan()

    def pixel(self, x: float, y: float) -> Tuple[float, float]:
        """Return the pixel (column, row), as floats, of the point (x, y) [m]."""
        return (x - self._left) * self.pixels_per_metre - 0.5, (self._upper - y) * self.pixels_per_metre - 0.5

    def draw(self, paths: Sequence[Path] = (), robots: Iterable[Pose2D] = (), title: str = '') -> np.ndarray:
        """Return the map, (height, width, 3) uint8 RGB, with paths, and robots as discs with their heading."""
        image = self._ground.copy()
        for path in paths:
            self._draw_path(image, path)
        for robot in robots:
            self._draw_robot(image, Pose2D(*robot))
        self._draw_texts(image, title, [path.label for path in paths if path.label])
        return image

    # -------------------------------------------------------------------------------------------------- the plan

    def _draw_plan(self) -> np.ndarray:
        image: np.ndarray = np.empty((self.height, self.width, 3), np.uint8)
        image[:] = PAPER
        self._draw_grid(image)
        solids: List[Solid] = [*self._plan.boxes, *self._plan.cylinders]
        solids.sort(key=lambda shape: shape.bottom + shape.height)
        for shape in solids:
            pale = 0.6 if shape.bottom + shape.height <= LOW else 0.0
            fill = [part + (255 - part) * pale for part in shape.colour]
            rim = FAINT if pale else INK
            if isinstance(shape, Box):
                self._polygon(image, corners(shape), fill, rim)
            else:
                self._disc(image, shape.x, shape.y, shape.radius, fill, rim)
        for panel in self._plan.panels:
            self._draw_panel(image, panel)
        self._draw_scale(image)
        return image

    def _draw_grid(self, image: np.ndarray) -> None:
        right = self._left + self.width / self.pixels_per_metre
        lower = self._upper - self.height / self.pixels_per_metre
        step = max(1, math.ceil(20.0 / self.pixels_per_metre))
        for x in range(math.ceil(self._left / step) * step, math.floor(right) + 1, step):
            self._line(image, [(x, lower), (x, self._upper)], FAINT if x == 0 else GRID, 1)
        for y in range(math.ceil(lower / step) * step, math.floor(self._upper) + 1, step):
            self._line(image, [(self._left, y), (right, y)], FAINT if y == 0 else GRID, 1)

    def _draw_panel(self, image: np.ndarray, panel: Panel) -> None:
        along = -math.sin(panel.yaw) * panel.size / 2, math.cos(panel.yaw) * panel.size / 2
        ends = [(panel.x - along[0], panel.y - along[1]), (panel.x + along[0], panel.y + along[1])]
        self._line(image, ends, MARKER_INK, max(2, round(0.04 * self.pixels_per_metre)))
        normal = -math.cos(panel.yaw), -math.sin(panel.yaw)
        tip = panel.x + 0.1 * normal[0], panel.y + 0.1 * normal[1]
        self._line(image, [(panel.x, panel.y), tip], MARKER_INK, 2)
        self._text(image, panel.x + 0.24 * normal[0], panel.y + 0.24 * normal[1], str(panel.marker_id), MARKER_INK, 0.8)

    def _scale_length(self) -> int:
        """Return the length [m] of the scale bar."""
        return max(1, math.ceil(30.0 / float(self.pixels_per_metre)))

    def _draw_scale(self, image: np.ndarray) -> None:
        length, row = self._scale_length(), self.height - 14
        right = 14 + round(length * self.pixels_per_metre)
        cv2.line(image, (14, row), (right, row), INK, 2)
        for column in (14, right):
            cv2.line(image, (column, row - 4), (column, row + 4), INK, 2)
        _write(image, f'{length} m', (20, row - 8), 0.6, INK)

    # ------------------------------------------------------------------------------------------------- paths and robots

    def _draw_path(self, image: np.ndarray, path: Path) -> None:
        self._line(image, path.points, PATH_COLOUR, 2)
        x, y = path.points[0]
        self._disc(image, x, y, 4.5 / self.pixels_per_metre, PAPER, PATH_COLOUR, 2)

    def _draw_robot(self, image: np.ndarray, pose: Pose2D) -> None:
        x, y, yaw = pose
        self._disc(image, x, y, ROBOT_RADIUS, ROBOT_COLOUR, INK)
        cos, sin = math.cos(yaw), math.sin(yaw)
        arrow = [(0.9, 0.0), (-0.35, 0.5), (-0.1, 0.0), (-0.35, -0.5)]
        self._polygon(image, [(x + ROBOT_RADIUS * (a * cos - b * sin), y + ROBOT_RADIUS * (a * sin + b * cos))
                                for a, b in arrow], (255, 255, 255), None)

    def _draw_texts(self, image: np.ndarray, title: str, labels: Sequence[str]) -> None:
        _write(image, title, (14, 30), 0.8, INK)
        column, row = 2 * 14 + round(self._scale_length() * self.pixels_per_metre) + 14, self.height - 12
        for label in labels:
            cv2.line(image, (column, row - 4), (column + 22, row - 4), PATH_COLOUR, 2, cv2.LINE_AA)
            column += 28 + _write(image, label, (column + 28, row), 0.65, INK) + 16

    # --------------------------------------------------------------------------------------------- drawing with OpenCV

    def _fixed_point(self, points: Iterable[XY]) -> np.ndarray:
        """Return points [m] as pixels (N, 2) int32 with SHIFT fractional bits."""
        pixels = np.array([self.pixel(x, y) for x, y in points])
        fixed: np.ndarray = np.round(np.clip(pixels, -8000, 8000) * 2 ** SHIFT).astype(np.int32)
        return fixed

    def _line(self, image: np.ndarray, points: Iterable[XY], colour: Colour, width: int) -> None:
        cv2.polylines(image, [self._fixed_point(points)], False, colour, width, cv2.LINE_AA, SHIFT)

    def _polygon(self, image: np.ndarray, points: Iterable[XY], colour: Sequence[float], rim: Optional[Colour]) -> None:
        outline = self._fixed_point(points)
        cv2.fillPoly(image, [outline], colour, cv2.LINE_AA, SHIFT)
        if rim:
            cv2.polylines(image, [outline], True, rim, 1, cv2.LINE_AA, SHIFT)

    def _disc(self, image: np.ndarray, x: float, y: float, radius: float, colour: Sequence[float], rim: Colour,
              width: int = 1) -> None:
        (middle,), size = self._fixed_point([(x, y)]), round(radius * self.pixels_per_metre * 2 ** SHIFT)
        cv2.circle(image, middle.tolist(), size, colour, -1, cv2.LINE_AA, SHIFT)
        cv2.circle(image, middle.tolist(), size, rim, width, cv2.LINE_AA, SHIFT)

    def _text(self, image: np.ndarray, x: float, y: float, text: str, colour: Colour, size: float) -> None:
        (width, height), _ = cv2.getTextSize(text, FONT, size, 1)
        column, row = self.pixel(x, y)
        _write(image, text, (round(column - width / 2), round(row + height / 2)), size, colour)


def draw_map(plan: FloorPlan, paths: Sequence[Path] = (), robots: Sequence[Pose2D] = (), title: str = '',
             pixels_per_metre: float = PIXELS_PER_METRE, between: Optional[Sequence[XY]] = None) -> np.ndarray:
    """Return the map of a FloorPlan that shows all of these, (height, width, 3) uint8 RGB; see FloorPlanMap."""
    also = [point for path in paths for point in path.points] + [robot[:2] for robot in robots]
    return FloorPlanMap(plan, also, pixels_per_metre, between).draw(paths, robots, title)


def _write(image: np.ndarray, text: str, start: Tuple[int, int], size: float, colour: Colour) -> int:
    """Write a text with a pale outline, its lower left corner at ``start`` (column, row); return its width [px]."""
    for ink, width in ((PAPER, 4), (colour, 1)):
        cv2.putText(image, text, start, FONT, size, ink, width, cv2.LINE_AA)
    return cv2.getTextSize(text, FONT, size, 1)[0][0]


def _bounds(plan: FloorPlan, also: Iterable[XY]) -> Tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest (x, y) [m] on the map, (2,) each."""
    points = [corner for box in plan.boxes for corner in corners(box)]
    points += [(c.x + side * c.radius, c.y + side * c.radius) for c in plan.cylinders for side in (-1, 1)]
    points += [(panel.x, panel.y) for panel in plan.panels]
    points += [(float(x), float(y)) for x, y in also]
    bounds = np.array(points or [(-1.0, -1.0), (1.0, 1.0)])
    return bounds.min(0), bounds.max(0)
