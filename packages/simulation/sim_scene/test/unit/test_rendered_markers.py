"""Panels in the camera's pictures: where the tracker finds them, and how exactly they are in their place."""
import math

import cv2
import numpy as np
import pytest

from alvar_core import code
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from kinematic_core.worlds.camera import GAMMA
from kinematic_core.worlds.floor_plan import Box, FloorPlan, Panel
from plain_support.rotations import angle_between
from sim_scene.renderer import Renderer
from sim_scene.textures import INK, PAPER

pytestmark = pytest.mark.slow

EYE = 0.2155  # [m] height of the Robotont's camera
POSITION_TOLERANCE = 0.0025  # of the distance
ROTATION_TOLERANCE = math.radians(1.0)
SHIFT_TOLERANCE = 0.05  # px
PARTS = 5  # of a pixel in each direction, of the pictures to compare with


def pose_in_camera(panel, pose):
    """Rotation and position of a panel's marker in the optical frame of a camera at (x, y, z, yaw)."""
    x, y, z, yaw = pose
    optical = np.array([[math.sin(yaw), -math.cos(yaw), 0], [0, 0, -1], [math.cos(yaw), math.sin(yaw), 0]])
    axes = np.array([[math.sin(panel.yaw), 0, -math.cos(panel.yaw)], [-math.cos(panel.yaw), 0, -math.sin(panel.yaw)],
                     [0, 1, 0]])
    middle = np.array([panel.x, panel.y, panel.bottom + panel.size / 2])
    return optical @ axes, optical @ (middle - [x, y, z])


def scene(distance, angle, aside=0.1):
    """A panel on a wall, and a camera `distance` from it, `angle` off its normal, that looks a little beside it."""
    panel = Panel('panel', 3, 0.3, -0.2, 0.7)
    wall = Box('wall', 0.3 + 0.055 * math.cos(0.7), -0.2 + 0.055 * math.sin(0.7), 0.7, 0.1, 3.0, 0.5, 0.0,
               (230, 230, 230))
    heading = panel.yaw + angle
    pose = panel.x - distance * math.cos(heading), panel.y - distance * math.sin(heading), EYE, heading + aside
    return FloorPlan((wall,), (), (panel,)), panel, pose


def check_tracker(world, panel, pose, width, height):
    rendered = Renderer(world, width, height)
    picture = cv2.cvtColor(rendered.render(pose), cv2.COLOR_RGB2BGR)
    found = Detector(panel.marker_size, gamma=GAMMA).detect(picture, Camera(rendered.camera.matrix()))
    found = [detection for detection in found if detection.id == panel.marker_id]
    assert len(found) == 1
    rotation, position = pose_in_camera(panel, pose)
    assert np.linalg.norm(found[0].position - position) < POSITION_TOLERANCE * np.linalg.norm(position)
    assert angle_between(found[0].rotation, rotation) < ROTATION_TOLERANCE


@pytest.mark.parametrize('width, height', [(1280, 720), (640, 480)])
@pytest.mark.parametrize('distance', [0.8, 1.5, 3.0])
@pytest.mark.parametrize('angle', [-50, 25, 40])
def test_tracker_finds_the_pose_of_a_panel(width, height, distance, angle):
    check_tracker(*scene(distance, math.radians(angle)), width, height)


def light(greys, gamma):
    """Light 0..255 of greys."""
    return 255 * (greys / 255) ** gamma


def averaged_view(panel, camera, pose, gamma):
    """Light of the panel alone, each pixel the mean of PARTS x PARTS rays; NaN beside the panel."""
    rotation, position = pose_in_camera(panel, pose)
    cells = np.pad(code.encode(panel.marker_id), 2)
    count, total = len(cells), 0.0
    for k in range(PARTS ** 2):
        u = np.arange(camera.width) + (k % PARTS + 0.5) / PARTS - 0.5
        v = np.arange(camera.height) + (k // PARTS + 0.5) / PARTS - 0.5
        rays = np.stack(np.broadcast_arrays((u - camera.cx) / camera.focal, (v[:, None] - camera.cy) / camera.focal,
                                            1.0), -1)
        depth = (rotation[:, 2] @ position) / (rays @ rotation[:, 2])
        on_face = (rays * depth[..., None] - position) @ rotation[:, :2]
        column, row = (np.floor((way * on_face[..., axis] / panel.marker_size + 0.5) * count).astype(int)
                       for axis, way in ((0, 1), (1, -1)))
        inside = (np.minimum(row, column) >= 0) & (np.maximum(row, column) < count)
        white = cells[np.clip(row, 0, count - 1), np.clip(column, 0, count - 1)] | ~inside
        grey = np.where(white, float(PAPER), float(INK))
        total = total + np.where(np.abs(on_face).max(-1) < panel.size / 2, light(grey, gamma), np.nan)
    return total / PARTS ** 2


@pytest.mark.parametrize('distance, angle, gamma', [
    (0.5, 0, GAMMA), (0.6, 40, 1.0), (1.0, -55, GAMMA), (1.5, 20, 1.0), (2.0, 0, GAMMA)])
def test_markers_are_in_their_place_to_a_small_part_of_a_pixel(distance, angle, gamma):
    world, panel, pose = scene(distance, math.radians(angle))
    rendered = Renderer(world, 640, 360, gamma=gamma)
    expected = averaged_view(panel, rendered.camera, pose, gamma)
    difference = light(rendered.render(pose)[..., 0], gamma) - expected
    down, right = np.gradient(expected)
    inner = np.isfinite(difference) & np.isfinite(down) & np.isfinite(right)
    slopes = np.stack([right[inner], down[inner], np.ones(inner.sum())], 1)
    (shift_x, shift_y, lighter), *_ = np.linalg.lstsq(slopes, -difference[inner], rcond=None)
    assert max(abs(shift_x), abs(shift_y)) < SHIFT_TOLERANCE
    assert abs(lighter) < 1.0
    assert np.abs(difference[inner]).mean() < 12
