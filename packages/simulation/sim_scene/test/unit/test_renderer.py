"""The camera's pictures against points computed by hand, a slow ray tracer."""
import math

import numpy as np
import pytest

from kinematic_core.worlds.camera import DEPTH_FAR, DEPTH_NEAR
from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel
from plain_support import InvalidInput
from sim_scene.renderer import Renderer
from unit_support import reference_camera as reference

pytestmark = pytest.mark.slow

EYE = 0.2155  # [m] height of the Robotont's camera
DEPTH_TOLERANCE = 1e-4  # of the depth
COLOUR_TOLERANCE = 3  # greys
OFF_FACES = 0.001  # share of the pixels away from edges that may differ
RED, GREEN, BLUE, WHITE = (200, 40, 40), (40, 200, 40), (40, 40, 200), (230, 230, 230)


def plan(*shapes):
    kinds = [tuple(shape for shape in shapes if isinstance(shape, kind)) for kind in (Box, Cylinder, Panel)]
    return FloorPlan(*kinds)


# A cube of 1 m whose nearest face is 2 m before the camera: half its width, 0.5 m, is 0.25 of the depth: 160 px at a
# focal length of 640 px. Its top is 1 - 0.2155 m above the camera: 640 * 0.7845 / 2 = 251 px; its foot 69 px below.
def test_box_lies_where_hand_computed_points_are():
    rendered = Renderer(plan(Box('cube', 2.5, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, RED)), patterns=False)
    depth = rendered.depth((0.0, 0.0, EYE, 0.0))
    cube = np.isclose(depth, 2.0)
    rows, columns = np.nonzero(cube)
    assert (columns.min(), columns.max()) == (480, 800) or (columns.min(), columns.max()) == (481, 799)
    assert abs(rows.min() - (360 - 251.04)) <= 1 and abs(rows.max() - (360 + 68.96)) <= 1
    picture = rendered.render((0.0, 0.0, EYE, 0.0))
    assert picture.shape == (720, 1280, 3) and picture.dtype == np.uint8
    red = (picture[:, :, 0] > picture[:, :, 1] + 40)
    assert np.array_equal(red, cube) or (red != cube).sum() <= 2 * 322


def test_depth_of_the_floor_follows_its_row():
    depth = Renderer(plan()).depth((0.0, 0.0, 0.5, 1.0))
    assert np.allclose(depth[360 + 160], 0.5 * 640 / 160)  # 2 m
    assert np.isnan(depth[:361]).all()
    assert np.isnan(depth[360 + 63]).all() and np.isfinite(depth[360 + 65]).all()  # 5.08 m and 4.92 m; seen up to 5 m


@pytest.mark.parametrize('options', [{}, {'depth_range': (0.02, 8.0)}])
@pytest.mark.parametrize('end, inward', [(0, 1.01), (0, 0.99), (1, 0.99), (1, 1.01)])
def test_depth_is_reported_between_near_and_far(options, end, inward):
    near, far = options.get('depth_range', (DEPTH_NEAR, DEPTH_FAR))
    distance = (near, far)[end] * inward
    world = plan(Box('wall', distance + 0.5, 0.0, 0.0, 1.0, 50.0, 1.0))
    depth = Renderer(world, 64, 48, **options).depth((0.0, 0.0, EYE, 0.0))[22, 32]
    assert depth == pytest.approx(distance if near < distance < far else math.nan, nan_ok=True)


@pytest.mark.parametrize('depth_range', [(5.0, 0.4), (1.0, 1.0), (0.001, 5.0), (0.4, 1e4), (math.nan, 5.0)])
def test_an_impossible_range_of_depths_is_refused(depth_range):
    with pytest.raises(InvalidInput, match='depth camera sees from'):
        Renderer(plan(), 64, 48, depth_range=depth_range)


def test_points_lie_on_the_surfaces_in_the_optical_frame():
    rendered = Renderer(plan(Box('wall', 3.5, 0.0, 0.0, 1.0, 20.0, 2.0)))
    points = rendered.points(rendered.depth((0.0, 0.0, EYE, 0.0)))
    assert points.shape == (720, 1280, 3) and points.dtype == np.float32
    assert np.allclose(points[200, 640 + 320], (1.5, 3.0 * (200 - 360) / 640, 3.0))
    floor = points[600]
    assert np.allclose(floor[:, 1], EYE, atol=1e-6)


@pytest.mark.parametrize('width, height, fov', [(0, 480, 1.5), (640.5, 480, 1.5), (640, 100000, 1.5), (True, 480, 1.5),
                                                (640, 480, 0.0), (640, 480, math.pi), (640, 480, math.nan)])
def test_camera_that_cannot_be_is_refused(width, height, fov):
    with pytest.raises(InvalidInput, match='camera'):
        Renderer(plan(), width, height, fov)


@pytest.mark.parametrize('pose', [(math.nan, 0, 1, 0), (0, 0, 1, math.inf)])
def test_pose_that_is_not_finite_is_refused(pose):
    with pytest.raises(InvalidInput, match='finite'):
        Renderer(plan(), 64, 48).render(pose)


# ---------------------------------------------------------------------------------------------- against the ray tracer

@pytest.mark.parametrize('seed', range(40))
def test_order_depth_and_colour_equal_the_ray_tracers(seed):
    rng = np.random.default_rng(seed)
    world = reference.random_plan(rng)
    pose = (*rng.uniform(-3, 3, 2), rng.choice([EYE, EYE, 0.6, 1.5]), rng.uniform(-4, 4))
    rendered = Renderer(world, 203, 151, patterns=False)  # 203: not a multiple of a block of columns
    depth, solid, colour = reference.trace(world, rendered.camera, pose)
    inner = reference.inner(solid, colour)
    assert inner.mean() > 0.9
    expected, found = reference.reported(depth), rendered.depth(pose)
    wrong = ~np.isclose(found, expected, rtol=DEPTH_TOLERANCE, equal_nan=True)
    assert wrong[inner].mean() <= OFF_FACES and wrong.mean() <= 0.01
    off = np.abs(rendered.render(pose) - colour).max(-1) > COLOUR_TOLERANCE
    assert off[inner].mean() <= OFF_FACES


def test_every_pose_in_and_around_solids_gives_a_picture():
    world = plan(Box('wall', 0, 0, 0.3, 2.0, 0.2, 0.5, 0.0, RED), Box('sill', 0.5, 0.5, 0, 1.0, 0.3, 0.05, 0.0, WHITE),
                 Box('lintel', -0.5, 0.5, 0, 1.0, 0.3, 0.2, 0.4, GREEN), Cylinder('post', -0.8, -0.5, 0.2, 1.0),
                 Panel('panel', 1, 0.2, -0.3, 1.0))
    rendered = Renderer(world, 160, 120)
    rng = np.random.default_rng(7)
    spots = [(shape.x, shape.y) for shape in world.shapes()] + list(rng.uniform(-1.2, 1.2, (60, 2)))
    for x, y in spots:
        for z in (0.0, EYE, 0.5, 0.55, 3.0):
            pose = (x, y, z, rng.uniform(-4, 4))
            picture = rendered.render(pose)
            assert picture.std() > 1.0
            assert not np.isinf(rendered.depth(pose)).any()


def test_from_inside_a_solid_it_is_not_seen():
    world = plan(Box('around', 0, 0, 0.2, 2.0, 2.0, 2.0, 0.0, RED), Box('beyond', 4, 0, 0, 1.0, 9.0, 2.0, 0.0, BLUE))
    rendered = Renderer(world, 160, 120, patterns=False)
    assert rendered.depth((0.0, 0.0, EYE, 0.0))[60, 80] == pytest.approx(3.5)
    assert rendered.render((0.0, 0.0, EYE, 0.0))[60, 80].argmax() == 2


def test_threshold_is_seen_from_above_with_the_wall_behind_it():
    world = plan(Box('sill', 1.5, 0, 0, 0.2, 4.0, 0.05, 0.0, RED), Box('wall', 3.1, 0, 0, 0.2, 9.0, 0.5, 0.0, BLUE))
    depth = Renderer(world, patterns=False).depth((0.0, 0.0, EYE, 0.0))[:, 640]
    # Upper end of the sill, 0.1655 m below the camera, from 1.4 to 1.6 m: rows 360 + 640 * 0.1655 / depth.
    assert depth[430] == pytest.approx(0.1655 * 640 / 70) and depth[440] == pytest.approx(1.4)
    assert depth[400] == pytest.approx(3.0) and depth[424] == pytest.approx(EYE * 640 / 64, rel=1e-6)


@pytest.mark.parametrize('order', [1, -1])
def test_of_two_faces_in_one_plane_the_higher_solid_and_every_panel_are_seen(order):
    walls = Box('wall', 2.05, 0, 0, 0.1, 4.0, 0.5, 0.0, RED), Box('door', 2.05, 0, 0, 0.1, 4.0, 0.3, 0.0, BLUE)
    rendered = Renderer(plan(*walls[::order], Panel('panel', 1, 2.0, 0.0, 0.0)), 320, 240, patterns=False)
    row = rendered.render((0.0, 0.0, EYE, 0.0))[120]
    assert row[160].min() > 150 and row[100].argmax() == 0 and row[220].argmax() == 0


def test_row_by_row_what_looks_over_a_near_wall_is_seen():
    # At 0.5 m the near wall ends 640 * (0.493 - 0.2155) / 0.5 = 355 px above the middle: in row 4.8.
    world = plan(Box('near', 0.6, 0, 0, 0.2, 9.0, 0.493), Box('behind', 2.0, 0, 0, 0.2, 9.0, 3.0))
    depth = Renderer(world).depth((0.0, 0.0, EYE, 0.0))[:, 640]
    assert depth[:5] == pytest.approx(1.9) and depth[5:630] == pytest.approx(0.5)


def test_panel_is_blank_from_behind():
    world = plan(Panel('panel', 3, 0.0, 0.0, 0.0))
    rendered = Renderer(world, 320, 240)
    front, back = rendered.render((-0.6, 0.0, 0.25, 0.0)), rendered.render((0.6, 0.0, 0.25, math.pi))
    part = np.s_[90:150, 130:190]
    assert front[part].std() > 60 and back[part].std() < 2 and back[part].min() > 100


@pytest.mark.parametrize('gamma', [1.0, 2.2])
def test_edges_are_smooth(gamma):
    world = plan(Box('wall', 3.0, 0.0, 0.4, 0.2, 20.0, 0.5, 0.0, (255, 255, 255)))._replace(sky_colour=(0, 0, 0))
    picture = Renderer(world, patterns=False, gamma=gamma).render((0.0, 0.0, EYE, 0.0))[:340, :, 0] ** gamma
    white = picture.max(0)
    edge = 339 + 0.5 - picture.sum(0) / white  # the row where the wall begins, by how much of each column is white
    slope, offset = np.polyfit(np.arange(1280), edge, 1)
    assert np.abs(edge - (slope * np.arange(1280) + offset)).max() < 0.03  # px; with hard edges 0.5


@pytest.mark.parametrize('gamma', [1.0, 2.2])
def test_steep_edges_are_smooth(gamma):
    # 0.1 m to the right of the camera and 0.2845 m above it, the wall's edge rises 2.845 px in a column.
    world = plan(Box('wall', 2.0, -0.15, 0.0, 9.0, 0.1, 0.5, 0.0, (255, 255, 255)))._replace(sky_colour=(0, 0, 0))
    picture = Renderer(world, patterns=False, gamma=gamma).render((0.0, 0.0, EYE, 0.0))[40:300, 650:800, 0] ** gamma
    edge = 800 - 0.5 - picture.sum(1) / picture.max()  # the column where the wall begins in each row
    slope, offset = np.polyfit(np.arange(40, 300), edge, 1)
    assert slope == pytest.approx(-1 / 2.845, rel=0.01)
    assert np.abs(edge - (slope * np.arange(40, 300) + offset)).max() < 0.15  # px; with hard edges 0.5
