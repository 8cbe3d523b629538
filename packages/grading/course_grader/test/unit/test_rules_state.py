"""Checks of parameters and transforms: values from ROS, and their verdicts."""
import math
import types

import pytest
import rosgraph
import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from course_grader.attempt import guard, state
from course_grader.rules import exercise, scoring
from course_grader.rules.observation import Command, Event, Goal, Observed, Sample, Transform
from rospy_support.rospy_internals.topics import HOLDER
from unit_support.graded_turtle import GradedTurtle

NO_LINK = types.SimpleNamespace(watch=lambda *_: pytest.fail('watched'),  # no turtle is asked for
                                follow=lambda: None)


def judged(observed, **check):
    """Return the Reason for one check."""
    content = {'title': 'T', 'time': '10 s', 'checks': [{'points': 100, **check}]}
    reason, = scoring.decide(exercise.parse(content), observed).reasons
    return reason


@pytest.mark.parametrize('value, wanted, points', [
    (0.5, 0.5, 100), (1, 1.0, 100), (0.30000000000000004, 0.3, 100), (0.5, 0.6, 0), ('fast', 'fast', 100),
    ('fast', 'slow', 0), (True, True, 100), (True, 1, 0), (1, True, 0), ([1, 2], 1, 0),
])
def test_the_value_of_a_parameter(value, wanted, points):
    reason = judged(Observed(parameters={'/speed': value}), check='parameter', name='/speed', value=wanted)
    assert (reason.points, reason.seen) == (points, f'it is {value!r}')


def test_a_parameter_that_is_set_or_not():
    assert judged(Observed(parameters={'/speed': []}), check='parameter', name='/speed').points == 100
    reason = judged(Observed(parameters={'/other': 1}), check='parameter', name='/speed')
    assert (reason.points, reason.asked, reason.seen) == (0, 'the parameter /speed is set', 'it is not set')


@pytest.mark.parametrize('events, points, seen', [
    ([], 0, '/clear was not called'), ([(255, 255, 0)], 100, 'it is (255, 255, 0)'),
    ([(255, 255, 0), (69, 86, 255)], 0, 'it is (69, 86, 255)'),  # cleared again after other parameters were set
    ([(69, 86, 255), (255, 255, 0)], 100, 'it is (255, 255, 0)')])
def test_the_background(events, points, seen):
    observed = Observed(events=[Event(1.0, 'clear', values) for values in events])
    reason = judged(observed, check='background', colour=[255, 255, 0])
    assert (reason.points, reason.seen) == (points, seen)


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


@pytest.mark.parametrize('observed, check, points', [
    (broadcast(), {}, 100), (broadcast(), {'at': 'the vehicle', 'rate': '8 to 12 Hz'}, 100),
    (broadcast(), {'parent': '/world'}, 100),  # tf knows no /
    (broadcast(off=0.3), {'at': 'the vehicle'}, 0),  # 0.3 m off: at 0.5 m/s it was never there within 0.3 s and 5 cm
    (broadcast(turned=0.3), {'at': 'the vehicle'}, 0), (broadcast(turned=math.tau), {'at': 'the vehicle'}, 100),
    (broadcast(turned=0.3), {}, 100), (broadcast(child='turtle2'), {}, 0),
    (broadcast(parent='turtle1', child='world'), {}, 0),
    (broadcast(rate=1000.0), {'rate': 'at least 20 Hz'}, 100),
    (broadcast(stamped=False), {}, 0),  # tf takes no second transform of the time 0
    (broadcast(stamped=False, seconds=0.0), {}, 100),
    (old(0.1), {}, 100), (old(0.5), {}, 0),  # a stamp that was taken once, at the start
])
def test_transforms(observed, check, points):
    assert judged(observed, **{'check': 'transform', 'parent': 'world', 'child': 'turtle1', **check}).points == points


def test_transforms_that_come_too_rarely_lose_points():
    reason = judged(broadcast(rate=5.0), check='transform', parent='world', child='turtle1', rate='10 Hz')
    assert reason.points == pytest.approx(25, abs=3) and reason.seen.endswith(' Hz')  # half as often
    assert judged(broadcast(seconds=0.0), check='transform', parent='world', child='turtle1', rate='10 Hz').points == 0


def test_other_transforms_are_named():
    reason = judged(broadcast(child='turtle2'), check='transform', parent='world', child='turtle1')
    assert (reason.asked, reason.seen) == ('transforms from world to turtle1', 'only world to turtle2')
    assert judged(Observed(), check='transform', parent='world', child='turtle1').seen == 'none'


CONTENT = {'title': 'T', 'time': '10 s', 'checks': [
    {'check': 'parameter', 'name': '/speed', 'points': 50},
    {'check': 'transform', 'parent': 'world', 'child': 'turtle1', 'points': 50}]}


def test_parameters_and_transforms_are_read(monkeypatch):
    subscribed, server, observed = {}, {'/speed': 0.5}, Observed()

    class Master:
        def __init__(self, _):
            pass

        def getParam(self, name):
            if name not in server:
                raise rosgraph.MasterError('not set')
            return server[name]
    monkeypatch.setattr(rosgraph, 'Master', Master)
    monkeypatch.setattr(rospy, 'get_time', lambda: 105.0)
    monkeypatch.setattr(rospy, 'Subscriber', lambda topic, kind, callback: subscribed.setdefault(topic, callback))
    reader = state.StateReader(exercise.parse(CONTENT), observed, 100.0, NO_LINK, 0.016)
    reader.read()
    server.clear()
    reader.read()  # the program has deleted it
    assert observed.parameters == {'/speed': 0.5} and set(subscribed) == {'/tf', '/tf_static'}
    message = TFMessage([TransformStamped()])
    message.transforms[0].header.frame_id, message.transforms[0].child_frame_id = '/world', 'turtle1'
    message.transforms[0].transform.translation.x = math.pi
    message.transforms[0].transform.rotation.z = message.transforms[0].transform.rotation.w = math.sqrt(0.5)
    for holder in guard.GRADING, guard.PROGRAM:  # whatever both call themselves
        message._connection_header = {'callerid': '/turtlesim', HOLDER: holder}
        for topic in '/tf', '/tf_static':
            subscribed[topic](message)
    assert observed.transforms == [Transform(5.0, 'world', 'turtle1', math.pi, 0.0, pytest.approx(math.pi / 2), lasting)
                                   for lasting in (False, True)]


def test_an_exercise_without_such_checks_subscribes_to_nothing(monkeypatch):
    monkeypatch.setattr(rospy, 'Subscriber', lambda *_: pytest.fail('subscribed'))
    monkeypatch.setattr(rosgraph, 'Master', lambda _: types.SimpleNamespace(getParam=lambda name: pytest.fail(name)))
    content = {**CONTENT, 'checks': [{'check': 'runs', 'points': 100}]}
    state.StateReader(exercise.parse(content), Observed(), 0.0, NO_LINK, 0.016).read()


GOALS = {'do': 'goals', 'action': '/fibonacci'}
DRIVE = {'do': 'drive', 'for': '4 s'}
FIVE = Goal(0.0, '/fibonacci', 5, False, 'SUCCEEDED', 4, (0, 1, 1, 2, 3, 5))  # 4 of 6 numbers are computed
CANCELLED = Goal(9.0, '/fibonacci', 40, True, 'PREEMPTED', 2, (0, 1, 1, 2))


def judged_with(stimulus, observed, **check):
    content = {'title': 'T', 'time': '10 s', 'stimuli': [stimulus], 'checks': [{'points': 100, **check}]}
    reason, = scoring.decide(exercise.parse(content), observed).reasons
    return reason


@pytest.mark.parametrize('goals, points, said', [
    ([FIVE, CANCELLED], 100, '2 of 2 goals'),
    ([FIVE._replace(state='ABORTED'), CANCELLED], 24.5, '1 of 2 goals; the goal of order 5 is ABORTED'),
    ([FIVE._replace(result=(0, 1, 1, 2, 3))], 0, 'order 5 is [0, 1, 1, 2, 3], expected [0, 1, 1, 2, 3, 5]'),
    ([FIVE._replace(feedback=3)], 0, '3 messages of feedback for 4 numbers'),
    ([CANCELLED._replace(state='SUCCEEDED')], 0, 'the cancelled goal is SUCCEEDED, not PREEMPTED'),
    ([FIVE._replace(action='/other')], 0, 'the program never offered it'),
    ([FIVE], 24.5, '1 of 2 goals; the time was over before the last goal'),
])
def test_goals_of_an_action(goals, points, said):
    reason = judged_with(GOALS, Observed(goals=goals), check='reaches', action='/fibonacci')
    assert reason.points == pytest.approx(points) and said in reason.seen


def repeated(turn=0.5, speed=0.5, seconds=4.0):
    """Return the Observed of an arc that the grader drove for 4 s, and one that the program drove after it."""
    turtle = GradedTurtle().drive(4.0, 0.5, 0.5).drive(1.0)
    turtle.observed.commands.clear()  # those were the grader's
    return turtle.drive(seconds, speed, turn).drive(0.5).observed


@pytest.mark.parametrize('observed, passes', [
    (repeated(), True), (repeated(turn=0.25, speed=0.25, seconds=8.0), True),  # the same path, slowly
    (repeated(turn=-0.5), False), (repeated(seconds=3.0), False), (repeated(speed=0.0), False),
])
def test_a_path_that_is_driven_again(observed, passes):
    assert (judged_with(DRIVE, observed, check='repeats').points >= 100) == passes


def test_nothing_is_driven_again():
    idle = Observed(track=[Sample(0.0, 1.0, 1.0, 0.0)])
    assert judged_with(DRIVE, idle, check='repeats').seen == 'it sent no command'
    still = Observed(track=[Sample(0.1 * tick, 1.0, 1.0, 0.0) for tick in range(9)], commands=[Command(0.4, 0, 0, 0)])
    assert judged_with(DRIVE, still, check='repeats').seen == 'it did not move'


@pytest.mark.parametrize('check, said', [
    ({'check': 'repeats'}, 'check 1 (repeats) needs a stimulus {do: drive'),
    ({'check': 'reaches', 'action': '/fibonacci'}, 'check 1 (reaches) needs a stimulus {do: goals, action: /fibonacci'),
])
def test_checks_that_need_a_stimulus(check, said):
    with pytest.raises(exercise.ExerciseError) as error:
        judged(Observed(), **check)
    assert str(error.value).startswith(said)
