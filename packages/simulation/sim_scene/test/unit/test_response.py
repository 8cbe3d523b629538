"""What is blended, is blended in light; what is flat has the same colour at every gamma."""
import math
import zlib

import numpy as np
import pytest

from kinematic_core.worlds.camera import GAMMA
from kinematic_core.worlds.floor_plan import Box, FloorPlan
from plain_support import InvalidInput
from sim_scene import worlds
from sim_scene.renderer import Renderer
from sim_scene.response import Response
from unit_support.packages import PACKAGES, REPOSITORY

pytestmark = pytest.mark.slow

AROUND = 7  # px; in the middle of a square of one colour, a picture is flat
EYE = 0.2155  # [m] height of the Robotont's camera
WORLDS = PACKAGES['robotont_gazebo'].folder / 'worlds'
POSES = {'minimaze_ar': [(-2.0, 0.0, EYE, 0.0), (0.3, 1.2, EYE, 2.5)], 'colors': [(0.0, 0.0, EYE, 0.0)],
         'mapping': [(-2.0, 0.5, EYE, 0.4)]}
LINEAR_PICTURES = {'minimaze_ar': [715491995, 167038210], 'colors': [3341794944], 'mapping': [1427815833]}  # CRC-32


def pictures(world, gamma):
    renderer = Renderer(worlds.read_yaml(WORLDS / f'{world}.yaml'), 640, 360, gamma=gamma)
    return [renderer.render(pose) for pose in POSES[world]]


@pytest.mark.parametrize('world', POSES)
def test_pictures_of_gamma_1_are_those_of_a_renderer_that_blends_values(world):
    assert [zlib.crc32(picture.tobytes()) for picture in pictures(world, 1.0)] == LINEAR_PICTURES[world]


@pytest.mark.parametrize('world, gamma', [('minimaze_ar', 1.3), ('colors', 4.0), ('mapping', GAMMA)])
def test_what_is_flat_has_the_same_colour_at_every_gamma(world, gamma):
    flat, changed = [], []
    for linear, other in zip(pictures(world, 1.0), pictures(world, gamma)):
        around = np.lib.stride_tricks.sliding_window_view(linear, (AROUND, AROUND), (0, 1))
        flat.append((around.max((-1, -2)) == around.min((-1, -2))).all(-1))
        changed.append((linear != other).any(-1)[AROUND // 2:-(AROUND // 2), AROUND // 2:-(AROUND // 2)])
    assert np.mean(flat) > 0.2 and np.mean(changed) > 0.001
    assert not (np.array(flat) & np.array(changed)).any()


@pytest.mark.parametrize('gamma', [1.5, GAMMA, 4.0])
def test_an_edge_has_the_mean_light_of_both_sides(gamma):
    sky, ground, wall = (20, 200, 0), (10, 10, 10), (250, 10, 255)
    plan = FloorPlan((Box('wall', 3.0, 0.0, 0.4, 0.2, 20.0, 0.5, 0.0, wall),), ground_colour=ground, sky_colour=sky)
    linear, lit = (Renderer(plan, patterns=False, gamma=each).render((0.0, 0.0, EYE, 0.0))[:340].astype(float)
                   for each in (1.0, gamma))
    face = linear[339, 640]
    share = linear[..., 2] / face[2]  # of the wall in a pixel: the sky has no blue
    expected = (np.array(sky) ** gamma * (1.0 - share[..., None]) + face ** gamma * share[..., None]) ** (1.0 / gamma)
    edge = (share > 0.1) & (share < 0.9)
    assert edge.sum() > 500 and np.abs(lit - expected)[edge].max() < 3.0  # a share of 1 / 256, and rounding down
    assert np.abs(lit - linear)[edge].max() > 10.0


@pytest.mark.parametrize('gamma', [1.0, 1.01, GAMMA, 4.0])
def test_values_and_light_are_each_others_inverse(gamma):
    response, values = Response(gamma), np.arange(256, dtype=np.uint8)
    assert np.allclose(response.values(response.light(values)), values)
    assert np.array_equal(response.smaller(np.tile(values.repeat(2), (2, 1)), (256, 1))[0], values)


@pytest.mark.parametrize('launch', ['launch/camera_ar_track.launch',
                                    'packages/robotont/robotont_training/launch/robotont_ar.launch'])
def test_launch_files_tell_the_tracker_the_gamma_of_the_simulated_camera(launch):
    named = [line for line in (REPOSITORY / launch).read_text(encoding='utf-8').splitlines() if 'name="gamma"' in line]
    assert str(GAMMA) in named[0]


@pytest.mark.parametrize('gamma', [0.9, 4.1, math.nan])
def test_an_impossible_gamma_is_refused(gamma):
    with pytest.raises(InvalidInput, match='gamma of the camera is .*; it must be 1 to 4'):
        Renderer(FloorPlan(), 64, 48, gamma=gamma)
