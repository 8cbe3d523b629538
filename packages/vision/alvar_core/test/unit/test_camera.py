"""alvar_core.camera.FisheyeCamera against OpenCV's own projection, and markers seen through such a lens."""
import cv2
import numpy as np
import pytest

from alvar_core import rotations
from alvar_core.camera import CameraError, FisheyeCamera
from alvar_core.detection.detector import Detector
from rostest_support.marker_scenes import Placed, Scene, image_of

MATRIX = [300.0, 0, 319.5, 0, 305.0, 239.5, 0, 0, 1]
LENS = [0.05, -0.01, 0.002, -0.0005]
PIXEL = 1e-6
POSITION, ANGLE = 0.005, np.radians(0.5)  # of the distance; the limit for a rendered marker 60 px wide


def test_points_are_drawn_where_opencv_draws_them():
    camera = FisheyeCamera(MATRIX, LENS)
    points = np.random.default_rng(1).uniform([-2, -2, 0.5], [2, 2, 2], (200, 3))
    drawn, _ = cv2.fisheye.projectPoints(points[:, None], np.zeros(3), np.zeros(3), camera.matrix, np.array(LENS))
    ideal = points[:, :2] / points[:, 2:] * [camera.fx, camera.fy] + [camera.cx, camera.cy]
    real = np.stack(camera.to_real(ideal[:, 0], ideal[:, 1]), 1)
    assert np.abs(real - drawn[:, 0]).max() < PIXEL
    assert np.abs(camera.to_ideal(real) - ideal).max() < 1e-3  # px; OpenCV inverts by iteration


def test_the_optical_axis_and_small_numbers():
    camera = FisheyeCamera(MATRIX, LENS)
    assert camera.to_real(np.array([319.5]), np.array([239.5])) == (pytest.approx([319.5]), pytest.approx([239.5]))
    x, _ = camera.to_real(np.float32([400.0, 319.5]), np.float32([239.5, 239.5]))
    assert x.dtype == np.float32 and np.isfinite(x).all()


@pytest.mark.parametrize('values', [[], [0.1], [0.1] * 5, [0.1, 0.1, float('nan'), 0.1]])
def test_other_numbers_of_coefficients_are_refused(values):
    with pytest.raises(CameraError, match='4 finite numbers'):
        FisheyeCamera(MATRIX, values)


def test_markers_far_from_the_axis_are_where_they_are():
    camera = FisheyeCamera(MATRIX, LENS)
    placed = [Placed(i, 0.1, rotations.facing(0.3 + 0.1 * i, 1.0 + i, 0.2 * i),
                            np.array([-0.5 + 0.33 * i, 0.1 * i - 0.15, 0.5])) for i in range(4)]
    picture = image_of(np.random.default_rng(1), camera, placed, Scene())
    found = {d.id: d for d in Detector(0.1).detect(picture, camera)}
    assert set(found) == {0, 1, 2, 3}
    for marker in placed:
        error = np.linalg.norm(found[marker.id].position - marker.position)
        assert error < POSITION * np.linalg.norm(marker.position)
        assert rotations.angle_between(found[marker.id].rotation, marker.rotation) < ANGLE
