"""course_grader.rules.path_mistakes: mistakes that the path and the commands show."""
import math

import pytest

from course_grader.rules import exercise, path_mistakes, registry
from course_grader.rules.observation import Command, Observed, Sample, Sensed
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle


def found(name, act, check='draws', start=(3.0, 3.0)):
    """Return the advice on a check for the motion of a turtle in an exercise."""
    turtle = GradedTurtle(*start)
    act(turtle)
    one = exercise.load(EXERCISES[name])
    return path_mistakes.found(one, turtle.observed, [check]).get(check)


def polygon(turtle, side=4.0, turned=1.5708, sides=4, moving=0.0):
    for number in range(sides):
        turtle.drive(side if isinstance(side, float) else side[number % 2], 1.0, 0.0, 50.0)
        turtle.drive(2.0, moving, turned / 2.0, 50.0)


def visit(turtle, *corners):
    for corner in corners:
        turtle.teleport(*corner)


@pytest.mark.parametrize('shape, advice', [
    ({'turned': 1.0472}, 'turns by 60 degrees; a square needs 90'),
    ({'side': (4.0, 2.0)}, 'its sides are 2.0 m and 4.0 m long'),
    ({'side': 2.0, 'moving': 0.5}, 'the corners are round'), ({'side': 9.0}, 'into a wall'),
    ({'side': 3.5, 'turned': 0.7854}, 'turns by 45 degrees; a square'), ({'turned': 0.0, 'moving': 1.0}, 'never turns'),
    ({}, None), ({'sides': 3}, None), ({'sides': 0}, None)])
def test_polygons_that_are_driven(shape, advice):
    said = found('square_by_topics', lambda turtle: polygon(turtle, **shape))
    assert advice in said[0] if advice else said == []


@pytest.mark.parametrize('corners, advice', [
    (((2, 2), (8, 8), (8, 2), (2, 8), (2, 2)), 'wrong order'),
    (((2, 2), (8, 2), (8, 5), (2, 5), (2, 2)), '3.0 m and 6.0 m'),
    (((3, 3), (7, 3), (7, 7), (3, 7), (3, 3)), None), (((3, 3), (7, 3), (7, 7), (3, 7)), None)])
def test_corners_that_are_visited(corners, advice):
    said = found('square_by_teleport', lambda turtle: visit(turtle, *corners))
    assert advice in said[0] if advice else said == []


@pytest.mark.parametrize('start, corners, told', [
    ((4.5, 5.2), [(7.5, 5.5), (7.5, 7.5), (5.5, 7.5), (5.5, 5.5)], True),  # four corners, as from the middle
    ((4.1, 5.9), [(7.5, 5.5), (7.5, 7.5), (5.5, 7.5), (5.5, 5.5)], True),
    ((4.5, 5.2), [(5.5, 5.5), (5.5, 7.5), (7.5, 7.5), (7.5, 5.5)], True),  # clockwise
    ((4.5, 5.2), [(7.5, 5.5), (7.5, 7.5), (5.5, 7.5), (5.5, 5.5), (7.5, 5.5)], False),  # that is the square
    ((4.5, 5.2), [(7.5, 5.5), (7.5, 7.5), (5.5, 7.5), (5.5, 6.5)], False),  # no square
    ((4.5, 5.2), [(7.5, 5.5), (7.5, 7.5), (5.5, 7.5)], False)])
def test_the_way_from_the_start_is_no_side(start, corners, told):
    said = found('square_by_topics', lambda turtle: visit(turtle, *corners), start=start)
    assert any(hint.startswith(f'the last side is missing: it started at ({start[0]}, {start[1]})')
               and f'back to the first corner, ({corners[0][0]}, {corners[0][1]})' in hint for hint in said) == told


@pytest.mark.parametrize('linear, angular, advice', [
    (0.2, 0.5, 'swapped'), (0.5, 11.46, 'rad/s'), (0.5, 0.2, None),
    (1.0, 0.2, 'linear.x is 1 in 30 of 30 commands, and not 0.45 to 0.55 m/s'),
    (0.5, -0.2, 'angular.z is -0.2, which has the wrong sign'),
    (-0.5, 0.2, 'linear.x is -0.5, which has the wrong sign'),
    (0.5, 0.0, 'angular.z is 0: it is the turn speed'), (0.0, 0.2, 'linear.x is 0: it is the speed, positive forward')])
def test_velocities(linear, angular, advice):
    said = found('publish_circle', lambda turtle: turtle.drive(3.0, linear, angular), 'commands')
    assert advice in said[0] if advice else said == []


def test_two_commands_show_a_rate():
    said = found('robot_forward', lambda turtle: turtle.drive(10.0, 0.2, 0.0, 0.2), 'commands')
    assert said[0].startswith('it publishes 0.2 times per second: rospy.Rate(1)')


def test_wrong_velocities_explain_the_path():
    turtle = GradedTurtle(5.0, 5.0).drive(35.0, 0.5, 11.46)
    turtle.observed.timed_out = True
    one = exercise.load(EXERCISES['publish_circle'])
    assert list(path_mistakes.found(one, turtle.observed, ['commands', 'draws'])) == ['commands']


@pytest.mark.parametrize('name, angular, advice', [
    ('~angular', 0.0, 'angular.z is 0.0, the default of ~angular: the parameter is not set'), ('~angular', 0.3, None),
    ('angular', 0.0, 'angular.z is 0.0, the default of angular: a parameter inside of a <node> is private')])
def test_a_parameter_that_is_not_set(name, angular, advice):
    turtle = GradedTurtle(3.0, 3.0).drive(3.0, 0.5, angular)
    turtle.observed.source = f"v.linear.x = rospy.get_param('~linear', 1.0)\nturn = rospy.get_param('{name}', 0.0)\n"
    one = exercise.load(EXERCISES['launch_two_turtles'])
    said = path_mistakes.found(one, turtle.observed, ['commands'])['commands']
    assert said[0].startswith(advice) if advice else not any('default' in hint for hint in said)


@pytest.mark.parametrize('act, values, advice', [
    (GradedTurtle.drive, (1.0, 1.0), 'the turtle drives: call /turtle1/teleport_absolute'),
    (GradedTurtle.wait, (1.0,), 'no call of /turtle1/teleport_absolute arrived'),
    (GradedTurtle.teleport, (1.0, 1.0), None)])
def test_positions(act, values, advice):
    said = found('black_path', lambda turtle: act(turtle, *values), 'positions')
    assert advice in said[0] if advice else said == []


def test_other_checks_and_those_that_lost_nothing_get_none():
    turtle = GradedTurtle()
    one = exercise.load(EXERCISES['publish_circle'])
    assert path_mistakes.found(one, turtle.observed, ['prints']) == {}
    assert set(path_mistakes.KINDS) <= set(registry.RULES)


@pytest.mark.parametrize('pause, advice', [(3.0, 'after 1 s without a command'), (1.0, None)])
def test_velocities_that_are_sent_once(pause, advice):
    turtle = GradedTurtle(3.0, 3.0)
    turtle.drive(3.0 * pause, 0.5, 0.2, rate=1.0 / pause).drive(0.02)
    said = list(path_mistakes.stops_in_between(exercise.load(EXERCISES['publish_circle']), turtle.observed))
    assert advice in said[0] if advice else said == []


@pytest.mark.parametrize('pause, advice', [(1.0, 'every 1.0 s, and drives 3.0 m'), (0.05, None)])
def test_positions_that_are_looked_at_too_seldom(pause, advice):
    said = found('stop_at_x', lambda turtle: turtle.drive(3.0 * pause, 3.0, rate=1.0 / pause).drive(0.02), 'stops')
    assert advice in said[0] if advice else said == []


@pytest.mark.parametrize('x, stops, exit_code, advice', [
    (8.0, False, 0, 'its last command is not zero'), (8.0, True, 0, None), (8.0, False, None, None),
    (4.0, False, 0, None)])
def test_a_program_that_ends_while_the_turtle_drives(x, stops, exit_code, advice):
    turtle = GradedTurtle(x, 5.0).drive(2.1, 1.0).drive(0.1 if stops else 0.0)
    turtle.observed.exit_code = exit_code
    said = path_mistakes.found(exercise.load(EXERCISES['stop_at_x']), turtle.observed, ['stops'])['stops']
    assert advice in said[0] if advice else said == []


@pytest.mark.parametrize('last, advice', [([0.0, 1.0] * 10, True), ([1.0] * 10 + [0.0] * 10, False)])
def test_a_loop_that_drives_on_while_a_callback_stops(last, advice):
    seen = Observed(commands=[Command(0.1 * number, speed, 0.0, 0.0) for number, speed in enumerate([1.0] * 9 + last)])
    said = path_mistakes.found(exercise.load(EXERCISES['stop_at_x']), seen, ['stops'])['stops']
    assert any('of its last 29 commands 10 are 0' in hint for hint in said) == advice


def kept(name, what, goal, errors, speed):
    """Return the advice on velocities that are computed from errors, at ten commands per second."""
    seen = Observed()
    for number, error in enumerate(errors):
        seen.sensed.append(Sensed(0.1 * number, what, goal + error))
        velocity = speed(error)
        seen.commands.append(Command(0.1 * number + 0.05, 0.0 if what == 'marker left' else velocity, 0.0,
                                     velocity if what == 'marker left' else 0.0))
    return path_mistakes.found(exercise.load(EXERCISES[name]), seen, ['keeps'])['keeps']


@pytest.mark.parametrize('name, what, goal, errors, speed, advice', [
    ('p_controller', 'ahead', 0.5, [0.9 - 0.02 * number for number in range(40)] + [0.1] * 40,
     lambda error: 0.5 * error if error > 0.11 else 0.0, 'it stands 0.10 m off its goal, 0.5 m'),
    ('p_controller', 'ahead', 0.5, [0.9 * 0.99 ** number for number in range(100)], lambda error: 0.1 * error,
     'it is too slow, 0.33 m off its goal at the end'),
    ('p_controller', 'ahead', 0.5, [0.9 * 0.9 ** number for number in range(100)], lambda error: 0.5 * error, None),
    ('keep_distance', 'marker ahead', 0.6, [0.5, 0.4, 0.3, 0.2, *[-0.3] * 60], lambda error: error + 0.54,
     'linear.x is about 1 * (the distance - 0.06), which is 0 at 0.06 m, and not at 0.6 m: subtract 0.6'),
    ('keep_distance', 'marker ahead', 0.6, [0.5 + 0.01 * number for number in range(60)], lambda error: -0.3 * error,
     'linear.x has the wrong sign: it is about -0.3 * (the distance - 0.60)'),
    ('keep_centre', 'marker left', 0.0, [0.5 - 0.02 * number for number in range(60)], lambda error: -error,
     'angular.z or linear.y has the wrong sign: it is about -1 * (y'),
    ('keep_centre', 'marker left', 0.0, [0.5 - 0.02 * number for number in range(60)], lambda error: 0.3 * error + 0.1,
     'angular.z or linear.y is about 0.3 * (y - -0.33), which is not 0 straight ahead'),
    ('keep_distance', 'marker ahead', 0.6, [0.3, -0.3] * 20 + [-0.4] * 40, lambda error: 3.0 * error, 'it swings'),
    ('keep_distance', 'marker ahead', 0.6, [0.5, *[-0.3] * 60], lambda error: max(0.0, 15.0 * error),
     'its velocity is up to 7.5: choose a smaller gain'),
    ('keep_distance', 'marker ahead', 0.6, [0.6, 0.5, *[0.43, 0.37] * 30], lambda error: error - 0.4,
     'it keeps 1.00 m, and not 0.6 m: check the goal'),
    ('keep_distance', 'marker ahead', 0.6, [0.4] * 60, lambda error: 0.2 * error, None),
    ('keep_centre', 'marker left', 0.0, [0.3, -0.3] * 30, lambda error: 0.0, 'it never turns or drives sideways'),
    ('keep_centre', 'marker left', 0.0, [0.5 - 0.02 * number for number in range(60)],
     lambda error: 2.0 * error if abs(error) > 0.25 else 0.0,
     'its velocity is 0 up to an error of 0.24 m, but only 0.1 m'),
    ('bang_bang', 'ahead', 0.5, [0.5, 0.3, *[math.nan] * 40], lambda error: 0.2, 'it never drives backward'),
    ('bang_bang', 'ahead', 0.5, [0.5, 0.3, *[math.nan] * 40], lambda error: 0.2 if error > 0 else -0.2, None),
    ('keep_distance', 'marker ahead', 0.6, [0.01, -0.01] * 40, lambda error: error, None),
    ('keep_distance', 'marker ahead', 0.6, [0.4] * 10 + [-0.25] * 30, lambda error: max(0.0, error),
     'it never drives backward'),
    ('keep_distance', 'marker ahead', 0.6, [0.4] * 10 + [-0.25] * 30, lambda error: error, None),
    ('keep_centre', 'marker left', 0.0, [0.3] * 15 + [-0.2] * 5, lambda error: -error, 'it turns or drives away'),
    ('keep_centre', 'marker left', 0.0, [0.3] * 15 + [-0.2] * 5, lambda error: error, None),
    ('bang_bang', 'ahead', 0.5, [0.3] * 15 + [-0.2] * 5, lambda error: -error, 'it drives the wrong way'),
    ('bang_bang', 'ahead', 0.5, [0.3] * 15 + [-0.2] * 5, lambda error: error, None),
    ('keep_centre', 'marker left', 0.0, [0.3] * 8 + [-0.3] * 12, lambda error: -error, 'it turns or drives away'),
    ('keep_centre', 'marker left', 0.0, [0.3] * 8 + [-0.3] * 12, lambda error: error, None),
    ('keep_centre', 'marker left', 0.0, [0.5 - 0.02 * number for number in range(60)], lambda error: 0.5,
     path_mistakes.ONE_WAY)])
def test_what_the_errors_and_velocities_show(name, what, goal, errors, speed, advice):
    said = kept(name, what, goal, errors, speed)
    assert said[0].startswith(advice) if advice else not any(
        word in hint for hint in said for word in (
            'too slow', 'stands', 'swings', 'check the sign', 'never drives backward', 'to one side'))


@pytest.mark.parametrize('sides, advice', [
    ([0.012] * 9, 'it hardly steers'), ([0.6] * 9, None), ([0.0, 0.1, 0.2] * 7, None), ([0.0] * 20, None),
    ([-0.2] * 20, 'linear.y is -0.2 and angular.z 0 in all its commands')])
def test_how_a_robot_steers_between_posts(sides, advice):
    seen = Observed(commands=[Command(0.1 * number, 0.2, side, 0.0) for number, side in enumerate(sides)])
    said = path_mistakes.found(exercise.load(EXERCISES['between_posts']), seen, ['passes'])['passes']
    assert said[0].startswith(advice) if advice else said == []


@pytest.mark.parametrize('side, advice', [(-0.2, True), (0.2, False)])
def test_a_robot_that_steers_away_from_a_gate(side, advice):
    seen = Observed(track=[Sample(0.1 * number, 0.02 * number, 0.0, 0.0) for number in range(50)])
    seen.commands = [Command(sample.t, 0.2, side * (1.0 + sample.x), 0.0) for sample in seen.track]
    said = path_mistakes.found(exercise.load(EXERCISES['between_posts']), seen, ['passes'])['passes']
    assert any('it steers away from x = 1.2, y = 0.12: positive linear.y' in hint for hint in said) == advice
    said = path_mistakes.found(exercise.load(EXERCISES['ar_maze']), seen, ['passes'])  # its places are not ahead
    assert 'it steers away' not in str(said)


def test_a_vehicle_that_only_turns():
    turtle = GradedTurtle(5.0, 5.0).drive(9.0, 0.0, 1.0)
    said = path_mistakes.found(exercise.load(EXERCISES['square_by_topics']), turtle.observed, ['draws'])['draws']
    assert said[0].startswith('it only turns, by 5') and len(said) == 1
    measured = list(path_mistakes.measured(exercise.load(EXERCISES['stop_at_x']), turtle.observed, ['stops']))
    assert measured == said


def test_another_pace():
    seen = Observed(commands=[Command(0.1 * number, 0.5, 0.0, 0.0) for number in range(9)])
    assert path_mistakes.found(exercise.load(EXERCISES['bang_bang']), seen, ['commands'])['commands'] == [
        'linear.x is 0.5 m/s forward or backward, and not 0.19 to 0.21 m/s']


def test_velocities_that_are_seldom_as_asked():
    seen = Observed(commands=[Command(0.1 * number, 0.6 if number < 4 else 0.2, 0.0, 0.0) for number in range(9)])
    assert list(path_mistakes.measured(exercise.load(EXERCISES['p_controller']), seen, ['commands'])) == [
        'linear.x is 0.6 in 4 of 9 commands, and not -0.5 to 0.5 m/s']


@pytest.mark.parametrize('change, advice', [
    (0.8, 'it changes between forward and backward at 0.79 m, and not at 0.5 m'), (0.5, None)])
def test_where_a_velocity_changes(change, advice):
    seen = Observed()
    for number in range(60):
        value = 1.1 - 0.02 * (number % 45)
        seen.sensed.append(Sensed(0.1 * number, 'ahead', value))
        seen.commands.append(Command(0.1 * number + 0.05, math.copysign(0.2, value - change), 0.0, 0.0))
    said = path_mistakes.found(exercise.load(EXERCISES['bang_bang']), seen, ['keeps'])['keeps']
    assert said[0].startswith(advice) if advice else said == []


@pytest.mark.parametrize('off, advice', [(1, True), (0, False)])
def test_a_pen_that_is_off(off, advice):
    said = found('black_path', lambda turtle: visit(turtle.pen(0, 0, 0, 2, off), (2, 2), (8, 2)), 'pen')
    assert said == (['the pen is off while the turtle moves: the last argument of set_pen, off, has to be 0'] if advice
                    else [])


def test_small_turn_speeds_are_not_taken_for_degrees():
    said = found('robot_forward', lambda turtle: turtle.drive(10.0, 0.2, 0.5, 1.0), 'commands')
    assert not any('degrees' in hint for hint in said)


@pytest.mark.parametrize('name, axis, advice', [
    ('keep_centre', 'x', 'it uses position.x, but how far the marker is to the left, is position.y'),
    ('keep_distance', 'z', 'it uses position.z, but how far the marker is ahead, is position.x'),
    ('keep_distance', 'x', None)])
def test_another_axis_of_the_marker(name, axis, advice):
    seen = Observed(source=f'error = marker.pose.pose.position.{axis} - GOAL\n')
    said = path_mistakes.found(exercise.load(EXERCISES[name]), seen, ['keeps'])['keeps']
    assert said == ([advice] if advice else [])


@pytest.mark.parametrize('reads, advice', [
    (['/turtle1/pose'], 'the corner minus the position'), ([], 'into a wall of its window, at x = 11.1, y = 6.1')])
def test_who_stays_at_a_wall(reads, advice):
    turtle = GradedTurtle(9.0, 5.0)
    turtle.drive(1.0, 0.1, 0.5).drive(9.0, 1.0)
    turtle.observed.connections |= {(name, 'subscribes') for name in reads}
    one = exercise.load(EXERCISES['square_by_topics'])
    assert advice in path_mistakes.found(one, turtle.observed, ['draws'])['draws'][0]


@pytest.mark.parametrize('speed, advice', [(0.05, True), (0.2, False)])
def test_a_robot_that_is_too_slow_for_its_way(speed, advice):
    seen = Observed(track=[Sample(0.0, 0.0, 0.0, 0.0)], commands=[Command(0.1, speed, 0.2, 0.0)])
    seen.commands += [Command(0.1 * number, speed, 0.0, 0.0) for number in range(2, 9)]
    said = path_mistakes.found(exercise.load(EXERCISES['between_posts']), seen, ['passes'])['passes']
    assert any('it is too slow: with 0.05 m/s' in hint for hint in said) == advice


def followed(*steps, leader=(), reads=()):
    """Return the advice on a turtle2 that drives (speed, turn speed) for a second each."""
    x = y = theta = 0.0
    track = [Sample(0.0, x, y, theta)]
    for number, (speed, turn) in enumerate(steps, 1):
        x, y, theta = x + speed * math.cos(theta), y + speed * math.sin(theta), theta + turn
        track.append(Sample(float(number), x, y, theta))
    observed = Observed(turtles={'turtle2': track}, connections={
        ('/turtle2/cmd_vel', 'publishes'), *((name, 'subscribes') for name in reads)})
    observed.track = [Sample(sample.t, *leader, 0.0) for sample in track if leader]
    return path_mistakes.found(exercise.load(EXERCISES['follow_turtle']), observed, ['follows'])['follows']


WAY, BOTH, TF = [(0.5, 0.05)] * 5, ('/turtle1/pose', '/turtle2/pose'), ('/turtle1/pose', '/tf')


@pytest.mark.parametrize('steps, leader, reads, advice', [
    ([(0.0, 0.5)] * 5, (), (), 'turtle2 hardly moves'), ([(-0.5, 0.2)] * 5, (), (), 'turtle2 drives backward'),
    ([(0.5, 0.0)] * 5, (), (), 'turtle2 never turns'), ([(0.5, 0.3)] * 5, (), (), None),
    (WAY, (-2.0, 0.5), BOTH, 'turtle2 drives away from turtle1'),
    (WAY, (8.0, 1.0), BOTH, 'turtle2 is on its way to turtle1, but 5.'), (WAY, (8.0, 1.0), TF, 'turtle2 is on its way'),
    (WAY, (2.4, 0.5), TF, None), (WAY, (8.0, 1.0), BOTH[:1], 'it receives no pose of turtle2'),
    ([(0.5, 0.1)] * 5 + [(0.0, 0.0)] * 2, (8.0, 1.0), TF, 'turtle2 stops 5.'),
    ([(0.5, 0.1)] * 5 + [(0.0, 0.0)] * 2, (2.4, 0.5), TF, None)])
def test_a_follower_that_does_not_drive_as_it_should(steps, leader, reads, advice):
    said = followed(*steps, leader=leader, reads=reads)
    assert said[0].startswith(advice) if advice else said == []
