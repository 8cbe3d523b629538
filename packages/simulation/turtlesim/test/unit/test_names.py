"""turtlesim.names: which names a turtle may have. Names resolve as in a node /sim/turtlesim without a master."""
import pytest
import rospy

from plain_support import InvalidInput
from turtlesim import names

NODE = '/sim/turtlesim'
REMAPPED = {'/sim/secret': '/sim/clear'}  # as with secret:=clear on the command line


class FakeRospy:
    @staticmethod
    def get_name():
        return NODE

    @staticmethod
    def resolve_name(name):
        resolved = rospy.resolve_name(name, NODE)
        return REMAPPED.get(resolved, resolved)


@pytest.fixture(autouse=True)
def node(monkeypatch):
    monkeypatch.setattr(names, 'rospy', FakeRospy)


@pytest.mark.parametrize('name', [
    'turtle2', 't', 'T', 'Turtle_2', 'a_', 'a1', 'a/b', 'a/b/c_3', 'a/1', 'a/_b', '/leonardo', '/a/b',
    'clear/me', 'spawn2', 'Clear', 'turtlesim/x', '/clear', '/spawn', '/turtlesim', '/other/turtlesim',
    'a' * names.MAX_LENGTH,
])
def test_legal_names_pass(name):
    assert names.TurtleNames(['turtle1', 'a2']).check(name) is None


@pytest.mark.parametrize('name', [
    '', ' ', 'a b', 'a ', ' a', 'a\n', '\na', 'a\tb', '1a', '9', '_a', '-a', 'a-b', 'a.b', 'a~', '~a', '~', '/', '//a',
    'a//b', 'a/', '/a/', 'a/ /b', '/1a', '/_a', 'ä', 'aä', 'schildkröte', 'a\u0663', '龟', 'a\x00', 'a"b', "a'b", 'a$',
    '{a}', 'a:=b', '%s', 'ａ', '/~a', 'a/~b',
])
def test_names_that_ros_forbids_are_refused_with_the_name_and_what_is_allowed(name):
    with pytest.raises(InvalidInput) as refusal:
        names.TurtleNames(['turtle1']).check(name)
    text = str(refusal.value)
    assert text.startswith(f'spawn: the name {name!r} is not allowed; ')
    assert 'starts with a letter' in text and 'single / between its parts' in text


@pytest.mark.parametrize('name', ['a' * 201, 'a/' * 500 + 'a'])
def test_names_without_end_are_refused_by_their_length_without_repeating_them(name):
    with pytest.raises(InvalidInput, match=f'^spawn: the name has {len(name)} characters; at most 200 are allowed$'):
        names.TurtleNames([]).check(name)


def test_a_long_name_that_is_illegal_as_well_is_cut_short_in_the_text():
    with pytest.raises(InvalidInput) as refusal:
        names.TurtleNames([]).check('ä' * 100_000)
    assert len(str(refusal.value)) < 500


@pytest.mark.parametrize('name, resolved', [
    ('clear', '/sim/clear'), ('kill', '/sim/kill'), ('reset', '/sim/reset'), ('spawn', '/sim/spawn'),
    ('/sim/spawn', '/sim/spawn'), ('turtlesim', NODE), (NODE, NODE), ('secret', '/sim/clear'),
])
def test_names_of_the_simulator_itself_are_refused(name, resolved):
    with pytest.raises(InvalidInput) as refusal:
        names.TurtleNames(['turtle1']).check(name)
    assert str(refusal.value) == (f'spawn: the name {name!r} belongs to the simulator itself ({resolved}); '
                                  'choose another')


@pytest.mark.parametrize('name, other', [('/sim/leo', 'leo'), ('leo', '/sim/leo'), ('/sim/a/b', 'a/b')])
def test_another_spelling_of_a_turtles_name_is_refused(name, other):
    with pytest.raises(InvalidInput) as refusal:
        names.TurtleNames(['turtle1', other]).check(name)
    text = str(refusal.value)
    assert repr(name) in text and repr(other) in text and rospy.resolve_name(name, NODE) in text


@pytest.mark.parametrize('name, other', [('leo', 'leo2'), ('leo', '/leo'), ('leo', 'Leo'), ('leo', 'leo')])
def test_names_that_mean_something_else_do_not_clash_and_the_same_one_is_the_worlds_business(name, other):
    assert names.TurtleNames(['turtle1', other]).check(name) is None
