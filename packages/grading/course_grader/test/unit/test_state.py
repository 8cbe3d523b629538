"""course_grader.attempt.state: parameters and transforms are read as ROS has them."""
import math
import types

import pytest
import rosgraph
import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from course_grader.attempt import guard, state
from course_grader.rules import exercise
from course_grader.rules.observation import Observed, Transform
from rospy_support.rospy_internals.topics import HOLDER

NO_LINK = types.SimpleNamespace(watch=lambda *_: pytest.fail('watched'),  # no turtle is asked for
                                follow=lambda: None)
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
