"""course_grader.rules.rules_state: parameters, transforms, other turtles, and what a robot keeps or follows."""
import math

import pytest

from course_grader.rules.observation import Command, Event, Observed, Sample, Sensed, Transform
from course_grader.rules.rules_state import Background, Follows, HasParameter, HasTransform, Keeps, Spawns, Steers
from course_grader.rules.scoring import FULL
from kinematic_core.worlds.turtle_world import DT as STEP
from unit_support.graded_turtle import GradedTurtle


@pytest.mark.parametrize('value, wanted, share', [
    (0.5, 0.5, 1.0), (1, 1.0, 1.0), (0.30000000000000004, 0.3, 1.0), (0.5, 0.6, 0.0), ('fast', 'fast', 1.0),
    ('fast', 'slow', 0.0), (True, True, 1.0), (True, 1, 0.0), (1, True, 0.0), ([1, 2], 1, 0.0),
])
def test_the_value_of_a_parameter(value, wanted, share):
    result = HasParameter('/speed', wanted).judge(Observed(parameters={'/speed': value}))
    assert (result.share, result.seen) == (share, f'it is {value!r}')


def test_a_parameter_that_is_set_or_not():
    assert HasParameter('/speed').judge(Observed(parameters={'/speed': []})).share == 1.0
    assert HasParameter('/speed').judge(Observed(parameters={'/other': 1})) == (
        0.0, 'the parameter /speed is set', 'it is not set')


@pytest.mark.parametrize('events, share, seen', [
    ([], 0.0, '/clear was not called'), ([(255, 255, 0)], 1.0, 'it is (255, 255, 0)'),
    ([(255, 255, 0), (69, 86, 255)], 0.0, 'it is (69, 86, 255)'),  # cleared again after other parameters were set
    ([(69, 86, 255), (255, 255, 0)], 1.0, 'it is (255, 255, 0)')])
def test_the_background(events, share, seen):
    observed = Observed(events=[Event(1.0, 'clear', values) for values in events])
    result = Background((255, 255, 0)).judge(observed)
    assert (result.share, result.seen) == (share, seen)


def broadcast(rate=10.0, seconds=3.0, off=0.0, parent='world', child='turtle1', turned=0.0, stamped=True):
    """Return the Observed of a turtle that drives, and of its transforms."""
    turtle = GradedTurtle().drive(seconds, linear=0.5)
    samples = turtle.observed.track[::max(1, round(1.0 / rate / 0.016))]
    turtle.observed.transforms = [
        Transform(sample.t, parent, child, sample.x + off, sample.y, sample.theta + turned, stamped)
        for sample in samples]
    return turtle.observed


def old(share):
    """Return the same with a share of transforms whose stamps are old."""
    observed = broadcast()
    for number in range(round(share * len(observed.transforms))):
        observed.transforms[number] = observed.transforms[number]._replace(stamped=False)
    return observed


@pytest.mark.parametrize('observed, keys, right', [
    (broadcast(), {}, True), (broadcast(), {'at': 'the vehicle', 'rate': (8.0, 12.0)}, True),
    (broadcast(), {'parent': '/world'}, True),  # tf knows no /
    (broadcast(off=0.3), {'at': 'the vehicle'}, False),  # at 0.5 m/s it was never there within 0.3 s and 5 cm
    (broadcast(turned=0.3), {'at': 'the vehicle'}, False), (broadcast(turned=math.tau), {'at': 'the vehicle'}, True),
    (broadcast(turned=0.3), {}, True), (broadcast(child='turtle2'), {}, False),
    (broadcast(parent='turtle1', child='world'), {}, False),
    (broadcast(rate=1000.0), {'rate': (20.0, math.inf)}, True),
    (broadcast(stamped=False), {}, False),  # tf takes no second transform of the time 0
    (broadcast(stamped=False, seconds=0.0), {}, True),
    (old(0.1), {}, True), (old(0.5), {}, False),  # a stamp that was taken once, at the start
    (broadcast(seconds=0.0), {'rate': (10.0, 10.0)}, False),
])
def test_transforms(observed, keys, right):
    share = HasTransform(**{'parent': 'world', 'child': 'turtle1', **keys}).judge(observed).share
    assert share >= FULL if right else share == 0.0


def test_transforms_that_come_too_rarely_lose_points():
    result = HasTransform('world', 'turtle1', (10.0, 10.0)).judge(broadcast(rate=5.0))
    assert result.share == pytest.approx(0.25, abs=0.03) and result.seen.endswith(' Hz')  # half as often


def test_other_transforms_are_named():
    rule = HasTransform('world', 'turtle1')
    assert rule.judge(broadcast(child='turtle2'))[1:] == ('transforms from world to turtle1', 'only world to turtle2')
    assert rule.judge(Observed()).seen == 'none'


def line(start, speed, seconds=5.0, late=0.0):
    """Return the Samples of a turtle that drives along x from ``start`` [m] at ``speed`` [m/s] on y = 2."""
    return [Sample(late + number * STEP, start + speed * number * STEP, 2.0, 0.0)
            for number in range(int(seconds / STEP))]


@pytest.mark.parametrize('turtles, share, seen', [
    ({'turtle2': line(2.0, 1.0)}, 1.0, 'it starts at x = 2.00, y = 2.00'),
    ({'turtle2': line(2.1, 0.0)}, 0.0, 'it starts at x = 2.10, y = 2.00'),  # 5 cm are allowed
    ({}, 0.0, 'there is no turtle2'), ({'turtle2': []}, 0.0, 'there is no turtle2'),
])
def test_where_a_turtle_is_spawned(turtles, share, seen):
    result = Spawns('turtle2', 2.0, 2.0).judge(Observed(turtles=turtles))
    assert (result.share, result.seen) == (share, seen)


@pytest.mark.parametrize('leader, track, share, seen', [
    (line(5.0, -0.5), line(5.08, -0.5), 1.0, 'at the end it is 0.08 m away'),  # 10 cm are allowed
    (line(5.0, -0.5), line(5.0, -0.4), 0.0, 'at the end it is 0.50 m away'),  # 0.1 m/s slower for 5 s
    (line(2.5, 0.0), line(2.5, 0.0, 1.0) + line(0.0, 0.0, 1.0, 1.0) + line(2.5, 0.0, 3.0, 2.0), 0.0, 'it jumps'),
    (line(2.5, 0.0), [], 0.0, 'there is no turtle2'), ([], line(2.5, 0.0), 0.0, 'there is no turtle2'),
])
def test_whether_a_turtle_follows(leader, track, share, seen):
    result = Follows('turtle2').judge(Observed(track=leader, turtles={'turtle2': track}))
    assert (result.share, result.seen) == (share, seen)


def sensed(*values, what='ahead'):
    """Return the Observed of a value [m] each second."""
    return Observed(sensed=[Sensed(float(t), what, value) for t, value in enumerate(values)])


@pytest.mark.parametrize('values, share, said', [
    ((1.4, 1.4, 0.55, 0.45, 0.5, 0.5), 1.0, 'the distance ahead by 0.45 to 0.55 m; 100% of the time within'),
    ((0.5, 0.5, 0.5, 0.5, 0.7, 0.8), 0.5, '0.50 to 0.80 m; 50%'),
    ((0.5, 0.5, 0.5, math.nan, math.nan, math.nan), 0.25, '0.50 to 0.50 m; 25%'),
    ((math.nan,) * 6, 0.0, 'unknown, as it is too near'),
    ((), 0.0, 'the program subscribes to no sensor'),
])
def test_keeps(values, share, said):
    result = Keeps('ahead', 0.5, tolerance=0.1, last=3.0).judge(sensed(*values))
    assert result.share == share and said in result.seen


@pytest.mark.parametrize('speeds, share', [
    ((0.4, 0.2, 0.1, 0.0), 1.0), ((0.4, -0.2, 0.1, -0.0005, 0.0005), 1.0),  # below 1 mm/s it stands
    ((0.4, -0.2, 0.1, -0.05, 0.02), 0.0)])
def test_keeps_without_swinging(speeds, share):
    observed = sensed(0.5, 0.5, 0.5)
    observed.commands = [Command(float(t), speed, 0.0, 0.0) for t, speed in enumerate(speeds)]
    assert Keeps('ahead', 0.5, swings=2.0).judge(observed).share == share


@pytest.mark.parametrize('what, share', [('marker left', 1.0), ('marker ahead', 0.0)])
def test_keeps_a_marker_at_its_place(what, share):
    assert Keeps('marker left', 0.0).judge(sensed(0.02, -0.02, what=what)).share == share


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
    result = Steers('linear.x', 'pitch').judge(turned(velocity))
    assert said in result.seen and (result.share >= FULL if right else result.share < 0.5), result


def test_steers_without_a_marker():
    assert Steers('angular.z', 'roll').judge(Observed()).seen == 'the program subscribes to no marker'
