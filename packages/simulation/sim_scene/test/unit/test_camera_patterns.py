"""Bricks and tiles lie on their walls and floor in true perspective: compared with where each pixel's ray ends."""
import math

import numpy as np
import pytest

from kinematic_core.worlds.floor_plan import Box, FloorPlan, corners
from sim_scene import textures
from sim_scene.faces import shade
from sim_scene.renderer import Renderer
from unit_support import reference_camera as reference

pytestmark = pytest.mark.slow

EYE = 0.2155  # [m] height of the Robotont's camera
SAME, CLOSE = 0.85, 6.0  # least correlation of a pattern with the expected one, most mean difference in greys
GREY = (160, 160, 160)


def ends_of_rays(plan, camera, pose):
    """World points (height, width, 3) [m] that the pixels show, and the index of the solid."""
    depth, solid, _ = reference.trace(plan, camera, pose)
    depth = np.where(np.isfinite(depth), depth, 0.0)
    return np.array(pose[:3]) + reference.rays(camera, pose) * depth[..., None], solid


def face_point(box, points, heading):
    """[m] along a box's face from its left edge for who looks along `heading`, and the angle of its normal."""
    ends = corners(box)
    for first, second in zip(ends, ends[1:] + ends[:1]):  # counter-clockwise: the outside is to the right of the way
        along = np.subtract(second, first)
        normal = math.atan2(-along[0], along[1])
        if math.cos(normal - heading) < -0.9:
            return (points[..., :2] - first) @ (along / np.hypot(*along)), normal
    raise AssertionError('no face looks there')


@pytest.mark.parametrize('face', range(4))
@pytest.mark.parametrize('size', [(2.0, 0.5), (5.0, 1.2)])
def test_bricks_lie_on_every_face_of_a_box(face, size):
    length, height = size
    box = Box('wall', 0.4, -0.3, 0.35, length, length, height, 0.0, GREY)
    heading = box.yaw + face * math.pi / 2 + 0.2
    back = length / 2 + 0.6
    pose = (box.x - back * math.cos(heading), box.y - back * math.sin(heading), EYE, heading)
    plan = FloorPlan((box,))
    rendered = Renderer(plan, 637, 360)
    points, solid = ends_of_rays(plan, rendered.camera, pose)
    along, normal = face_point(box, points, heading)
    up = points[..., 2]
    mask = (solid == 0) & (np.abs(along / length - 0.5) < 0.49) & (np.abs(up / height - 0.5) < 0.49)
    tone = bricks(along[mask], up[mask]) * (1.0 - 0.2 * np.clip(1.0 - up[mask] / textures.SHADOW_HEIGHT, 0.0, 1.0))
    expected = GREY[0] * shade(math.cos(normal), math.sin(normal)) * tone
    found = rendered.render(pose)[..., 0][mask].astype(float)
    assert mask.sum() > 10000
    assert np.corrcoef(expected, found)[0, 1] > SAME
    assert np.abs(expected - found).mean() < CLOSE


def bricks(along, up):
    """Tones of bricks: each course half a brick further, joints below and to the left of each."""
    course = np.floor(up / textures.COURSE).astype(int)
    along = along / textures.BRICK_LENGTH + 0.5 * (course % 2)
    joint = (up % textures.COURSE < textures.MORTAR) | (along % 1.0 < textures.MORTAR / textures.BRICK_LENGTH)
    return np.where(joint, textures.MORTAR_TONE, textures.TONES[course, np.floor(along).astype(int)])


@pytest.mark.parametrize('x, y, yaw', [(0.0, 0.0, 0.0), (0.3, -0.2, 0.7), (-7.64, 3.21, 2.5), (101.9, -55.3, -1.4)])
def test_tiles_lie_on_the_floor(x, y, yaw):
    wall = Box('wall', x + 2.5 * math.cos(yaw + 0.5), y + 2.5 * math.sin(yaw + 0.5), yaw, 0.2, 2.0, 0.5, 0.0, GREY)
    plan = FloorPlan((wall,), ground_colour=(200, 200, 200))
    rendered, pose = Renderer(plan, 637, 360), (x, y, EYE, yaw)
    points, solid = ends_of_rays(plan, rendered.camera, pose)
    distance = np.hypot(points[..., 0] - x, points[..., 1] - y)
    floor = reference.inner(solid, np.zeros((*solid.shape, 3))) & (solid == reference.FLOOR)
    beside = np.abs((points[..., :2] + textures.TILE / 2) % textures.TILE - textures.TILE / 2).min(-1)
    picture = rendered.render(pose)[..., 0].astype(float)
    odd = np.floor(points[..., :2] / textures.TILE).astype(int).sum(-1) % 2
    for parity, tone in enumerate(textures.TILE_TONES):
        tile = floor & (distance < 1.0) & (beside > 0.08) & (odd == parity)
        assert tile.sum() > 1000 and np.abs(picture[tile] - 200 * tone).max() <= 4
    joint = floor & (beside < 0.3 * textures.GROUT) & (distance < 0.8)
    assert np.abs(picture[joint] - 200 * textures.GROUT_TONE).mean() < CLOSE
    far = floor & (distance > 1.5) & (distance < 3.0)
    assert np.ptp([picture[far & (odd == parity) & (beside > 0.08)].mean() for parity in (0, 1)]) > 5  # on all of it


def test_tiles_reach_the_foot_of_a_wall_that_closes_the_view():
    plan = FloorPlan((Box('wall', 1.3, 0.0, 0.1, 0.2, 9.0, 0.5, 0.0, GREY),), ground_colour=(200, 200, 200))
    rendered, pose = Renderer(plan), (0.0, 0.0, EYE, 0.0)
    points, solid = ends_of_rays(plan, rendered.camera, pose)
    floor = reference.inner(solid, np.zeros((*solid.shape, 3))) & (solid == reference.FLOOR)
    strip = floor & (np.abs(points[..., 0] - 1.08) < 0.03)
    odd = np.floor(points[..., :2] / textures.TILE).astype(int).sum(-1) % 2
    picture = rendered.render(pose)[..., 0]
    assert strip.sum() > 500 and np.ptp([picture[strip & (odd == parity)].mean() for parity in (0, 1)]) > 8


def test_bricks_have_the_colour_of_their_wall():
    wall = Box('wall', 1.0, 0.0, 0.0, 0.2, 3.0, 1.0, 0.0, (200, 100, 50))
    red, green, blue = Renderer(FloorPlan((wall,)), 320, 240).render((0.0, 0.0, 0.5, 0.0))[80:160].mean((0, 1))
    assert green / red == pytest.approx(0.5, abs=0.02) and blue / red == pytest.approx(0.25, abs=0.02)
    assert red == pytest.approx(200 * shade(-1.0, 0.0) * textures.TONES.mean(), rel=0.05)
