"""sim_scene.worlds: world files of our own, good and bad, and the way to a world by its name."""
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.colours import COLOURS
from kinematic_core.worlds.floor_plan import EMPTY, GREY, Box, Cylinder, FloorPlan, Panel
from kinematic_core.worlds.robot_world import RobotWorld
from kinematic_core.worlds.world_format import parse_json, to_json
from sim_scene.worlds import WorldError, find_world, load_world, read_yaml
from unit_support.packages import PACKAGES

FOLDER = PACKAGES['robotont_gazebo'].folder / 'worlds'
BOX = '{name: wall, x: 1.0, y: 2, yaw: 0.5, length: 0.1, width: 2.0, height: 0.5}'


@pytest.fixture
def world(tmp_path):
    """Return a function that writes a world file and returns its path."""
    def write(text, name='w.yaml'):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return str(path)
    return write


@pytest.mark.parametrize('text, plan', [
    ('', EMPTY),
    ('{}', EMPTY),
    ('# nothing', EMPTY),
    (f'boxes: [{BOX}]', FloorPlan(boxes=(Box('wall', 1.0, 2, 0.5, 0.1, 2.0, 0.5, 0.0, GREY),))),
    ('cylinders: [{name: c, x: 0.0, y: 0.0, radius: 0.5, height: 1.0, bottom: 0.2, colour: purple}]',
     FloorPlan(cylinders=(Cylinder('c', 0.0, 0.0, 0.5, 1.0, 0.2, (255, 0, 255)),))),
    ('panels: [{name: m, marker_id: 7, x: 0.0, y: 0.0, yaw: 1.57}]',
     FloorPlan(panels=(Panel('m', 7, 0.0, 0.0, 1.57),))),
    ('ground_colour: white\nsky_colour: [1, 2, 3]',
     FloorPlan(ground_colour=(255, 255, 255), sky_colour=(1, 2, 3))),
    (f'may_overlap: true\nboxes: [{BOX}, {BOX.replace("wall", "b")}]',
     FloorPlan(boxes=(Box('wall', 1.0, 2, 0.5, 0.1, 2.0, 0.5), Box('b', 1.0, 2, 0.5, 0.1, 2.0, 0.5)))),
])
def test_good_world(world, text, plan):
    assert read_yaml(world(text)) == plan


@pytest.mark.parametrize('text, said', [
    ('boxes: {', 'not YAML: .*line 1'),
    ('- a', r"the world is \['a'\]; it must be a mapping with some of the keys: ground_colour"),
    ('walls: []', "the world: unknown key 'walls'; the keys are: ground_colour, sky_colour, may_overlap, boxes"),
    ('boxes: 3', 'boxes is 3; it must be a list of shapes'),
    ('boxes: [3]', r'boxes\[0\] is 3; it must be a mapping'),
    ('boxes: [{name: a, x: 1.0}]', r'boxes\[0\] \(a\): y is missing'),
    ('boxes: [{x: 1.0}]', r'boxes\[0\]: name is missing'),
    (f'boxes: [{BOX}, {BOX[:-1]}, weight: 3}}]', r"boxes\[1\]: unknown key 'weight'; the keys are: name, x, y, yaw"),
    (f'boxes: [{BOX}, {BOX}]', 'wall: the name is used twice'),
    (f'boxes: [{BOX}, {BOX.replace("wall", "b")}]',
     'wall and b overlap by 0.100 m; move one of them, or set may_overlap: true'),
    (f'boxes: [{BOX.replace("0.1", "0.0")}]', 'wall: length is 0; it must be above 0'),
    (f'boxes: [{BOX.replace("1.0", "")}]', 'wall: x is None; it must be a finite number'),
    (f'boxes: [{BOX[:-1]}, colour: pink}}]',
     r"boxes\[0\] \(wall\): colour is 'pink'; it must be \[red, green, blue\], 0 to 255 each, or one of: black"),
    ('sky_colour: 5', 'sky_colour is 5'),
    ('may_overlap: 1', 'may_overlap is 1; it must be true or false'),
    (b'boxes: \xff\xfe', 'not UTF-8 text'),
])
def test_bad_world_is_refused_with_file_and_key(world, text, said):
    path = world(text)
    with pytest.raises(WorldError, match=said) as error:
        read_yaml(path)
    assert str(error.value).startswith(f'{path}: ')


@pytest.mark.parametrize('given_, path', [
    ('minimaze', FOLDER / 'minimaze.yaml'),
    ('worlds/minimaze_ar.world', FOLDER / 'minimaze_ar.yaml'),
    ('/opt/somewhere/share/robotont_gazebo/worlds/empty.world', FOLDER / 'empty.yaml'),
])
def test_world_is_found_by_its_name(given_, path):
    assert find_world(given_, FOLDER) == str(path)


def test_file_goes_before_a_name(world):
    path = world('{}', 'minimaze.yaml')
    assert find_world(path, FOLDER) == path


@pytest.mark.parametrize('given_', ['nowhere', 'worlds/nowhere.world', '', '/'])
def test_unknown_world_is_refused_with_those_there_are(given_):
    known = 'bangbang, between, colors, empty, mapping, maze, minimaze, '
    with pytest.raises(WorldError, match=f'there is no world .*{known}'):
        load_world(given_, FOLDER)


def test_file_of_another_kind_is_refused(world):
    with pytest.raises(WorldError, match=r'w.txt: the name of a world file ends in .yaml, .world or .sdf'):
        load_world(world('{}', 'w.txt'), FOLDER)


@pytest.mark.parametrize('name, boxes, cylinders, panels, start', [
    ('empty', 0, 0, 0, 0.0), ('minimaze', 16, 0, 0, -2.0), ('minimaze_ar', 16, 0, 5, -2.0), ('bangbang', 1, 0, 0, 0.0),
    ('between', 7, 0, 0, -2.0), ('colors', 0, 6, 0, 0.0),
])
def test_worlds_of_the_package(name, boxes, cylinders, panels, start):
    plan, warnings = load_world(name, FOLDER)
    assert (len(plan.boxes), len(plan.cylinders), len(plan.panels)) == (boxes, cylinders, panels)
    assert warnings == []
    world = RobotWorld(plan)  # the origin is free as well
    world.place(start, 0.0, 0.0)


def test_maze_has_thresholds_and_marker_1_is_seen_from_the_left_of_the_start():
    plan, _ = load_world('minimaze_ar', FOLDER)
    low = [box for box in plan.boxes if box.height < 0.1]
    assert sorted(box.name for box in low) == ['door1', 'door2'] and {box.height for box in low} == {0.05}
    marker = next(panel for panel in plan.panels if panel.marker_id == 1)
    # the face looks along its own -x axis: down the y axis, at the robot at (-2, 0)
    assert (-math.cos(marker.yaw), -math.sin(marker.yaw)) == pytest.approx((0.0, -1.0), abs=1e-3)
    assert (marker.x, marker.y, marker.bottom, marker.size, marker.marker_size) == (-2.0, 2.9, 0.05, 0.4, 0.28)
    assert {panel.name: panel.marker_id for panel in plan.panels} == {f'marker{n}': n for n in range(1, 6)}


finite = st.floats(-100.0, 100.0)
sizes = st.floats(0.01, 10.0)
colours = st.tuples(*[st.integers(0, 255)] * 3)


@given(st.lists(st.tuples(finite, finite, finite, sizes, sizes, sizes, st.floats(0.0, 3.0), colours), max_size=3),
       st.lists(st.tuples(finite, finite, sizes, sizes, st.floats(0.0, 3.0), colours), max_size=3),
       st.lists(st.tuples(st.integers(0, 2 ** 31), finite, finite, finite), max_size=3), colours)
def test_json_makes_the_same_plan_again(boxes, cylinders, panels, sky):
    plan = FloorPlan(tuple(Box(f'b{n}', *box) for n, box in enumerate(boxes)),
                     tuple(Cylinder(f'c{n}', *cylinder) for n, cylinder in enumerate(cylinders)),
                     tuple(Panel(f'p{n}', *panel) for n, panel in enumerate(panels)), sky_colour=sky)
    assert parse_json(to_json(plan)) == plan


def test_json_is_a_world_file(world):
    plan, _ = load_world('between', FOLDER)
    assert read_yaml(world(to_json(plan))) == plan
    assert json.loads(to_json(plan))['may_overlap'] is True


def test_readme_lists_the_colours_and_the_keys():
    readme = (FOLDER.parent / 'README.md').read_text(encoding='utf-8')
    assert f'Colours: {", ".join(COLOURS)}.' in readme
    for kind in (Box, Cylinder, Panel):
        assert all(f'`{field}`' in readme for field in kind._fields)
