"""The canvas against Qt's own pictures and against pixels derived by hand.

data/canvas/strokes.json.gz was drawn by PyQt5 5.15 of Debian 12 (QPainter.drawLine(QPointF, QPointF) without hints
on a QImage of Format_ARGB32, QPen with setWidth): random strokes one over the other on a canvas in turtlesim's blue,
each as [x0, y0_down, x1, y1_down (m), r, g, b, width (px), CRC-32 of the canvas' RGB bytes after it]: a tick's
motion, short and long ones, along the axes, of no length, and with ends up to the largest float32 away.
"""
import gzip
import json
import pathlib
import subprocess
import sys
import zlib

import pytest

from turtlesim.core.canvas import Canvas

STROKES = pathlib.Path(__file__).parents[4] / 'test' / 'data' / 'canvas' / 'strokes.json.gz'
BLUE = (69, 86, 255)
RED = (255, 0, 0)


def drawn(x0, y0, x1, y1, width):
    """The (column, row) that a red stroke sets, its ends given in px."""
    canvas = Canvas()
    canvas.draw((x0 / 45, y0 / 45, x1 / 45, y1 / 45, RED, width))
    pixels = canvas.tobytes()
    changed = [start // 3 for start in range(0, len(pixels), 3) if pixels[start:start + 3] != bytes(BLUE)]
    return {(pixel % 500, pixel // 500) for pixel in changed}


def rectangle(left, top, right, bottom):
    return {(x, y) for x in range(left, right + 1) for y in range(top, bottom + 1)}


def test_every_stroke_sets_the_pixels_that_qt_sets():
    canvas = Canvas()
    for number, (x0, y0, x1, y1, r, g, b, width, crc) in enumerate(json.loads(gzip.decompress(STROKES.read_bytes()))):
        canvas.draw((x0, y0, x1, y1, (r, g, b), width))
        assert zlib.crc32(canvas.tobytes()) == crc, f'stroke {number}: {(x0, y0, x1, y1)}, width {width}'


@pytest.mark.parametrize(('stroke', 'expected'), [
    # width 1: one pixel a column, half a pixel more at both ends
    ((10, 20, 14, 20, 1), rectangle(10, 20, 14, 20)),
    ((20, 14, 20, 10, 1), rectangle(20, 10, 20, 14)),
    ((10.1, 10.1, 13.1, 13.1, 1), {(10, 10), (11, 11), (12, 12), (13, 13)}),
    ((10.4, 20.4, 10.4, 20.4, 1), {(10, 20)}),
    # width 4 and its square caps: 2 px to all sides of the line from (10, 20) to (14, 20)
    ((10, 20, 14, 20, 4), rectangle(8, 18, 15, 21)),
    ((10, 20, 10, 24, 4), rectangle(8, 18, 11, 25)),
    # no length: a square as wide as the pen
    ((10, 20, 10, 20, 4), rectangle(8, 18, 11, 21)),
    # what lies outside is cut off, whether near or far
    ((-1, 20, 1, 20, 4), rectangle(0, 18, 2, 21)),
    ((498, 499, 1e12, 499, 4), rectangle(496, 497, 499, 499)),
    ((-10, -10, -10, 600, 4), set()),
    ((600, -1e30, 600, 1e30, 255), set()),
    ((1e40, 1e40, 1e40, 1e40, 9), set()),
])
def test_pixels_of_a_stroke(stroke, expected):
    assert drawn(*stroke) == expected


def test_a_tilted_stroke_is_as_long_and_wide_as_its_caps_say():
    # length 60 with 2 x 5 for the caps, width 10: 700 px of area, of which counting pixels misses few
    assert len(drawn(100, 100, 136, 148, 10)) == pytest.approx(700, abs=10)


def test_color_at_reads_the_nearest_pixel():
    canvas = Canvas()
    canvas.draw((100 / 45, 50 / 45, 100 / 45, 50 / 45, RED, 1))
    for x, y, colour in ((100, 50, RED), (99.51, 50.49, RED), (100.51, 50, BLUE), (100, 49.49, BLUE)):
        assert canvas.color_at(x / 45, y / 45) == colour


def test_color_at_reaches_all_corners_of_the_arena():
    arena = 11.088889122009277
    for x in (0.0, arena):
        for y in (0.0, arena):
            assert Canvas().color_at(x, y) == BLUE


@pytest.mark.parametrize(('x', 'y_down'), [(-0.1, 5.0), (5.0, -0.1), (11.2, 5.0), (5.0, 1e30)])
def test_color_at_refuses_points_outside(x, y_down):
    with pytest.raises(ValueError, match=f'no pixel at x={x!r}.*must be 0 to 11.08'):
        Canvas().color_at(x, y_down)


def test_fill_and_both_forms_of_the_picture():
    canvas = Canvas((1, 2, 3))
    assert canvas.tobytes() == bytes((1, 2, 3)) * 250000
    canvas.fill((7, 8, 9))
    canvas.draw((2.0, 1.0, 2.0, 1.0, RED, 1))
    array = canvas.array()
    assert array.shape == (500, 500, 3)
    assert array.tobytes() == canvas.tobytes()
    assert tuple(array[45, 90]) == RED
    assert tuple(array[90, 45]) == (7, 8, 9)
    array[:] = 0
    assert canvas.color_at(2.0, 1.0) == RED


def test_the_module_loads_neither_numpy_nor_opencv():
    code = "import sys, turtlesim.core.canvas; sys.exit(bool({'numpy', 'cv2', 'rospy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, '-c', code], check=False).returncode == 0
