"""Markers seen through a lens that is not the one of the Camera: their corners are where they are seen, their pose is
doubtful, and why is said."""
import math

import numpy as np
import pytest

from alvar_core.camera import Camera, FisheyeCamera
from alvar_core.detection.detector import Detector
from alvar_core.detection.explanation import explain
from unit_support import marker_classes
from unit_support.photo import Photo, Sheet

WIDTH, HEIGHT, SIDE = 640, 480, 130.0  # px
FOCAL = WIDTH / 2 / math.radians(60)  # px: a fisheye lens of 120 degrees
MATRIX = [FOCAL, 0, WIDTH / 2, 0, FOCAL, HEIGHT / 2, 0, 0, 1]
CORNER_TOLERANCE = 0.6  # px
WIDE, PINHOLE = FisheyeCamera(MATRIX, [0, 0, 0, 0]), Camera(MATRIX)


def photo(at, marker=11):
    """Return the image of a marker at a pixel ``at`` of the wide lens that faces it, and its corners (4, 2) [px]."""
    ray = np.append(WIDE.to_rays(WIDE.to_ideal(np.array(at, float))), 1.0)
    z = -ray / np.linalg.norm(ray)
    x = np.cross([0.0, 1.0, 0.0], z) / np.linalg.norm(np.cross([0.0, 1.0, 0.0], z))
    sheet = Sheet(marker_classes.marker_cells(marker), marker, marker_classes.SIZE,
                  np.stack([x, np.cross(z, x), z], 1), -z * FOCAL * marker_classes.SIZE / SIDE, paper=0.2)
    made = Photo(WIDE, (WIDTH, HEIGHT), [sheet], noise=1.5)
    return made.render(np.random.default_rng(1)), sheet.corners(WIDE)


@pytest.mark.parametrize('at', [(320, 240), (150, 120), (500, 330), (130, 340)])
def test_the_corners_are_where_they_are_seen_and_the_pose_is_doubtful(at):
    image, corners = photo(at)
    found, = Detector(marker_classes.SIZE, gamma=1.0).detect(image, PINHOLE)
    assert found.id == 11 and np.linalg.norm(found.corners - corners, axis=1).max() < CORNER_TOLERANCE
    assert found.doubtful and 'K and D of camera_info' in found.reason


@pytest.mark.parametrize('x', [60, 64, 68])
def test_a_corner_that_may_lie_outside_of_the_image_does_not_end_the_search(x):
    image, _ = photo((x, 240))
    found, = Detector(marker_classes.SIZE, gamma=1.0).detect(image, PINHOLE)
    assert found.id == 11 and found.doubtful


def test_its_own_lens_is_not_doubted():
    image, corners = photo((150, 120))
    found, = Detector(marker_classes.SIZE, gamma=1.0).detect(image, WIDE)
    assert np.linalg.norm(found.corners - corners, axis=1).max() < 0.1 and not found.doubtful and not found.reason


def test_a_pose_that_misses_its_corners_is_no_reason_to_drop_what_was_read():
    """A focal length a fifth as long: the pose misses the corners by more than 5 % of the side."""
    shot = marker_classes.photo('tilt', marker_classes.DEVELOPMENT, 0)
    wrong = Camera(shot.camera.matrix * [[0.2, 1, 1], [1, 1, 1], [1, 1, 1]])
    detector = Detector(marker_classes.SIZE, gamma=1.0)
    found, = detector.detect(shot.image, wrong)
    assert found.id == shot.frame['markers'][0]['id'] and found.error > 0.05 * found.side
    assert found.doubtful and 'no flat square' in found.reason
    truth = np.array(shot.frame['markers'][0]['corners'])
    assert np.linalg.norm(found.corners - truth, axis=1).max() < CORNER_TOLERANCE
    assert f'found as marker {found.id}, but {found.reason}' in explain(detector, shot.image, wrong).lines[0]
