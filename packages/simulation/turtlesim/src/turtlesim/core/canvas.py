"""The turtles' canvas: 500 x 500 RGB pixels and the strokes of the pens on them. Needs neither ROS nor numpy.

A stroke sets exactly the pixels that the raster engine of Qt 5.15 sets for QPainter.drawLine between two QPointF
with a solid pen of integer width, square caps and no anti-aliasing. The rules are those of Qt's cosmetic stroker
(width 1) and line rasterizer (width 2 and more), compared with PyQt5 5.15. OpenCV cannot be used for it: its
fillConvexPoly strokes the outline too, and at best about 4 % of a stroke's pixels differ.

Positions are given in metres with y down, origin in the upper left corner; everything private is in pixels. Fixed-point
numbers have as many bits as Qt's, since the last one decides: 6 for the ends of thin lines, 16 for slopes and edges.
"""
from math import floor, sqrt
from typing import TYPE_CHECKING, Optional, Tuple

from kinematic_core.worlds.turtle_world import BACKGROUND, CANVAS_SIZE, PIXELS_PER_METRE, Colour, Stroke

if TYPE_CHECKING:
    import numpy as np

ROW_BYTES = 3 * CANVAS_SIZE
LAST = CANVAS_SIZE - 1  # [px] the last row and column
END_COLUMN = CANVAS_SIZE << 16  # the column after the last, with 16 more bits
SNAP = 64  # corners of slanted lines lie on a grid of 1/64 px
VERTICAL = 1e20  # replaces the slope of an edge without height

Line = Tuple[float, float, float, float]  # x0, y0, x1, y1 [px]
# An edge of a filled area: a row, the edge's column there, and the columns per row; the last two have 16 more bits.
# Plain tuples, because a stroke has four: with named tuples, a drawing turtle takes a tenth more time.
Edge = Tuple[int, int, int]


class Canvas:
    """A square image of CANVAS_SIZE px, kept as RGB bytes row by row. Not thread-safe: its owner locks it."""

    def __init__(self, background: Colour = BACKGROUND) -> None:
        """Start with one colour, (r, g, b) in 0..255."""
        self._pixels = bytearray(3 * CANVAS_SIZE * CANVAS_SIZE)
        self.fill(background)

    def fill(self, rgb: Colour) -> None:
        """Fill the canvas with the colour (r, g, b), 0..255 each."""
        self._pixels[:] = bytes(rgb) * (CANVAS_SIZE * CANVAS_SIZE)

    def draw(self, stroke: Stroke) -> None:
        """Draw a Stroke or a tuple like it: (x0, y0_down, x1, y1_down, (r, g, b), width), finite, in metres and px.

        Both ends may lie outside the canvas, at any distance. Swapping them changes single pixels.
        """
        x0, y0, x1, y1, rgb, width = stroke
        x0 *= PIXELS_PER_METRE
        y0 *= PIXELS_PER_METRE
        x1 *= PIXELS_PER_METRE
        y1 *= PIXELS_PER_METRE
        pixel = bytes(rgb)
        point = _same(x0, x1) and _same(y0, y1)
        if width <= 1:
            if point:
                self._dot(_nearest(x0), _nearest(y0), pixel)
            else:
                self._thin(x0, y0, x1, y1, pixel)
            return
        if point:  # a square, drawn as a flat line without caps; far away, double precision rounds its length to 0
            x0, x1, y1 = x0 - width * 0.5, x0 + width * 0.5, y0
            if _same(x0, x1):
                return
        length = abs(complex(x1 - x0, y1 - y0))  # the C library's hypot, as in Qt; math.hypot rounds differently
        self._band(x0, y0, x1, y1, pixel, width / length, 0.0 if point else 0.5)

    def color_at(self, x: float, y_down: float) -> Colour:
        """Return the colour (r, g, b) of the pixel nearest to a point in metres; ValueError outside the canvas."""
        column = int(x * PIXELS_PER_METRE + 0.5)
        row = int(y_down * PIXELS_PER_METRE + 0.5)
        if not (0 <= column <= LAST and 0 <= row <= LAST):
            raise ValueError(f'no pixel at x={x!r}, y_down={y_down!r} m: both must be 0 to {LAST / PIXELS_PER_METRE}')
        start = row * ROW_BYTES + 3 * column
        pixels = self._pixels
        return pixels[start], pixels[start + 1], pixels[start + 2]

    def tobytes(self) -> bytes:
        """Return the pixels: rows from the top, three bytes (r, g, b) per pixel."""
        return bytes(self._pixels)

    def array(self) -> 'np.ndarray':
        """Return a copy as numpy array (CANVAS_SIZE, CANVAS_SIZE, 3), uint8, RGB; imports numpy."""
        import numpy
        return numpy.frombuffer(self.tobytes(), numpy.uint8).reshape(CANVAS_SIZE, CANVAS_SIZE, 3).copy()

    def _dot(self, column: int, row: int, pixel: bytes) -> None:
        if 0 <= column <= LAST and 0 <= row <= LAST:
            start = row * ROW_BYTES + 3 * column
            self._pixels[start:start + 3] = pixel

    def _thin(self, x0: float, y0: float, x1: float, y1: float, pixel: bytes) -> None:
        """Draw width 1: one pixel per row of a steep line or per column of a flat one, both ends half a px further."""
        ends = _clip_thin(x0, y0, x1, y1)
        if ends is None:
            return
        u0, v0, u1, v1 = (int(value * 64.0) for value in ends)  # u along the line, v across
        steep = abs(u1 - u0) < abs(v1 - v0)
        if steep:
            u0, v0, u1, v1 = v0, u0, v1, u1
        if u0 == u1:
            return  # shorter than 1/64 px: Qt draws nothing
        if u0 > u1:
            u0, v0, u1, v1 = u1, v1, u0, v0
        slope = int(((v1 - v0) << 16) / (u1 - u0))
        first, end = u0 >> 6, (u1 + 64) >> 6
        middle = 32 if slope > 0 else 0
        across = (v0 << 10) - (slope >> 1) + (((first << 6) + middle - (u0 - 32)) * slope >> 6)
        for along in range(first, end):
            if steep:
                self._dot(across >> 16, along, pixel)
            else:
                self._dot(along, across >> 16, pixel)
            across += slope

    def _band(self, x0: float, y0: float, x1: float, y1: float, pixel: bytes, width: float, cap: float) -> None:
        """Draw a wider line; ``width`` and then ``cap`` are ratios: of width to length, of cap to width."""
        ends = _clip_band(x0, y0, x1, y1, width, cap)
        if ends is None:
            return
        square = (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0)
        x0, y0, x1, y1 = ends
        dx, dy = x1 - x0, y1 - y0
        if dx == dy == 0:
            return
        width *= sqrt(square / (dx * dx + dy * dy))
        if -1 < dy * SNAP < 1:  # flat: the same area as an upright line
            reach = width * (abs(dx) * 0.5)
            x0 = x1 = (x0 + x1) * 0.5
            y0, y1 = y0 - reach, y0 + reach
            width, dx = 1 / width, 0.0
        if y0 > y1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        if -1 < dx * SNAP < 1:
            reach = 0.5 * width * (y1 - y0)
            self._box(x0 - reach, y0, x0 + reach, y1, pixel)
        else:
            self._slanted(x0, y0, x1, y1, pixel, 0.5 * width)

    def _box(self, left: float, top: float, right: float, bottom: float, pixel: bytes) -> None:
        left, top, right, bottom = _inside(left), _inside(top), _inside(right), _inside(bottom)
        if (right - left) * SNAP >= 1 and (bottom - top) * SNAP >= 1:
            left_edge, right_edge = (0, int(left + 0.5) << 16, 0), (0, _last_before(right) << 16, 0)
            self._rows(int(top + 0.5), _last_before(bottom), left_edge, right_edge, pixel)

    def _slanted(self, x0: float, y0: float, x1: float, y1: float, pixel: bytes, half: float) -> None:
        """Draw the tilted rectangle round a line from its upper to its lower end; half: half its width / length."""
        dx, dy = (x1 - x0) * half, (y1 - y0) * half
        one, two = _snap(x0 + dy, y0 - dx), _snap(x0 - dy, y0 + dx)
        three, four = _snap(x1 + dy, y1 - dx), _snap(x1 - dy, y1 + dx)
        top, left, right, bottom = (one, two, three, four) if x0 < x1 else (two, four, one, three)
        first = int(top[1] + 0.5)
        left_turn, right_turn = _last_before(left[1]), _last_before(right[1])
        upper_left, lower_left = _edge(top, left, first, 0.5), _edge(left, bottom, left_turn + 1, 0.5)
        upper_right, lower_right = _edge(top, right, first, -0.5), _edge(right, bottom, right_turn + 1, -0.5)
        if left_turn < right_turn:
            turn, next_turn, middle_left, middle_right = left_turn, right_turn, lower_left, upper_right
        else:
            turn, next_turn, middle_left, middle_right = right_turn, left_turn, upper_left, lower_right
        self._rows(first, turn, upper_left, upper_right, pixel)
        self._rows(turn + 1, next_turn, middle_left, middle_right, pixel)
        self._rows(next_turn + 1, _last_before(bottom[1]), lower_left, lower_right, pixel)

    def _rows(self, first: int, last: int, left_edge: Edge, right_edge: Edge, pixel: bytes) -> None:
        """Fill the rows ``first`` to ``last`` between two edges."""
        if first < 0:
            first = 0
        if last > LAST:
            last = LAST
        row, left, left_step = left_edge
        left += left_step * (first - row)
        row, right, right_step = right_edge
        right += right_step * (first - row)
        pixels = self._pixels
        for start in range(first * ROW_BYTES, (last + 1) * ROW_BYTES, ROW_BYTES):
            first_column = left >> 16 if left > 0 else 0
            last_column = right >> 16 if right < END_COLUMN else LAST
            if first_column <= last_column:
                pixels[start + 3 * first_column:start + 3 * last_column + 3] = pixel * (last_column - first_column + 1)
            left += left_step
            right += right_step


def _same(a: float, b: float) -> bool:
    """Return whether Qt considers two coordinates equal: in 12 digits, near zero within 1e-12."""
    if a and b:
        return abs(a - b) * 1e12 <= min(abs(a), abs(b))
    return abs(a - b) <= 1e-12


def _nearest(value: float) -> int:
    """Round as Qt's 32 bits do, which turn everything far below zero into 0."""
    return min(max(floor(value + 0.5), -2 ** 32), 2 ** 31) & 0xFFFFFFFF


def _inside(value: float) -> float:
    return min(max(value, 0.0), float(CANVAS_SIZE))


def _last_before(edge: float) -> int:
    """Return the last row (or column) whose centre lies before an edge, at least -1."""
    return -1 if edge < 0.5 else int(edge - 0.5)


def _snap(x: float, y: float) -> Tuple[float, float]:
    return floor(x * SNAP) / SNAP, floor(y * SNAP) / SNAP


def _edge(upper: Tuple[float, float], lower: Tuple[float, float], row: int, bias: float) -> Edge:
    """Return the edge from ``upper`` to ``lower``, with its column, plus ``bias``, in the middle of a row."""
    height = lower[1] - upper[1]
    if height:
        slope = (lower[0] - upper[0]) / height
    elif lower[0] > upper[0]:
        slope = VERTICAL
    else:
        slope = -VERTICAL
    return row, int((upper[0] + bias + (row + 0.5 - upper[1]) * slope) * 65536.0), int(slope * 65536.0)


def _clip_thin(x0: float, y0: float, x1: float, y1: float) -> Optional[Line]:
    """Clip a thin line one pixel outside the canvas; None: nothing is left.

    The order of the axes shows in the last bit.
    """
    for _ in range(2):  # by columns first, then, with x and y exchanged, by rows
        low, high = -1.0, CANVAS_SIZE + 1.0
        if (x0 < low and x1 <= low) or (x0 > high and x1 >= high):
            return None
        if not low <= x0 <= high:
            edge = low if x0 < low else high
            y0 += (y1 - y0) / (x1 - x0) * (edge - x0)
            x0 = edge
        if not low <= x1 <= high:
            edge = low if x1 < low else high
            y1 += (y1 - y0) / (x1 - x0) * (edge - x1)
            x1 = edge
        x0, y0, x1, y1 = y0, x0, y1, x1
    return x0, y0, x1, y1


def _clip_band(x0: float, y0: float, x1: float, y1: float, width: float, cap: float) -> Optional[Line]:
    """Add the caps and clip the middle line where its rim leaves the canvas for good; None: nothing is left."""
    dx, dy = x1 - x0, y1 - y0
    margin_x, margin_y = abs(dy) * width * 0.5, abs(dx) * width * 0.5
    cap *= width
    x0 -= dx * cap
    y0 -= dy * cap
    x1 += dx * cap
    y1 += dy * cap
    high_x = -margin_x + (CANVAS_SIZE + margin_x + margin_x)  # a QRectF keeps its width: this rounding is Qt's
    high_y = -margin_y + (CANVAS_SIZE + margin_y + margin_y)
    if (-margin_x <= x0 <= high_x and -margin_x <= x1 <= high_x
            and -margin_y <= y0 <= high_y and -margin_y <= y1 <= high_y):
        return x0, y0, x1, y1
    first, last = 0.0, 1.0  # share of the line
    dx, dy = x1 - x0, y1 - y0
    for start, extent, low, high in ((x0, dx, -margin_x, high_x), (y0, dy, -margin_y, high_y)):
        if extent == 0:
            if not low < start < high:
                return None
            continue
        near, far = sorted(((low - start) * (1 / extent), (high - start) * (1 / extent)))
        first, last = max(first, near), min(last, far)
        if first >= last:
            return None
    return x0 + dx * first, y0 + dy * first, x0 + dx * last, y0 + dy * last
