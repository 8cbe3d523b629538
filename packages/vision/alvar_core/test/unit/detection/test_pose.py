"""Poses from corners: axes, both solutions, ambiguity, camera checks."""
import numpy as np
import pytest

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import homography, pose

CAMERA = default_camera()
SIZE = 0.1
POSITION_TOLERANCE = 1e-4  # 0.1 mm
ROTATION_TOLERANCE = np.radians(0.05)


def seen(tilt, azimuth, roll, position):
    rotation = rotations.facing(np.radians(tilt), np.radians(azimuth), np.radians(roll))
    corners = drawing.project(CAMERA, rotation, np.array(position), drawing.object_corners(SIZE))
    return rotation, CAMERA.to_ideal(corners)


@pytest.mark.parametrize('tilt, azimuth, roll, position', [
    (0, 0, 0, (0, 0, 0.5)), (30, 0, 0, (0.1, 0, 0.6)), (45, 70, 120, (-0.1, 0.05, 0.8)), (60, 200, 33, (0, 0.1, 0.4))])
def test_exact_corners_give_the_exact_pose(tilt, azimuth, roll, position):
    rotation, corners = seen(tilt, azimuth, roll, position)
    best = pose.solve(corners[None], [SIZE], CAMERA)[0][0]
    assert np.abs(best.position - position).max() < POSITION_TOLERANCE
    assert rotations.angle_between(best.rotation, rotation) < ROTATION_TOLERANCE
    assert best.error < 0.01


def test_axes_are_x_right_y_up_z_to_the_viewer():
    # An upright marker straight ahead: its x is the camera's x, its y the camera's -y, its z points back at the camera.
    _, corners = seen(0, 0, 0, (0, 0, 0.5))
    best = pose.solve(corners[None], [SIZE], CAMERA)[0][0]
    assert np.allclose(best.rotation, np.diag([1, -1, -1]), atol=1e-3)
    assert np.allclose(np.abs(best.quaternion), [1, 0, 0, 0], atol=1e-3)


def test_small_far_marker_is_ambiguous_large_near_one_is_not():
    _, far = seen(20, 30, 0, (0, 0, 4.0))
    share, ambiguous = pose.ambiguity(pose.solve(far[None], [SIZE], CAMERA)[0])
    assert ambiguous and 0 < share <= 0.5
    _, near = seen(35, 30, 0, (0, 0, 0.25))
    assert not pose.ambiguity(pose.solve(near[None], [SIZE], CAMERA)[0])[1]


def test_second_solution_of_an_ambiguous_marker_is_the_mirrored_tilt():
    rotation, corners = seen(20, 0, 0, (0, 0, 4.0))
    solutions = pose.solve(corners[None], [SIZE], CAMERA)[0]
    assert len(solutions) == 2
    apart = np.degrees(rotations.angle_between(solutions[0].rotation, solutions[1].rotation))
    assert 30 < apart < 45  # twice the tilt
    assert min(rotations.angle_between(s.rotation, rotation) for s in solutions) < ROTATION_TOLERANCE


def test_several_markers_at_once_are_as_one_by_one():
    each = [seen(20 + 5 * k, 40 * k, 15 * k, (0.05 * k, 0, 0.5 + 0.1 * k))[1] for k in range(4)]
    together = pose.solve(np.array(each), [SIZE] * 4, CAMERA)
    for corners, solutions in zip(each, together):
        assert np.allclose(solutions[0].position, pose.solve(corners[None], [SIZE], CAMERA)[0][0].position, atol=1e-9)


def test_position_scales_with_the_size():
    _, corners = seen(30, 0, 0, (0.1, 0, 0.6))
    double = pose.solve(corners[None], [2 * SIZE], CAMERA)[0][0]
    assert np.allclose(double.position, [0.2, 0, 1.2], atol=1e-3)


def test_camera_maps_are_each_others_inverse():
    camera = default_camera(distorted=True)
    points = np.array([[10.0, 20.0], [320.0, 240.0], [600.0, 400.0]])
    ideal = camera.to_ideal(points)
    assert np.abs(ideal - points).max() > 2  # the lens does something
    back = np.stack(camera.to_real(ideal[:, 0], ideal[:, 1]), 1)
    assert np.abs(back - points).max() < 0.01


def test_homography_takes_the_square_to_its_quad():
    quad = np.array([[[10.0, 12], [90, 8], [110, 95], [5, 80]]])
    h = homography.from_square(quad, 4.5)
    assert np.allclose(homography.apply(h, [[-4.5, -4.5], [4.5, -4.5], [4.5, 4.5], [-4.5, 4.5]]), quad)
