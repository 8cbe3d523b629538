"""The canvas against Qt's own pictures and against pixels derived by hand.

data/canvas/strokes.json.gz was drawn by PyQt5 5.15 of Debian 12 (QPainter.drawLine(QPointF, QPointF) without hints
on a QImage of Format_ARGB32, QPen with setWidth): random strokes one over the other on a canvas in turtlesim's blue,
each as [x0, y0_down, x1, y1_down (m), r, g, b, width (px), CRC-32 of the canvas' RGB bytes after it]: a tick's
motion, short and long ones, along the axes, of no length, and with ends up to the largest float32 away.
"""
import gzip
import json
import subprocess
import sys
import zlib

import pytest

from turtlesim.core.canvas import Canvas
from unit_support.packages import REPOSITORY

pytestmark = pytest.mark.slow

STROKES = REPOSITORY / 'test' / 'data' / 'canvas' / 'strokes.json.gz'
BLUE = (69, 86, 255)
RED = (255, 0, 0)


def test_every_stroke_sets_the_pixels_that_qt_sets():
    canvas = Canvas()
    for number, (x0, y0, x1, y1, r, g, b, width, crc) in enumerate(json.loads(gzip.decompress(STROKES.read_bytes()))):
        canvas.draw((x0, y0, x1, y1, (r, g, b), width))
        assert zlib.crc32(canvas.tobytes()) == crc, f'stroke {number}: {(x0, y0, x1, y1)}, width {width}'


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
