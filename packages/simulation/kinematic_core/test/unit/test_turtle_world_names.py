"""kinematic_core.worlds.turtle_world: spawn, kill, reset, numbering; and every refusal changes nothing."""
import math

import pytest

from kinematic_core.worlds.turtle_world import (
    ARENA_SIZE,
    PEN_COLOUR,
    PEN_WIDTH,
    NameTaken,
    Turtle,
    TurtleWorld,
    UnknownTurtle,
    float32,
)
from plain_support import ABSURD, InvalidInput

CENTRE = ARENA_SIZE / 2.0
TOO_MUCH = 1.001 * ABSURD
BAD_NUMBERS = [math.nan, math.inf, -math.inf, TOO_MUCH, -TOO_MUCH]


def names(world):
    return [advance.turtle.name for advance in world.step()]


def spawn_unnamed(world):
    return world.spawn(1.0, 1.0, 0.0)


def test_unnamed_turtles_are_numbered_from_2():
    world = TurtleWorld()
    assert world.next_name() == 'turtle2'
    assert world.next_name() == 'turtle2'  # asking takes nothing
    assert [spawn_unnamed(world) for _ in range(3)] == ['turtle2', 'turtle3', 'turtle4']


def test_a_number_taken_by_hand_is_skipped():
    world = TurtleWorld()
    assert world.spawn(1.0, 1.0, 0.0, 'turtle2') == 'turtle2'
    assert world.next_name() == 'turtle3'
    assert spawn_unnamed(world) == 'turtle3'
    world.spawn(1.0, 1.0, 0.0, 'turtle5')
    assert [spawn_unnamed(world), spawn_unnamed(world)] == ['turtle4', 'turtle6']


def test_names_given_by_hand_do_not_count():
    world = TurtleWorld()
    assert world.spawn(1.0, 1.0, 0.0, 'leonardo') == 'leonardo'
    assert world.spawn(1.0, 1.0, 0.0, 'turtle7') == 'turtle7'
    assert spawn_unnamed(world) == 'turtle2'


def test_numbers_of_killed_turtles_are_not_used_again():
    world = TurtleWorld()
    spawn_unnamed(world)
    world.kill('turtle2')
    assert spawn_unnamed(world) == 'turtle3'
    world.kill('turtle1')
    assert spawn_unnamed(world) == 'turtle4'


def test_reset_leaves_turtle1_alone_and_restarts_the_numbering():
    world = TurtleWorld()
    spawn_unnamed(world)
    world.spawn(1.0, 1.0, 0.0, 'donatello')
    world.set_pen('turtle1', 1, 2, 3, 4, True)
    world.command('turtle1', 1.0, 1.0, 1.0)
    world.step()
    world.teleport_absolute('turtle1', 1.0, 1.0, 1.0)
    world.reset()
    assert list(world.turtles) == ['turtle1']
    (advance,) = world.step()
    turtle = advance.turtle
    assert turtle.pose() == (CENTRE, CENTRE, 0.0, 0.0, 0.0)
    assert (turtle.pen_on, turtle.pen_colour, turtle.pen_width) == (True, PEN_COLOUR, PEN_WIDTH)
    assert world.steps == 2  # time continues
    assert spawn_unnamed(world) == 'turtle2'


def test_turtle_spawned_outside_is_clamped_in_its_first_step():
    world = TurtleWorld()
    world.spawn(20.0, -1.0, 0.0, 'a')
    advance = world.step()[0]
    assert advance.wall == (20.0, float32(ARENA_SIZE + 1.0))
    assert advance.turtle.pose()[:2] == (ARENA_SIZE, 0.0)


def test_steps_go_through_the_turtles_in_alphabetical_order():
    world = TurtleWorld()
    for name in ('turtle2', 'turtle10', 'b', 'Zoe', 'a/c', 'ab'):
        world.spawn(1.0, 1.0, 0.0, name)
    # as bytes: capitals first, '/' and digits before letters
    expected = ['Zoe', 'a/c', 'ab', 'b', 'turtle1', 'turtle10', 'turtle2']
    assert names(world) == expected
    world.kill('b')
    expected.remove('b')
    assert names(world) == expected


def test_killed_turtle_takes_no_commands_and_comes_back_new():
    world = TurtleWorld()
    world.command('turtle1', 1.0, 0.0, 0.0)
    world.teleport_absolute('turtle1', 1.0, 1.0, 1.0)
    world.kill('turtle1')
    assert names(world) == []
    with pytest.raises(UnknownTurtle):
        world.command('turtle1', 1.0, 0.0, 0.0)
    world.spawn(3.0, 4.0, 0.5, 'turtle1')
    (advance,) = world.step()
    assert advance.turtle.pose()[0] == 3.0
    assert advance.teleports == ()


@pytest.mark.parametrize('name', ['turtle1', 'a'])
def test_taken_name_is_refused_in_turtlesims_words_and_with_what_to_do(name):
    world = TurtleWorld()
    world.spawn(1.0, 1.0, 0.0, 'a')
    with pytest.raises(NameTaken) as refusal:
        world.spawn(1.0, 1.0, 0.0, name)
    assert str(refusal.value).startswith(f'A turtled named [{name}] already exists')
    assert 'choose another name or leave it empty' in str(refusal.value)


def test_unknown_turtle_of_kill_is_refused_in_turtlesims_words_with_the_names_that_exist():
    world = TurtleWorld()
    world.spawn(1.0, 1.0, 0.0, 'a')
    with pytest.raises(UnknownTurtle) as refusal:
        world.kill('nobody')
    assert str(refusal.value) == ('Tried to kill turtle [nobody], which does not exist; '
                                  'the turtles are: a, turtle1')
    world.kill('a')
    world.kill('turtle1')
    with pytest.raises(UnknownTurtle, match='the turtles are: none'):
        world.kill('turtle1')


def with_bad(method, good, fields):
    """Return a case for every bad number in every place of the call ``method('turtle1', *good)``."""
    return [(method, ('turtle1', *good[:place], bad, *good[place + 1:]), InvalidInput,
             rf'^{method_text(method)}: {field} is .*; (it must be a finite number|it must be -1e\+06 to 1e\+06)$')
            for place, field in enumerate(fields) for bad in BAD_NUMBERS]


def method_text(method):
    return f'{"cmd_vel" if method == "command" else method} of turtle1'


def unknown(method, *values):
    return (method, ('nobody', *values), UnknownTurtle, 'of nobody: it does not exist; the turtles are: a, turtle1$')


REFUSED = [
    *with_bad('command', (1.0, 1.0, 1.0), (r'linear\.x', r'linear\.y', r'angular\.z')),
    *with_bad('teleport_absolute', (1.0, 1.0, 1.0), ('x', 'y', 'theta')),
    *with_bad('teleport_relative', (1.0, 1.0), ('linear', 'angular')),
    *[('spawn', (*values[1:], name), error, text.replace(' of turtle1', '')) for name in ('', 'new')
      for _, values, error, text in with_bad('spawn', (1.0, 1.0, 1.0), ('x', 'y', 'theta'))],
    ('spawn', (1.0, 1.0, 1.0, 'turtle1'), NameTaken, 'already exists'),
    ('spawn', (math.nan, 1.0, 1.0, 'turtle1'), InvalidInput, 'spawn: x is nan'),
    ('kill', ('nobody',), UnknownTurtle, 'Tried to kill turtle'),
    ('kill', ('',), UnknownTurtle, 'Tried to kill turtle'),
    unknown('command', 1.0, 1.0, 1.0),
    unknown('teleport_absolute', 1.0, 1.0, 1.0),
    unknown('teleport_relative', 1.0, 1.0),
    unknown('set_pen', 1, 1, 1, 1, False),
    *[('set_pen', ('turtle1', *(bad if place == field else 9 for place in range(4)), off), InvalidInput,
       rf'^set_pen of turtle1: {name} is {bad}; it must be 0 to 255$')
      for field, name in enumerate(('r', 'g', 'b', 'width')) for bad in (-1, 256) for off in (False, True)],
]


@pytest.mark.parametrize('method, values, error, text', REFUSED)
def test_refused_input_changes_nothing(method, values, error, text):
    world, untouched = busy_world(), busy_world()
    with pytest.raises(error, match=text):
        getattr(world, method)(*values)
    assert snapshot(world) == snapshot(untouched)
    for _ in range(70):  # past the watchdog
        assert_equal_step(world, untouched)
    assert snapshot(world) == snapshot(untouched)


def busy_world():
    """A world in which everything is in use: a driving turtle, a resting one, teleports waiting, pens changed."""
    world = TurtleWorld()
    world.spawn(3.0, 4.0, 0.5, 'a')
    world.set_pen('a', 1, 2, 3, 4, True)
    for _ in range(5):
        world.step()
    world.set_pen('turtle1', 5, 6, 7, 8, False)
    world.command('turtle1', 1.0, 0.5, -0.3)
    world.step()
    world.teleport_relative('turtle1', 0.5, 0.5)
    world.teleport_absolute('turtle1', 2.0, 2.0, 0.5)
    return world


def snapshot(world):
    """Return everything that a world is."""
    turtles = {name: [getattr(turtle, slot) for slot in Turtle.__slots__ if slot != '_teleports']
               + [len(turtle._teleports)] for name, turtle in world.turtles.items()}
    return turtles, [turtle.name for turtle in world._order], world.next_name(), world.steps


def assert_equal_step(world, other):
    for advance, expected in zip(world.step(), other.step()):
        assert advance[1:] == expected[1:]
        assert advance.turtle.pose() == expected.turtle.pose()
