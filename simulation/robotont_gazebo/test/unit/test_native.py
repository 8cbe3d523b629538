"""The compiled steps of the renderer find the layers that numpy finds, and draw the same pictures."""
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan
from robotont_gazebo.core import native, visibility, worlds
from robotont_gazebo.core.camera import CameraPose
from robotont_gazebo.core.renderer import Renderer
from unit_support.reference_camera import random_plan

PACKAGE = pathlib.Path(__file__).parents[4] / 'simulation' / 'robotont_gazebo'
EYE = 0.2155  # [m] height of the Robotont's camera
MOST, MEAN = 3, 0.2  # greys by which pictures may differ: patterns are rounded elsewhere
MAZE = worlds.read_yaml(PACKAGE / 'worlds' / 'minimaze_ar.yaml')
PICKETS = FloorPlan(boxes=tuple(Box(f'picket{k}', 2.0, -2.0 + 0.025 * k, 0.0, 0.01, 0.01, 0.3) for k in range(160)))
STAIRS = FloorPlan(boxes=tuple(Box(f'stair{k}', 1.0 + k, 0.0, 0.0, 0.5, 4.0, 0.1 + 0.01 * k) for k in range(20)))


def both(monkeypatch, *arguments, **options):
    """Return two Renderers, with and without the compiled steps."""
    compiled = Renderer(*arguments, **options)
    with monkeypatch.context() as changed:
        changed.setattr(native, 'library', None)
        return compiled, Renderer(*arguments, **options)


def check(monkeypatch, plan, pose, *size, **options):
    compiled, plain = both(monkeypatch, plan, *size, **options)
    difference = np.abs(compiled.render(pose).astype(int) - plain.render(pose))
    assert difference.max() <= MOST and difference.mean() <= MEAN
    assert np.array_equal(compiled.depth(pose), plain.depth(pose), equal_nan=True)


def test_the_workspace_has_the_compiled_steps():
    assert native.library is not None, f'{native.NAME} is not there: type ./run build'


@pytest.mark.parametrize('seed', range(20))
@pytest.mark.parametrize('patterns', [True, False])
def test_random_worlds_look_the_same(monkeypatch, seed, patterns):
    rng = np.random.default_rng(seed)
    pose = (*rng.uniform(-3, 3, 2), rng.choice([EYE, EYE, 0.6, 1.5]), rng.uniform(-4, 4))
    check(monkeypatch, random_plan(rng), pose, 203, 151, patterns=patterns)  # no multiple of a block of columns


@pytest.mark.parametrize('seed', range(10))
def test_the_maze_looks_the_same(monkeypatch, seed):
    rng = np.random.default_rng(seed)
    check(monkeypatch, MAZE, (*rng.uniform(-2.5, 2.5, 2), EYE, rng.uniform(-4, 4)), 640, 480)


@pytest.mark.parametrize('plan, z', [(PICKETS, EYE), (STAIRS, 1.5), (FloorPlan(), EYE), (FloorPlan(), 0.0),
                                     (FloorPlan(), -1.0)],
                         ids=['many runs', 'many layers', 'nothing', 'on the floor', 'below it'])
def test_there_is_room_for_any_number_of_layers_and_runs(monkeypatch, plan, z):
    check(monkeypatch, plan, (-2.0, 0.1, z, 0.02), 640, 360)


def test_a_narrow_and_a_wide_view_look_the_same(monkeypatch):
    for width, height, fov in ((16, 16, 2.8), (17, 33, 0.05), (1280, 720, 1.0)):
        check(monkeypatch, MAZE, (-2.0, 0.3, EYE, 0.4), width, height, fov)


@pytest.mark.parametrize('seed', range(20))
def test_layers_are_the_same_to_the_bit(monkeypatch, seed):
    rng = np.random.default_rng(100 + seed)
    plan = random_plan(rng)
    renderer = Renderer(plan, 203, 151)
    pose = CameraPose(*rng.uniform(-3, 3, 2), rng.choice([EYE, 0.02, 0.6, 1.5]), rng.uniform(-4, 4))
    expected = visibility.visible_from(visibility.Solids(plan), renderer.camera, pose)
    found = renderer.visible_from(pose)
    assert np.array_equal(found.floor_from, expected.floor_from)
    assert len(found.layers) == len(expected.layers)
    for ours, plain in zip(found.layers, expected.layers):
        assert all(map(np.array_equal, ours, plain))


def test_a_renderer_draws_the_same_again_after_other_pictures():
    renderer, pose = Renderer(STAIRS, 320, 240), (-2.0, 0.1, 1.5, 0.02)
    first = renderer.render(pose)
    kept, depth = first.copy(), renderer.depth(pose)
    for yaw in (1.0, 2.0, 3.0):
        renderer.render((0.0, 0.0, EYE, yaw))
    assert np.array_equal(renderer.depth(pose), depth, equal_nan=True)
    assert np.array_equal(renderer.render(pose), kept) and np.array_equal(first, kept)


@pytest.mark.usefixtures('each_renderer')
def test_blue_comes_first_if_asked_for():
    world = FloorPlan(cylinders=(Cylinder('post', 1.0, 0.2, 0.2, 0.5, 0.0, (200, 100, 50)),))
    renderer, pose = Renderer(world, 200, 150), (0.0, 0.0, EYE, 0.0)
    assert np.array_equal(renderer.render(pose, bgr=True)[..., ::-1], renderer.render(pose))


def test_the_environment_switches_the_compiled_steps_off():
    program = 'from robotont_gazebo.core import native; print(native.library)'
    out = subprocess.run([sys.executable, '-c', program], env={**os.environ, native.PLAIN: '1'},
                         stdout=subprocess.PIPE, text=True, check=True, timeout=60).stdout
    assert out == 'None\n'
