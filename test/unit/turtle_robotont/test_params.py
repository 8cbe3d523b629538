"""turtle_robotont.params: the values that each kind of parameter accepts, and the errors for others."""
import math
import sys

import pytest
import rospy

from kinematic_core.worlds import turtle_world
from turtle_robotont import params
from turtle_robotont.driving import shapes
from turtle_robotont.params import list_of, number, one_of, point, ros_name, true_or_false, whole


@pytest.mark.parametrize('allowed, right, wrong', [
    (number(), [0, -1.5, 1e9], [math.nan, math.inf, True, '1', None, [1]]),
    (number(0.1, 2.0, 'm'), [0.1, 1, 2.0], [0.0, 2.1, math.nan]),
    (whole(0, 255), [0, 7, 255], [-1, 256, 1.5, 7.0, True, '7']),
    (whole(0), [0, 10 ** 6], [-1]),
    (one_of('a', 'b'), ['a', 'b'], ['c', '', 1, ['a']]),
    (true_or_false(), [True, False], [0, 1, 'true', None]),
    (ros_name('turtle1'), ['turtle1', 'sim2/turtle1', '/turtle1'], ['a b', '', '9a', '~x', 7]),
    (point(0.0, 2.0), [[0, 2.0]], [[0], [0, 1, 2], [0, 2.1], 'ab', 1]),
    (list_of(whole(0), '[1]'), [[1], [1, 2]], [[], [1, -1], 1, '12']),
    (list_of(whole(0), '[1]', 3, 3), [[1, 2, 3]], [[1, 2], [1, 2, 3, 4]]),
])
def test_what_is_allowed(allowed, right, wrong):
    assert [value for value in right if not allowed.accepts(value)] == []
    assert [value for value in wrong if allowed.accepts(value)] == []


@pytest.mark.parametrize('allowed, text', [
    (number(unit='m/s'), 'a number in m/s'), (number(0.1, 1000.0, 'Hz'), 'a number from 0.1 to 1000 Hz'),
    (whole(0, 255, 'px'), 'a whole number from 0 to 255 px'), (whole(0), 'a whole number from 0'),
    (one_of('drive', 'log'), 'one of drive, log'), (true_or_false(), 'true or false'),
    (list_of(whole(0, 255), '[0, 0, 0]', 3, 3), 'a list of 3 entries, each a whole number from 0 to 255'),
    (list_of(whole(1), '[1]'), 'a list of at least 1 entry, each a whole number from 1'),
])
def test_texts(allowed, text):
    assert allowed.text == text


class Node:
    """Runs check_params as a node named /node does; ``said`` are its messages."""

    def __init__(self, monkeypatch):
        self.said, self.hooks, self._monkeypatch = [], [], monkeypatch
        monkeypatch.setattr(rospy, 'get_name', lambda: '/node')
        monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', '/node/'))
        monkeypatch.setattr(rospy, 'on_shutdown', self.hooks.append)
        for level in ('logfatal', 'logwarn'):
            monkeypatch.setattr(rospy, level, lambda text, *values: self.said.append(text % values))

    def check(self, *arguments, stored=None, **allowed):
        """Return the exit code, or None if the program continues."""
        self._monkeypatch.setattr(sys, 'argv', ['node.py', *arguments])
        self._monkeypatch.setattr(rospy, 'get_param', lambda name, default: stored or default)
        try:
            params.check_params(**allowed)
        except SystemExit as end:
            return end.code
        return None


@pytest.fixture
def node(monkeypatch):
    return Node(monkeypatch)


@pytest.mark.parametrize('arguments, stored, said', [
    (['_speed:=3'], {'speed': 3}, None),
    (['turtle1/cmd_vel:=other/cmd_vel', '__name:=node', '__log:=/a/b.log'], {}, None),
    (['_speed:=fast'], {'speed': 'fast'}, "parameter /node/speed is 'fast'; it must be a number from 1 to 5 m/s. "
                                          'Type for example _speed:=5'),
    (['_sped:=3'], {'sped': 3}, 'parameter /node/sped: this program has no such parameter. Did you mean _speed:=3?'),
    (['_zzz:=3'], {'zzz': 3}, 'parameter /node/zzz: this program has no such parameter. It has speed.'),
    (['speed:=3'], {}, 'argument speed:=3: this program has no such parameter. Did you mean _speed:=3?'),
    (['sped:=3'], {}, 'argument sped:=3: this program has no such parameter. Did you mean _speed:=3?'),
    (['speed=3'], {}, 'argument speed=3: this program has no such parameter. Did you mean _speed:=3?'),
    (['--speed=3'], {}, 'argument --speed=3: this program has no such parameter. Did you mean _speed:=3?'),
    (['3'], {}, 'argument 3: this program has no such parameter. It has speed.'),
])
def test_command_lines(node, arguments, stored, said):
    assert node.check(*arguments, stored=stored, speed=number(1.0, 5.0, 'm/s')) == (said and 2)
    assert node.said == ([said] if said else [])


def test_all_that_is_wrong_is_said_at_once(node):
    stored = {'speed': 9, 'size': 9}
    assert node.check('_speed:=9', '_size:=9', stored=stored, speed=number(1.0, 5.0), size=number(1.0, 5.0)) == 2
    assert len(node.said) == 2


def test_parameters_of_an_earlier_run_are_told(node):
    assert node.check('_speed:=2', stored={'speed': 2, 'size': 3}, speed=number(), size=number()) is None
    assert node.said == ['/node has parameters from an earlier run: size=3; '
                         'rosparam delete /node forgets them']


def test_those_of_a_launch_file_are_not(node):
    assert node.check('__log:=/a/b.log', stored={'size': 3}, size=number()) is None
    assert node.said == []


def test_the_arena_is_that_of_the_simulator():
    assert shapes.ARENA_SIZE == float(turtle_world.ARENA_SIZE)
    assert number(0.0, shapes.ARENA_SIZE, 'm').text == 'a number from 0 to 11.0889 m'
