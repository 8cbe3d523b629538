"""Markers of which something covers cells: read without these, and refused where they would decide."""
import cv2
import numpy as np
import pytest

from alvar_core import code
from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector

CELL, LEFT = 8, 120  # px: a cell, the left and upper edge of the black square


def covered(number, column, cells, grey):
    """A marker, and a strip of a cell's width from above it down to the first ``cells`` data cells of a column."""
    white = np.pad(np.pad(code.encode(number), 2), 3, constant_values=True)
    image = np.full((300, 320), 110, np.uint8)
    drawn = np.kron(np.where(white, 170, 30), np.ones((CELL, CELL)))
    first = LEFT - 3 * CELL
    image[first:first + len(drawn), first:first + len(drawn)] = drawn
    left = LEFT + (2 + column) * CELL
    image[first:LEFT + (2 + cells) * CELL, left:left + CELL] = grey
    return cv2.GaussianBlur(image, (0, 0), 0.8)


@pytest.mark.parametrize('number, column, cells', [(1, 2, 3), (97, 0, 4), (33, 4, 3)])
def test_marker_is_read_without_the_cells_that_a_strip_covers(number, column, cells):
    image = covered(number, column, cells, 230)
    assert [each.id for each in Detector(0.1).detect(image, default_camera(320, 300))] == [number]


def test_no_other_number_is_read_whatever_a_strip_covers():
    camera, detector = default_camera(320, 300), Detector(0.1)
    for number in range(0, 256, 9):
        for grey in (30, 100, 170, 230):
            found = detector.detect(covered(number, number % 5, 1 + number % 4, grey), camera)
            assert {each.id for each in found} <= {number}
