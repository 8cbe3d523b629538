"""course_grader.rules.robot_sensors, and the checks of a robot's sensors."""
import math

import pytest
import yaml

from course_grader.rules import exercise, robot_sensors, scoring
from course_grader.rules.observation import Command, Observed, Sample, Sensed
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
ROBOT = {'title': 'T', 'time': '10 s', 'simulator': 'robotont'}
DISTANCES, TRACKER = {'do': 'distances', 'for': '5 s'}, {'do': 'tracker', 'for': '5 s'}
AHEAD = {'check': 'keeps', 'what': 'ahead', 'value': '0.5 m'}


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


def judged(observed, stimulus=DISTANCES, **check):
    reason, = scoring.decide(exercise.parse({**ROBOT, 'stimuli': [stimulus], 'checks': [{'points': 100, **check}]}),
                             observed).reasons
    return reason


def sensed(*values, what='ahead'):
    """Return the Observed of a value [m] each second."""
    return Observed(sensed=[Sensed(float(t), what, value) for t, value in enumerate(values)])


@pytest.mark.parametrize('values, points, said', [
    ((1.4, 1.4, 0.55, 0.45, 0.5, 0.5), 100, 'the distance ahead by 0.45 to 0.55 m; 100% of the time within'),
    ((0.5, 0.5, 0.5, 0.5, 0.7, 0.8), 50, '0.50 to 0.80 m; 50%'),
    ((0.5, 0.5, 0.5, math.nan, math.nan, math.nan), 25, '0.50 to 0.50 m; 25%'),
    ((math.nan,) * 6, 0, 'unknown, as it is too near'),
    ((), 0, 'the program subscribes to no sensor'),
])
def test_keeps(values, points, said):
    reason = judged(sensed(*values), **AHEAD, tolerance='0.1 m', last='3 s')
    assert reason.points == points and said in reason.seen


@pytest.mark.parametrize('speeds, points', [
    ((0.4, 0.2, 0.1, 0.0), 100), ((0.4, -0.2, 0.1, -0.0005, 0.0005), 100),  # below 1 mm/s it stands
    ((0.4, -0.2, 0.1, -0.05, 0.02), 0)])
def test_keeps_without_swinging(speeds, points):
    observed = sensed(0.5, 0.5, 0.5)
    observed.commands = [Command(float(t), speed, 0.0, 0.0) for t, speed in enumerate(speeds)]
    assert judged(observed, **AHEAD, swings=2).points == points


def test_keeps_a_marker_at_its_place():
    check = {'check': 'keeps', 'what': 'marker left', 'value': '0 m'}
    assert judged(sensed(0.02, -0.02, what='marker left'), TRACKER, **check).points == 100
    assert judged(sensed(0.02, -0.02, what='marker ahead'), TRACKER, **check).points == 0


@pytest.mark.parametrize('y, points', [(0.05, 100), (0.15, 0), (-0.15, 0)])
def test_passes(y, points):
    track = [Sample(0.1 * number, 0.02 * number, y, 0.0) for number in range(100)]
    assert judged(Observed(track=track), check='passes', x='1 m', y='0 m').points == points


@pytest.mark.parametrize('changes, said', [
    ({'world': {'boxes': [{**BOX, 'length': -1}]}}, 'world: box: length is -1'),
    ({'world': {'balls': []}}, 'world: '),
    ({'world': {'boxes': [BOX]}, 'simulator': 'turtlesim', 'stimuli': []}, 'world needs simulator: robotont'),
    ({'simulator': 'turtlesim'}, 'stimulus 1 (distances) needs simulator: robotont'),
    ({'checks': [{**AHEAD, 'points': 100}], 'stimuli': [TRACKER]}, 'check 1 (keeps) needs a stimulus {do: distances'),
    ({'checks': [{**AHEAD, 'what': 'marker left', 'points': 100}]}, 'check 1 (keeps) needs a stimulus {do: tracker'),
])
def test_wrong_exercises(changes, said):
    right = {**ROBOT, 'stimuli': [DISTANCES], 'checks': [{'check': 'moves', 'length': '1 m', 'points': 100}]}
    assert exercise.parse(right)
    with pytest.raises(exercise.ExerciseError) as error:
        exercise.parse({**right, **changes})
    assert str(error.value).startswith(said)


def test_the_worlds_of_exercises_are_those_of_the_course():
    """The box of bang-bang is that of world_bangbang.launch."""
    path = REPOSITORY / 'packages' / 'robotont' / 'robotont_gazebo' / 'worlds' / 'bangbang.yaml'
    world = yaml.safe_load(path.read_text(encoding='utf-8'))
    for name in ('bang_bang', 'p_controller'):
        assert exercise.load(EXERCISES[name]).world == world


TURNS = {'do': 'turns', 'for': '10 s'}
POSES = [(0.2, 0.3, -0.9), (-0.3, -0.4, 0.5), (0.4, -0.2, 0.8), (math.nan,) * 3, (-0.5, 0.5, -0.2)]  # roll, pitch, yaw


def turned(velocity):
    """Return the Observed of a program with linear.x ``velocity(roll, pitch, yaw)``; None: no command."""
    seen = Observed()
    for number, angles in enumerate(POSES):
        start = 2.0 * number
        seen.sensed += [Sensed(start, what, angle) for what, angle in zip(('roll', 'pitch', 'yaw'), angles)]
        value = velocity(*angles)
        seen.commands += [Command(start + 0.1 * tick, value, 0.0, 0.0) for tick in range(6, 20) if value is not None]
    return seen


def zero_if_hidden(velocity):
    return lambda *angles: 0.0 if math.isnan(angles[0]) else velocity(*angles)


def quaternion_y(roll, pitch, yaw):
    return (math.cos(roll / 2) * math.sin(pitch / 2) * math.cos(yaw / 2)
            + math.sin(roll / 2) * math.cos(pitch / 2) * math.sin(yaw / 2))


@pytest.mark.parametrize('velocity, right, said', [
    (zero_if_hidden(lambda roll, pitch, yaw: 0.5 * pitch), True, 'about 0.50 times pitch; it fits in 4 of 4 poses'),
    (lambda roll, pitch, yaw: None if math.isnan(roll) else 2.0 * pitch, True, '0 in 1 of 1 without a marker'),
    (zero_if_hidden(lambda roll, pitch, yaw: -0.5 * pitch), False, 'it has the other sign than pitch: it is -0.50'),
    (zero_if_hidden(lambda roll, pitch, yaw: 0.5 * roll), False, 'it follows roll, not pitch'),
    (zero_if_hidden(lambda roll, pitch, yaw: -0.5 * yaw), False, 'it follows yaw, not pitch'),
    (zero_if_hidden(lambda roll, pitch, yaw: 0.5 * abs(pitch)), False, 'and never negative'),
    (zero_if_hidden(lambda roll, pitch, yaw: math.copysign(0.2, pitch)), False, 'it fits in 1 of 4'),
    (zero_if_hidden(quaternion_y), False, 'it fits in'),
    (lambda roll, pitch, yaw: 0.2 if math.isnan(roll) else 0.5 * pitch, False, 'it is 0 in 0 of 1'),
    (lambda roll, pitch, yaw: 0.2, False, 'and never negative, and it is 0 in 0 of 1'),
    (lambda roll, pitch, yaw: None, False, '0 commands'),
])
def test_steers(velocity, right, said):
    reason = judged(turned(velocity), TURNS, check='steers', command='linear.x', by='pitch')
    assert said in reason.seen and (reason.points == 100 if right else reason.points < 50), reason


def test_steers_without_a_stimulus():
    assert judged(Observed(), TURNS, check='steers', command='angular.z', by='roll').seen == \
        'the program subscribes to no marker'
    with pytest.raises(exercise.ExerciseError, match='needs a stimulus {do: turns'):
        judged(Observed(), TRACKER, check='steers', command='angular.z', by='roll')
