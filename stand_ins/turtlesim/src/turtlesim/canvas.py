"""The turtles' canvas: 500 x 500 RGB pixels and the strokes of the pens on them. Needs neither ROS nor numpy.

A stroke sets exactly the pixels that the raster engine of Qt 5.15 sets for QPainter.drawLine between two QPointF
with a solid pen of integer width, square caps and no anti-aliasing (rules read from the behaviour of Qt's sources
qcosmeticstroker.cpp, qrasterizer.cpp and qpaintengine_raster.cpp; compared with PyQt5 5.15). OpenCV draws other
pixels for the same shape, because cv2.fillConvexPoly strokes the outline as well: hence the spans of our own.

Units: positions in metres with y down, origin in the upper left corner; lengths in pixels where a name says px.
Fixed-point numbers follow Qt: 26.6 for the positions of thin lines, 16 fractional bits for the edges of thick ones.
"""
from math import floor, sqrt

from kinematic_core.turtle_world import BACKGROUND, CANVAS_SIZE, PIXELS_PER_METRE

ROW_BYTES = 3 * CANVAS_SIZE
LAST = CANVAS_SIZE - 1
INT_MIN = -2 ** 31


class Canvas:
    """A square picture of CANVAS_SIZE px, kept as RGB bytes row by row. Not thread-safe: its owner locks it."""

    def __init__(self, background=BACKGROUND):
        """A canvas of one colour, (r, g, b) in 0..255."""
        self._pixels = bytearray(bytes(background) * (CANVAS_SIZE * CANVAS_SIZE))

    def fill(self, rgb=BACKGROUND):
        """Paint everything in the colour (r, g, b), each in 0..255."""
        self._pixels[:] = bytes(rgb) * (CANVAS_SIZE * CANVAS_SIZE)

    def draw(self, stroke):
        """Draw one stroke (x0, y0_down, x1, y1_down, (r, g, b), width): finite metres, width in px, at least 1.

        Either end may lie outside the canvas, however far. The order of the ends matters for the last bit.
        """
        x0, y0, x1, y1, rgb, width = stroke
        x0 *= PIXELS_PER_METRE
        y0 *= PIXELS_PER_METRE
        x1 *= PIXELS_PER_METRE
        y1 *= PIXELS_PER_METRE
        pixel = bytes(rgb)
        square_cap = 0.5
        if _same(x0, x1) and _same(y0, y1):
            if width <= 1:
                self._dot(_round(x0), _round(y0), pixel)
                return
            x0, x1, y1 = x0 - width * 0.5, x0 + width * 0.5, y0
            if _same(x0, x1):
                return
            square_cap = 0.0
        elif width <= 1:
            self._thin(x0, y0, x1, y1, pixel)
            return
        relative = width / abs(complex(x1 - x0, y1 - y0))
        self._band(x0, y0, x1, y1, pixel, relative, square_cap * relative)

    def color_at(self, x, y_down):
        """Colour (r, g, b) of the pixel that contains the point, in metres. ValueError outside the canvas."""
        column = int(x * PIXELS_PER_METRE + 0.5)
        row = int(y_down * PIXELS_PER_METRE + 0.5)
        if not (0 <= column <= LAST and 0 <= row <= LAST):
            raise ValueError('no pixel at x=%r y_down=%r [m]: allowed is 0 to %.3f' % (x, y_down, LAST / PIXELS_PER_METRE))
        start = row * ROW_BYTES + 3 * column
        return tuple(self._pixels[start:start + 3])

    def tobytes(self):
        """The pixels as bytes: rows from the top, three bytes (r, g, b) a pixel."""
        return bytes(self._pixels)

    def array(self):
        """A copy as numpy array of shape (CANVAS_SIZE, CANVAS_SIZE, 3), uint8, RGB. Loads numpy at the first call."""
        import numpy
        return numpy.frombuffer(self._pixels, numpy.uint8).reshape(CANVAS_SIZE, CANVAS_SIZE, 3).copy()

    def _dot(self, column, row, pixel):
        if 0 <= column <= LAST and 0 <= row <= LAST:
            start = row * ROW_BYTES + 3 * column
            self._pixels[start:start + 3] = pixel

    def _thin(self, x0, y0, x1, y1, pixel):
        """A line of width 1: one pixel for each row, or for each column of a flat line, half a pixel more at the ends."""
        ends = _clip_thin(x0, y0, x1, y1)
        if ends is None:
            return
        x0, y0, x1, y1 = [_int32(value * 64.0) for value in ends]
        steep = abs(x1 - x0) < abs(y1 - y0)
        if steep:
            x0, y0, x1, y1 = y0, x0, y1, x1
        if x0 == x1:
            return
        if x0 > x1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        slope = _divide((y1 - y0) << 16, x1 - x0)
        x0 -= 32
        first = (x0 + 32) >> 6
        end = (x1 + 64) >> 6
        across = (y0 << 10) - (slope >> 1) + (((first << 6) + (32 if slope > 0 else 0) - x0) * slope >> 6)
        for along in range(first, end):
            if steep:
                self._dot(across >> 16, along, pixel)
            else:
                self._dot(along, across >> 16, pixel)
            across += slope

    def _band(self, x0, y0, x1, y1, pixel, relative, cap):
        """A line of any width; `relative` = width / length, `cap` = how far the ends reach out / length."""
        ends = _clip_band(x0, y0, x1, y1, relative, cap)
        if ends is None:
            return
        dx = x1 - x0
        dy = y1 - y0
        x0, y0, x1, y1 = ends
        new_dx = x1 - x0
        new_dy = y1 - y0
        new_square = new_dx * new_dx + new_dy * new_dy
        if new_square == 0:
            return
        relative *= sqrt((dx * dx + dy * dy) / new_square)
        if -1 < new_dy * 64.0 < 1:
            middle = (x0 + x1) * 0.5
            reach = abs(new_dx) * 0.5
            x0 = x1 = middle
            y1 = y0 + relative * reach
            y0 = y0 - relative * reach
            relative = 1.0 / relative
            new_dx = 0.0
        if y0 > y1:
            x0, y0, x1, y1 = x1, y1, x0, y0
        if -1 < new_dx * 64.0 < 1:
            reach = 0.5 * relative * (y1 - y0)
            self._box(x0 - reach, y0, x0 + reach, y1, pixel)
        else:
            self._slanted(x0, y0, x1, y1, pixel, 0.5 * relative)

    def _box(self, left, top, right, bottom, pixel):
        left, top, right, bottom = [min(max(value, 0.0), float(CANVAS_SIZE)) for value in (left, top, right, bottom)]
        if right - left < 1 / 64 or bottom - top < 1 / 64:
            return
        self._rows(int(top + 0.5), _row_above(bottom), int(left + 0.5) << 16, 0, _row_above(right) << 16, 0, pixel)

    def _slanted(self, x0, y0, x1, y1, pixel, half):
        """A tilted band with its upper end first: rows between the two chains of edges top-left-bottom, top-right-bottom."""
        dx = (x1 - x0) * half
        dy = (y1 - y0) * half
        if x0 < x1:
            top_x, top_y, left_x, left_y = x0 + dy, y0 - dx, x0 - dy, y0 + dx
            right_x, right_y, bottom_x, bottom_y = x1 + dy, y1 - dx, x1 - dy, y1 + dx
        else:
            top_x, top_y, left_x, left_y = x0 - dy, y0 + dx, x1 - dy, y1 + dx
            right_x, right_y, bottom_x, bottom_y = x0 + dy, y0 - dx, x1 + dy, y1 - dx
        top_x, top_y = floor(top_x * 64) / 64, floor(top_y * 64) / 64
        left_x, left_y = floor(left_x * 64) / 64, floor(left_y * 64) / 64
        right_x, right_y = floor(right_x * 64) / 64, floor(right_y * 64) / 64
        bottom_x, bottom_y = floor(bottom_x * 64) / 64, floor(bottom_y * 64) / 64
        first = int(top_y + 0.5)
        left_row = _row_above(left_y)
        right_row = _row_above(right_y)
        left, left_step = _edge(top_x, top_y, left_x, left_y, first, 0.5)
        low_left, low_left_step = _edge(left_x, left_y, bottom_x, bottom_y, left_row + 1, 0.5)
        right, right_step = _edge(top_x, top_y, right_x, right_y, first, -0.5)
        low_right, low_right_step = _edge(right_x, right_y, bottom_x, bottom_y, right_row + 1, -0.5)
        turn = min(left_row, right_row)
        self._rows(first, turn, left, left_step, right, right_step, pixel)
        if left_row < right_row:
            right += right_step * (left_row + 1 - first)
            self._rows(left_row + 1, right_row, low_left, low_left_step, right, right_step, pixel)
            low_left += low_left_step * (right_row - left_row)
            turn = right_row
        elif right_row < left_row:
            left += left_step * (right_row + 1 - first)
            self._rows(right_row + 1, left_row, left, left_step, low_right, low_right_step, pixel)
            low_right += low_right_step * (left_row - right_row)
            turn = left_row
        self._rows(turn + 1, _row_above(bottom_y), low_left, low_left_step, low_right, low_right_step, pixel)

    def _rows(self, first, last, left, left_step, right, right_step, pixel):
        """Rows first..last, each from column left >> 16 to column right >> 16; both move by their step a row."""
        if first < 0:
            left -= left_step * first
            right -= right_step * first
            first = 0
        pixels = self._pixels
        for start in range(first * ROW_BYTES, (min(last, LAST) + 1) * ROW_BYTES, ROW_BYTES):
            a = left >> 16
            b = right >> 16
            if a < 0:
                a = 0
            if b > LAST:
                b = LAST
            if a <= b:
                pixels[start + 3 * a:start + 3 * b + 3] = pixel * (b - a + 1)
            left += left_step
            right += right_step


def _same(a, b):
    """Whether Qt takes two coordinates for equal: to 12 digits, beside zero to 1e-12."""
    if a and b:
        return abs(a - b) * 1e12 <= min(abs(a), abs(b))
    return abs(a - b) <= 1e-12


def _round(value):
    """The nearest integer, as a 32-bit one wraps: everything far below zero comes out as 0."""
    return min(max(floor(value + 0.5), -2 ** 32), 2 ** 31) & 0xFFFFFFFF


def _int32(value):
    """A double to int as x86-64 does it."""
    return int(value) if -2147483649.0 < value < 2147483648.0 else INT_MIN


def _divide(a, b):
    """Integer division towards zero."""
    return a // b if (a < 0) == (b < 0) else -(-a // b)


def _row_above(y):
    """The last row or column whose middle lies above y."""
    return -1 if y < 0.5 else int(y - 0.5)


def _edge(x0, y0, x1, y1, row, bias):
    """The edge's x in the middle of a row, and its step a row, both with 16 fractional bits."""
    height = y1 - y0
    if height == 0:
        slope = 1e20 if x1 > x0 else -1e20
    else:
        slope = (x1 - x0) / height
    return int((x0 + bias + (row + 0.5 - y0) * slope) * 65536.0), int(slope * 65536.0)


def _clip_thin(x0, y0, x1, y1):
    """The part of a thin line less than a pixel outside the canvas, first by columns, then by rows; None: nothing."""
    clipped = _clip_axis(x0, y0, x1, y1)
    if clipped is None:
        return None
    x0, y0, x1, y1 = clipped
    clipped = _clip_axis(y0, x0, y1, x1)
    if clipped is None:
        return None
    y0, x0, y1, x1 = clipped
    return x0, y0, x1, y1


def _clip_axis(u0, v0, u1, v1):
    low, high = -1.0, CANVAS_SIZE + 1.0
    if (u0 < low and u1 <= low) or (u0 > high and u1 >= high):
        return None
    if not low <= u0 <= high:
        edge = low if u0 < low else high
        v0 += (v1 - v0) / (u1 - u0) * (edge - u0)
        u0 = edge
    if not low <= u1 <= high:
        edge = low if u1 < low else high
        v1 += (v1 - v0) / (u1 - u0) * (edge - u1)
        u1 = edge
    return u0, v0, u1, v1


def _clip_band(x0, y0, x1, y1, relative, cap):
    """The band's middle line with its caps, cut where even its rim cannot reach the canvas; None: nothing left."""
    dx = x1 - x0
    dy = y1 - y0
    margin_x = abs(dy) * relative * 0.5
    margin_y = abs(dx) * relative * 0.5
    x0 -= dx * cap
    y0 -= dy * cap
    x1 += dx * cap
    y1 += dy * cap
    low_x = 0.0 - margin_x
    low_y = 0.0 - margin_y
    high_x = low_x + (CANVAS_SIZE + margin_x - low_x)
    high_y = low_y + (CANVAS_SIZE + margin_y - low_y)
    if low_x <= x0 <= high_x and low_x <= x1 <= high_x and low_y <= y0 <= high_y and low_y <= y1 <= high_y:
        return x0, y0, x1, y1
    begin = 0.0
    end = 1.0
    for origin, extent, low, high in ((x0, x1 - x0, low_x, high_x), (y0, y1 - y0, low_y, high_y)):
        if extent == 0:
            if not low < origin < high:
                return None
            continue
        inverse = 1.0 / extent
        near = (low - origin) * inverse
        far = (high - origin) * inverse
        begin = max(begin, min(near, far))
        end = min(end, max(near, far))
        if begin >= end:
            return None
    return x0 + (x1 - x0) * begin, y0 + (y1 - y0) * begin, x0 + (x1 - x0) * end, y0 + (y1 - y0) * end
