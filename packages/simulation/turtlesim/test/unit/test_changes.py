"""Runs of changed pixels: applied to the canvas before, they give the canvas after."""
import random

import pytest

from turtlesim.core.canvas import Canvas

np = pytest.importorskip('numpy')
from turtlesim.core.changes import RUN, runs  # noqa: E402

BLUE, RED = (69, 86, 255), (255, 0, 0)
RED_NUMBER, BLUE_NUMBER = 0x0000ff, 0xff5645  # blue, green, red


def applied(changes, before):
    """The work of a page with them, pixel by pixel."""
    pixels = bytearray(before)
    for place, colour in np.frombuffer(changes, RUN).tolist():
        first, count = place & 0x3ffff, place >> 18
        pixels[3 * first:3 * (first + count)] = colour.to_bytes(3, 'little') * count
    return bytes(pixels)


def numbers(changes):
    return [(place >> 18, place & 0x3ffff, colour) for place, colour in np.frombuffer(changes, RUN).tolist()]


def test_nothing_changed():
    assert runs(Canvas().tobytes(), Canvas().tobytes()) == b''


def test_all_of_an_empty_canvas_is_a_run_for_each_row():
    assert numbers(runs(Canvas().tobytes())) == [(500, 500 * row, BLUE_NUMBER) for row in range(500)]


def test_runs_end_at_the_end_of_a_row_and_where_the_colour_changes():
    canvas = Canvas()
    before = canvas.tobytes()
    after = bytearray(before)
    after[3 * 498:3 * 502] = bytes(RED) * 4  # two pixels at the end of row 0, two at the start of row 1
    after[3 * 502:3 * 503] = bytes((1, 2, 3))
    assert numbers(runs(bytes(after), before)) == [(2, 498, RED_NUMBER), (2, 500, RED_NUMBER), (1, 502, 0x030201)]


def test_pixels_that_stay_are_in_no_run():
    before = Canvas(RED).tobytes()
    after = bytearray(before)
    after[0:3] = after[6:9] = bytes(BLUE)  # pixel 1 between them was red and is red
    assert numbers(runs(bytes(after), before)) == [(1, 0, BLUE_NUMBER), (1, 2, BLUE_NUMBER)]


def test_random_strokes_arrive_as_they_are():
    draw = random.Random(5)
    canvas = Canvas()
    page = applied(runs(canvas.tobytes()), bytes(750000))
    for _ in range(60):
        before = canvas.tobytes()
        for _ in range(draw.randrange(1, 9)):
            ends = [draw.uniform(-1, 12) for _ in range(4)]
            canvas.draw((*ends, tuple(draw.randrange(256) for _ in 'rgb'), draw.randrange(1, 9)))
        page = applied(runs(canvas.tobytes(), before), page)
        assert page == canvas.tobytes()
    assert applied(runs(canvas.tobytes()), bytes(750000)) == page
