"""course_grader.rules.robot_sensors: what a robot sees of a world, compared with its rendered images."""
import math

import pytest
import yaml

from course_grader.rules import exercise, robot_sensors
from depthimage_to_laserscan.core import projection
from kinematic_core.worlds import camera, world_format
from kinematic_core.worlds.frames import CAMERA_X, CAMERA_Z, ahead
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.sectors import SCAN_HEIGHT, split
from sim_scene.renderer import Renderer
from unit_support import REPOSITORY
from unit_support.course_files import EXERCISES

BOX = {'name': 'box', 'x': 2.0, 'y': 0.0, 'yaw': 0.0, 'length': 1.0, 'width': 1.0, 'height': 1.0}  # from x = 1.5 on
MILLIMETRE, CENTIMETRE = 1e-3, 1e-2  # [m]


def look(x, *shapes, yaw=0.0, **kinds):
    """Return the Sectors of a robot whose camera is at ``x`` [m]."""
    plan = world_format.parse({'boxes': list(shapes), **kinds})
    pose = Pose2D(x - CAMERA_X * math.cos(yaw), -CAMERA_X * math.sin(yaw), yaw)
    return robot_sensors.DistanceSensor(plan).measure(pose)


def test_the_box_ahead():
    sectors = look(1.0, BOX)
    assert sectors.center.nearest == pytest.approx(0.5, abs=MILLIMETRE)
    assert sectors.left.nearest == pytest.approx(0.5 / math.cos(math.radians(15.0)), abs=MILLIMETRE)  # its first ray


def test_nearer_than_the_camera_sees():
    assert math.isnan(look(1.11, BOX).center.nearest)
    assert look(1.09, BOX).center.nearest == pytest.approx(0.41, abs=MILLIMETRE)


def test_the_floor_hides_what_is_far():
    """The lowest of 200 rows looks 100 px down at a focal length of 640 px, from 21.55 cm: floor at 1.379 m."""
    assert CAMERA_Z == pytest.approx(0.2155)
    assert look(0.0, BOX).center.nearest == look(0.0).center.nearest == pytest.approx(1.379, abs=MILLIMETRE)


def test_posts_to_the_left_and_right():
    def post(name, y):
        return {'name': name, 'x': 1.0, 'y': y, 'radius': 0.1, 'height': 0.5}
    sectors = look(0.0, cylinders=[post('left', 0.5), post('right', -0.6)])
    assert sectors.left.nearest == pytest.approx(math.hypot(1.0, 0.5) - 0.1, abs=MILLIMETRE)
    assert sectors.right.nearest == pytest.approx(math.hypot(1.0, 0.6) - 0.1, abs=MILLIMETRE)
    assert sectors.left.mean < sectors.right.mean


@pytest.mark.parametrize('pose', [Pose2D(0.2, 0.1, 0.1), Pose2D(0.6, -0.2, -0.2), Pose2D(0.95, 0.0, 0.0)])
def test_it_tells_what_the_depth_image_tells(pose):
    """The whole chain of robotont_laserscan_to_distance: image, scan of 200 rows, sectors."""
    post = {'name': 'post', 'x': 1.2, 'y': 0.7, 'radius': 0.1, 'height': 0.5}
    plan = world_format.parse({'boxes': [BOX], 'cylinders': [post]})
    size = camera.PinholeCamera()
    image = Renderer(plan, size.width, size.height).depth((*ahead(pose, CAMERA_X), CAMERA_Z, pose.yaw))
    fx, _, cx, _, _, cy, *_ = size.matrix()
    scan = projection.scan(image, projection.Camera(fx, cx, cy), projection.Settings(SCAN_HEIGHT, 0.2, 6.0))
    seen, told = split(scan.ranges), robot_sensors.DistanceSensor(plan).measure(pose)
    for side in ('left', 'center', 'right'):
        assert getattr(told, side) == pytest.approx(getattr(seen, side), abs=2.0 * CENTIMETRE, nan_ok=True), side


@pytest.mark.parametrize('pose, position, seen', [
    (Pose2D(0.0, 0.0, 0.0), (2.0 - CAMERA_X, 0.5), True),
    (Pose2D(2.0, 0.0, math.pi / 2.0), (0.5 - CAMERA_X, 0.0), True),  # it looks to the left: the marker is ahead
    (Pose2D(2.0, 0.0, 0.0), (-CAMERA_X, 0.5), False),  # too far to the left
    (Pose2D(0.0, 0.0, math.pi), (-2.0 - CAMERA_X, -0.5), False),  # behind
])
def test_where_a_marker_is(pose, position, seen):
    plan = world_format.parse({'panels': [{'name': 'm', 'marker_id': 7, 'x': 2.0, 'y': 0.5, 'yaw': 0.0}]})
    found = robot_sensors.markers(plan, 0.0, pose)[7]
    assert found[:2] == pytest.approx(position) and robot_sensors.in_view(found) == seen


WALL = {'name': 'wall', 'x': 1.0, 'y': 0.0, 'yaw': 0.0, 'length': 0.1, 'width': 0.3, 'height': 0.5}


@pytest.mark.parametrize('pose, yaw, boxes, seen', [
    (Pose2D(0.0, 0.0, 0.0), 0.0, [], True),
    (Pose2D(0.0, 0.0, 0.0), 0.0, [WALL], False),
    (Pose2D(0.0, 0.5, -0.2), 0.0, [WALL], True),  # it looks past the wall
    (Pose2D(0.0, 0.0, 0.0), 1.2, [], True),  # from 69 degrees
    (Pose2D(0.0, 0.0, 0.0), 1.4, [], False),  # from 80 degrees: narrower than 18 % of its width
    (Pose2D(4.0, 0.0, math.pi), 0.0, [], False),  # from behind
])
def test_a_marker_is_seen_from_the_front_and_not_through_walls(pose, yaw, boxes, seen):
    panel = {'name': 'm', 'marker_id': 7, 'x': 2.0, 'y': 0.0, 'yaw': yaw}
    plan = world_format.parse({'boxes': boxes, 'panels': [panel]})
    assert list(robot_sensors.MarkerCamera(plan).seen(0.0, pose)) == [7] * seen


def test_a_marker_that_moves():
    plan = world_format.parse({'panels': [{'name': 'm', 'marker_id': 7, 'x': 1.0, 'y': 0.0, 'yaw': 0.0,
                                     'path': [[0, 1.0, 0.0, 0.0], [10, 2.0, 0.0, 0.0]]}]})
    assert robot_sensors.markers(plan, 5.0, Pose2D(0.0, 0.0, 0.0))[7][0] == pytest.approx(1.5 - CAMERA_X)


def test_the_worlds_of_exercises_are_those_of_the_course():
    """The box of bang-bang is that of world_bangbang.launch."""
    path = REPOSITORY / 'packages' / 'robotont' / 'robotont_gazebo' / 'worlds' / 'bangbang.yaml'
    world = yaml.safe_load(path.read_text(encoding='utf-8'))
    for name in ('bang_bang', 'p_controller'):
        assert exercise.load(EXERCISES[name]).world == world
