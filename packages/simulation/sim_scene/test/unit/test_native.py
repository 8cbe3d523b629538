"""The compiled steps of the renderer: any number of shapes and pixels, and errors that name the missing part."""
import subprocess
import sys

import numpy as np
import pytest

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan
from sim_scene import native
from sim_scene.renderer import Renderer
from unit_support import reference_camera as reference

pytestmark = pytest.mark.slow

EYE = 0.2155  # [m] height of the Robotont's camera
PICKETS = FloorPlan(boxes=tuple(Box(f'picket{k}', 2.0, -2.0 + 0.025 * k, 0.0, 0.01, 0.01, 0.3) for k in range(160)))
STAIRS = FloorPlan(boxes=tuple(Box(f'stair{k}', 1.0 + k, 0.0, 0.0, 0.5, 4.0, 0.1 + 0.01 * k) for k in range(20)))
ROOM = FloorPlan(boxes=(Box('wall', 2.5, 0.2, 0.1, 0.2, 3.0, 0.5), Box('step', 1.5, -0.5, 0.4, 0.5, 0.5, 0.1)),
                 cylinders=(Cylinder('post', 1.2, 0.3, 0.1, 0.4),))
ONE_COLOUR, TWO_COLOURS = np.zeros((1, 3), np.uint8), np.zeros((2, 3), np.uint8)
CAMERA = {'width': 16, 'height': 16, 'focal': 16.0, 'cx': 8.0, 'cy': 8.0, 'near': 0.02}
BOX = {'x': 0.0, 'y': 0.0, 'yaw': 0.0, 'length': 1.0, 'width': 1.0, 'bottom': 0.0, 'height': 1.0, 'rank': 0.0,
       'sides': np.zeros((4, 3), np.uint8), 'ends': TWO_COLOURS, 'resolution': (1.0,) * 4, 'steps': 1, 'sharper': 0.0}
VALUES = np.arange(256)
RESPONSE = native.Response(light=VALUES * 256)
IMAGE = {'tones': np.zeros((9, 9), np.uint8), 'response': RESPONSE}
PATTERN = {'image': native.Image(**IMAGE), 'along': 1.0, 'up': 1.0, 'top': 1.0, 'pad': 0.0, 'colour': (1, 2, 3)}
BACKGROUND = {'rows': np.zeros((16, 3), np.uint8), 'floor': [], 'colour': (1, 2, 3), 'period': 1.0, 'sharpness': 1.0}


def check_depths(plan, pose, *size):
    """Compare the depths with those of the ray tracer; return the share of the pixels away from edges."""
    rendered = Renderer(plan, *size)
    depth, solid, colour = reference.trace(plan, rendered.camera, pose)
    inner = reference.inner(solid, colour)
    assert np.allclose(rendered.depth(pose)[inner], reference.reported(depth)[inner], rtol=1e-4, equal_nan=True)
    return inner.mean()


@pytest.mark.parametrize('plan, z', [(PICKETS, EYE), (STAIRS, 1.5), (FloorPlan(), EYE), (FloorPlan(), 0.0)],
                         ids=['many runs', 'many layers', 'nothing', 'on the floor'])
def test_there_is_room_for_any_number_of_layers_and_runs(plan, z):
    assert check_depths(plan, (-2.0, 0.1, z, 0.02), 640, 90) > 0.7


def test_nothing_is_on_this_side_of_the_floor_for_a_camera_below_it():
    rendered, pose = Renderer(FloorPlan(), 64, 48), (0.0, 0.0, -1.0, 0.0)
    assert np.isnan(rendered.depth(pose)).all() and np.ptp(rendered.render(pose)[-1], axis=0).max() == 0


@pytest.mark.parametrize('width, height, fov', [(16, 16, 2.8), (17, 33, 0.05), (1280, 90, 1.0)])
def test_a_narrow_and_a_wide_view_have_the_depths_of_their_rays(width, height, fov):
    check_depths(ROOM, (0.0, 0.0, EYE, 0.1), width, height, fov)


def test_a_renderer_draws_the_same_again_after_other_pictures():
    renderer, pose = Renderer(STAIRS, 320, 240), (-2.0, 0.1, 1.5, 0.02)
    first = renderer.render(pose)
    kept, depth = first.copy(), renderer.depth(pose)
    for yaw in (1.0, 2.0, 3.0):
        renderer.render((0.0, 0.0, EYE, yaw))
    assert np.array_equal(renderer.depth(pose), depth, equal_nan=True)
    assert np.array_equal(renderer.render(pose), kept) and np.array_equal(first, kept)


def test_blue_comes_first_if_asked_for():
    world = FloorPlan(cylinders=(Cylinder('post', 1.0, 0.2, 0.2, 0.5, 0.0, (200, 100, 50)),))
    renderer, pose = Renderer(world, 203, 150), (0.0, 0.0, EYE, 0.0)
    assert np.array_equal(renderer.render(pose, bgr=True)[..., ::-1], renderer.render(pose))


def image(*shape):
    return native.Image(tones=np.zeros(shape, np.uint8), response=RESPONSE)


@pytest.mark.parametrize('make, right, wrong, words', [
    (native.Camera, CAMERA, {'width': 0}, 'width, height, focal and near'),
    (native.Solid.box, BOX, {'sides': TWO_COLOURS}, r'sides must be an array \(4, 3\)'),
    (native.Solid.box, BOX, {'ends': ONE_COLOUR}, r'ends must be an array \(2, 3\)'),
    (native.Solid.box, BOX, {'steps': 0}, 'steps'),
    (native.Response, {'light': VALUES * 256}, {'light': VALUES}, '0 to 65280'),
    (native.Response, {'light': VALUES * 256}, {'light': np.where(VALUES < 9, 0, VALUES * 256)}, 'rise'),
    (native.Image, IMAGE, {'tones': np.zeros((9, 1), np.uint8)}, 'tones'),
    (native.Image, IMAGE, {'tones': np.zeros((9, 9, 3), np.uint8)}, 'tones'),
    (native.Pattern, PATTERN, {'colour': (1, 2, 256)}, 'colour must be 0 to 255'),
    (native.Background, BACKGROUND, {'rows': np.zeros(16, np.uint8)}, 'rows'),
    (native.Background, BACKGROUND, {'floor': [image(10, 10)]}, 'floor'),
    (native.Background, BACKGROUND, {'floor': [image(9, 5)]}, 'floor'),
])
def test_an_array_of_another_shape_is_refused(make, right, wrong, words):
    make(**right)
    with pytest.raises(ValueError, match=words):
        make(**{**right, **wrong})


def test_arguments_are_given_by_name():
    with pytest.raises(TypeError, match='incompatible'):
        native.Camera(*CAMERA.values())
    with pytest.raises(TypeError, match='incompatible'):
        native.Camera(**CAMERA, colour=1)


def test_an_error_of_a_pattern_is_the_error_of_the_picture():
    def missing(**_):
        raise LookupError('no such pattern')
    scene = native.Scene(camera=native.Camera(**CAMERA), solids=[native.Solid.box(**BOX)],
                           background=native.Background(**BACKGROUND), pattern=missing,
                           light=native.Light(upright=1.0, x=0.0, y=0.0), response=RESPONSE)
    with pytest.raises(LookupError, match='no such pattern'):
        scene.picture(native.Pose(-2.0, 0.0, 0.5, 0.0), bgr=False)


def test_a_package_that_was_not_built_says_what_to_type():
    program = 'import sys; sys.modules["sim_scene._native"] = None; import sim_scene.renderer'
    done = subprocess.run([sys.executable, '-c', program], stderr=subprocess.PIPE, text=True, check=False, timeout=60)
    assert done.returncode == 1 and 'build it with ./run build or catkin_make' in done.stderr.splitlines()[-1]
