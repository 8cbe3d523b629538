"""course_grader.rules.random_stimuli: seeds differ in numbers, not in what they ask. 1,000 of them, without grading."""
import itertools
import math

import pytest
import yaml

from course_grader.rules import exercise, random_stimuli, robot_sensors
from kinematic_core.worlds import world_format
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.turtle_world import ARENA_SIZE
from unit_support.course_files import EXERCISES as FILES

pytestmark = pytest.mark.slow

EXERCISES = {name: exercise.load(path) for name, path in FILES.items()}
SEEDS = range(1000)
CANCELLED = 3.0  # [s] that the goal which is cancelled lasts at most
BESIDE = 0.03  # [m] from the middle of a gate: there both posts are as near
CURVED = 0.05  # [1/m] between two legs: after 2 m they are 0.1 m apart
ROUNDED = 0.05  # a number with one decimal is so far off


def of_kind(what):
    """Return [(exercise, number of the stimulus)] of the exercises with this kind of stimulus."""
    return [pytest.param(one, number, id=name) for name, one in EXERCISES.items()
            for number, (kind, _) in enumerate(one.stimuli) if kind == what]


def drawn(one, number):
    return [random_stimuli.stimuli(one, seed)[number] for seed in SEEDS]


@pytest.mark.parametrize('one, number', of_kind('markers'))
def test_every_seed_shows_as_many_different_markers(one, number):
    shows = drawn(one, number)
    assert {tuple(sorted(map(len, messages))) for messages in shows} == {(0, 0, 0, 1, 2, 3, 3)}
    for messages in shows:
        ids = [marker for markers in messages for marker in markers]
        assert len(set(ids)) == len(ids) and set(ids) <= set(random_stimuli.IDS)
    assert len({tuple(messages[0]) for messages in shows}) > 500


@pytest.mark.parametrize('one, number', of_kind('markers'))
def test_in_no_seed_another_number_can_be_taken_for_x(one, number):
    for messages in drawn(one, number):
        positions = [position for markers in messages for position in markers.values()]
        assert all(abs(a[0] - b[0]) > ROUNDED for a, b in itertools.combinations(positions, 2))
        for markers in messages:
            assert all(abs(a[0] - other) > ROUNDED for a in markers.values() for b in markers.values()
                       for other in b[1:])


@pytest.mark.parametrize('one, number', of_kind('call'))
def test_in_every_seed_the_requests_differ_in_each_number(one, number):
    for requests in drawn(one, number):
        assert len(requests) == one.stimuli[number][1]['times']
        for field in zip(*requests):
            assert all(abs(a - b) > 2.0 * ROUNDED for a, b in itertools.combinations(field, 2))


@pytest.mark.parametrize('one, number', of_kind('drive'))
def test_in_every_seed_the_turtle_is_driven_without_a_wall(one, number):
    values, dt = one.stimuli[number][1], 0.05
    for seed, velocities in zip(SEEDS, drawn(one, number)):
        start = random_stimuli.start(one, seed)
        x, y, theta = start['x'], start['y'], start['theta']
        for step in range(int(values['for'] / dt)):
            linear, angular = velocities[int(step * dt / random_stimuli.LEG)]
            theta += angular * dt
            x, y = x + linear * dt * math.cos(theta), y + linear * dt * math.sin(theta)
            assert 0.1 < x < ARENA_SIZE - 0.1 and 0.1 < y < ARENA_SIZE - 0.1, seed


@pytest.mark.parametrize('one, number', of_kind('goals'))
def test_in_every_seed_the_goals_differ_and_have_time(one, number):
    """A server that adds two numbers per second, and the goal that is cancelled."""
    count = one.stimuli[number][1]['times']
    for orders in drawn(one, number):
        assert len(set(orders)) == len(orders) == count and set(orders) <= set(random_stimuli.ORDERS)
        assert sum((order - 1) / 2.0 for order in orders) + CANCELLED < 0.75 * one.time
    assert len(set(map(tuple, drawn(one, number)))) > len(random_stimuli.ORDERS)


@pytest.mark.parametrize('one, number', of_kind('distances'))
def test_in_every_seed_the_first_distances_say_the_same(one, number):
    """A box is beyond what the camera sees; two posts say to which side their middle is."""
    sensor = robot_sensors.DistanceSensor(world_format.parse(one.world))
    gate = next((scored.rule.y for scored in one.rules if scored.name == 'passes'), None)
    for pose in starts(one):
        right, center, left = sensor.measure(pose)
        if gate is None:
            assert center.nearest == pytest.approx(robot_sensors.FLOOR)
        elif abs(gate - pose.y) > BESIDE:
            assert (left.nearest > right.nearest) == (gate > pose.y)


@pytest.mark.parametrize('one, number', of_kind('turns'))
def test_in_every_seed_a_marker_is_turned_to_both_sides(one, number):
    """Of 13 poses 3 have no marker; all pairs of signs of roll and pitch occur, and a quaternion's part is no angle."""
    for poses in drawn(one, number):
        turned = [pose for pose in poses if pose]
        assert (len(poses), len(turned), poses[1]) == (13, 10, None)
        assert len({(roll > 0.0, pitch > 0.0) for roll, pitch, _ in turned}) == 4
        assert all(0.15 <= abs(angle) <= 0.5 for roll, pitch, _ in turned for angle in (roll, pitch))


@pytest.mark.parametrize('one, number', [param for param in of_kind('tracker') if param.id != 'ar_maze'])
def test_in_every_seed_the_robot_sees_the_marker(one, number):
    plan = world_format.parse(one.world)
    assert all(robot_sensors.in_view(at) for pose in starts(one)
               for at in robot_sensors.markers(plan, 0.0, pose).values())


def starts(one):
    return [Pose2D(at['x'], at['y'], at['theta']) for at in (random_stimuli.start(one, seed) for seed in SEEDS)]


@pytest.mark.parametrize('one', EXERCISES.values(), ids=list(EXERCISES))
def test_starts_lie_where_the_exercise_says(one):
    starts = [random_stimuli.start(one, seed) for seed in SEEDS]
    for axis, (low, high) in one.start.items():
        assert all(low <= start[axis] <= high for start in starts)
        assert max(start[axis] for start in starts) - min(start[axis] for start in starts) >= 0.9 * (high - low)
    assert starts[7] == random_stimuli.start(one, 7)


def test_very_many_markers_can_be_drawn():
    many = EXERCISES['print_marker_ids']._replace(stimuli=[('markers', {'for': 20.0, 'rate': 10.0, 'most': 100})])
    assert len(random_stimuli.stimuli(many, 1)[0]) == 200


@pytest.mark.parametrize('one, number', of_kind('drive'))
def test_in_no_seed_two_legs_are_the_same_arc(one, number):
    """Else who drives the first leg alone, for as long as both, drives the same path."""
    for velocities in drawn(one, number):
        curvatures = sorted(angular / linear for linear, angular in velocities)  # [1/m]
        assert all(after - before > CURVED for before, after in zip(curvatures, curvatures[1:]))


def test_a_world_is_shifted_with_what_the_checks_ask_for():
    one = exercise.parse({**yaml.safe_load(FILES['between_posts'].read_text()),
                          'shift': {'x': '1 m', 'y': '0.2 to 0.3 m'}})
    moved = random_stimuli.shifted(one, 7)
    by = moved.world['cylinders'][0]['y'] - one.world['cylinders'][0]['y']
    assert 0.199 < by < 0.301 and moved == random_stimuli.shifted(one, 7)
    assert len({random_stimuli.shifted(one, seed).world['cylinders'][0]['y'] for seed in range(100)}) > 5
    for before, after in zip(one.world['cylinders'], moved.world['cylinders']):
        assert (after['x'], after['y']) == pytest.approx((before['x'] + 1.0, before['y'] + by))
    passes = [(scored.rule.x, scored.rule.y) for scored in moved.rules if scored.name == 'passes']
    assert passes == [pytest.approx((2.2, 0.12 + by)), pytest.approx((3.6, -0.12 + by))]
    assert one.rules[0] == moved.rules[0]


def test_points_of_a_line_are_shifted():
    path = {'check': 'passes', 'through': [['1 m', '0 m'], ['2 m', '1 m']], 'points': 100}
    one = exercise.parse({'title': 'T', 'time': '9 s', 'simulator': 'robotont', 'checks': [path],
                          'world': {'cylinders': [{'name': 'a', 'x': 3, 'y': 0, 'radius': 0.1, 'height': 1}]},
                          'shift': {'x': '0.1 to 0.3 m'}})
    moved = random_stimuli.shifted(one, 7)
    by = round(moved.world['cylinders'][0]['x'] - 3.0, 6)
    assert 0.1 <= by <= 0.3
    assert moved.rules[0].rule.through == [(1.0 + by, 0.0), (2.0 + by, 1.0)]


def test_a_moving_panel_is_shifted_along_its_path():
    one = EXERCISES['keep_distance']._replace(shift={'x': (0.0, 0.0), 'y': (0.5, 0.5)})
    panel, moved = one.world['panels'][0], random_stimuli.shifted(one, 1).world['panels'][0]
    assert [y - 0.5 for _, _, y, _ in moved['path']] == [y for _, _, y, _ in panel['path']]
    assert random_stimuli.shifted(EXERCISES['keep_distance'], 1) is EXERCISES['keep_distance']


def test_the_robot_is_carried_to_another_pose_with_each_seed():
    made = exercise.parse({'title': 'T', 'time': '10 s', 'simulator': 'robotont',
                           'checks': [{'check': 'runs', 'points': 100}],
                           'stimuli': [{'do': 'carry', 'after': '5 s', 'x': '1 to 2 m', 'y': '-3 m'}]})
    (((x, y, theta),),), (((other, _, _),),) = (random_stimuli.stimuli(made, seed) for seed in (1, 2))
    assert 1.0 <= x <= 2.0 and (y, theta) == (-3.0, 0.0) and x != other
