"""Codes with few edges look like windows: more is asked of them, and they are still found."""
import cv2
import numpy as np
import pytest

from alvar_core import code, drawing
from alvar_core.camera import default_camera
from alvar_core.detection.acceptance import edges
from alvar_core.detection.detector import Detector

pytestmark = pytest.mark.slow

PLAIN = (240, 244, 246, 249, 255)
CELL, WIDTH = 20, 160  # px of a drawn cell, px of an image


def window(rng):
    """A black square of 9 cells in white paper; in its middle bright bars, and mostly a bright lower part."""
    drawn, cell = np.zeros((9 * CELL, 9 * CELL), np.float32), CELL
    left, right = ((2, 7) + rng.normal(0, 0.25, 2)) * cell
    if rng.uniform() < 0.6:
        drawn[int(rng.uniform(3.5, 5.5) * cell):int(right), int(left):int(right)] = rng.uniform(0.7, 1)
    for _ in range(int(rng.integers(1, 5))):
        x, y, wide, high = rng.uniform((2, 2, 0.6, 0.6), (6, 5.5, 1.6, 3)) * cell
        drawn[int(y):int(min(y + high, right)), int(x):int(min(x + wide, right))] = rng.uniform(0.6, 1)
    return np.pad(drawn, CELL, constant_values=1)


def seen(rng, drawn):
    """The image of a drawing, 25 to 80 px wide, turned and tilted."""
    side, turn = rng.uniform(25, 80) * 11 / 9, rng.uniform(0, 2 * np.pi)
    to = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2 @ [[np.cos(turn), np.sin(turn)],
                                                                      [-np.sin(turn), np.cos(turn)]]
    to = (to + WIDTH / 2 + rng.normal(0, 0.03 * side, (4, 2))).astype(np.float32)
    size = len(drawn)
    h = cv2.getPerspectiveTransform(np.float32([[0, 0], [size, 0], [size, size], [0, size]]), to)
    image = cv2.warpPerspective(30 + 150 * drawn, h, (WIDTH, WIDTH), borderValue=130)
    image = cv2.GaussianBlur(image, (0, 0), rng.uniform(0.6, 1.2)) + rng.normal(0, rng.uniform(2, 6), image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def test_windows_are_no_markers():
    rng, detector, camera = np.random.default_rng(1), Detector(0.05), default_camera(WIDTH, WIDTH)
    found = [each.id for _ in range(150) for each in detector.detect(seen(rng, window(rng)), camera)]
    assert found == []  # without PLAIN_EDGES, 240 eight times


def test_markers_with_such_codes_are_found():
    rng, detector, camera = np.random.default_rng(2), Detector(0.05), default_camera(WIDTH, WIDTH)
    for number in 4 * PLAIN:
        drawn = np.pad(drawing.marker_image(number, 9 * CELL).astype(np.float32) / 255, CELL, constant_values=1)
        assert [each.id for each in detector.detect(seen(rng, drawn), camera)] == [number]


def test_edges_of_codes():
    """One white cell has 4, two beside each other 6; the outer edges of the border do not count."""
    one, two = np.ones((5, 5), bool), np.ones((5, 5), bool)
    one[2, 2] = two[2, 2] = two[2, 3] = False
    assert edges(np.array([one, two])).tolist() == [4, 6] and edges(np.ones((3, 3))) == 0
    counts = {number: int(edges(np.pad(~code.encode(number), 1, constant_values=True))) for number in range(256)}
    assert [number for number, count in counts.items() if count <= 20] == list(PLAIN)
    assert np.median(list(counts.values())) == 32
