"""TurtleWorld in any order of calls: a refused call changes nothing, the others leave the turtles of a model."""
import math

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from kinematic_core.worlds.turtle_world import ARENA_SIZE, TurtleWorld
from plain_support import InvalidInput

NAMES = st.sampled_from(['turtle1', 'turtle2', 'turtle3', 'anna', 'bert'])
NUMBERS = st.floats(-1e6, 1e6, width=32)
ABSURD = st.sampled_from([math.nan, math.inf, -math.inf, 1.7e7, -3.4e38])
GOOD = st.tuples(NUMBERS, NUMBERS, NUMBERS)
BAD = st.tuples(ABSURD, NUMBERS, NUMBERS) | st.tuples(NUMBERS, ABSURD, NUMBERS) | st.tuples(NUMBERS, NUMBERS, ABSURD)
BAD_PENS = st.tuples(st.sampled_from([-1, 256]), st.integers(0, 255), st.integers(0, 255)).flatmap(st.permutations)


class Machine(RuleBasedStateMachine):
    """Legal calls go to two worlds; the second one never hears of those that are refused."""

    def __init__(self):
        super().__init__()
        self.worlds = TurtleWorld(), TurtleWorld()
        self.names = {'turtle1'}

    def both(self, method, *values):
        return [getattr(world, method)(*values) for world in self.worlds][0]

    def refused(self, method, *values):
        with pytest.raises(InvalidInput):
            getattr(self.worlds[0], method)(*values)

    @rule(place=GOOD, name=NAMES | st.just(''))
    def spawn(self, place, name):
        if name in self.names:
            self.refused('spawn', *place, name)
        else:
            made = self.both('spawn', *place, name)
            assert made not in self.names and made == (name or made)
            self.names.add(made)

    @rule(place=BAD, name=NAMES | st.just(''))
    def spawn_nowhere(self, place, name):
        self.refused('spawn', *place, name)

    @rule(name=NAMES)
    def kill(self, name):
        if name in self.names:
            self.both('kill', name)
            self.names.remove(name)
        else:
            self.refused('kill', name)

    @rule(method=st.sampled_from(['teleport_absolute', 'command']), name=NAMES, values=GOOD)
    def move(self, method, name, values):
        (self.both if name in self.names else self.refused)(method, name, *values)

    @rule(method=st.sampled_from(['teleport_absolute', 'command']), name=NAMES, values=BAD)
    def move_absurdly(self, method, name, values):
        self.refused(method, name, *values)

    @rule(name=NAMES, values=st.tuples(NUMBERS, ABSURD).flatmap(st.permutations))
    def teleport_absurdly(self, name, values):
        self.refused('teleport_relative', name, *values)

    @rule(name=NAMES, colour=BAD_PENS)
    def draw_absurdly(self, name, colour):
        self.refused('set_pen', name, *colour, 3, 0)

    @rule()
    def reset(self):
        self.both('reset')
        self.names = {'turtle1'}

    @rule(steps=st.integers(1, 70))
    def step(self, steps):
        for _ in range(steps):
            self.both('step')
        for turtle in self.worlds[0].turtles.values():
            assert 0.0 <= turtle.x <= ARENA_SIZE and 0.0 <= turtle.y_down <= ARENA_SIZE

    @invariant()
    def worlds_are_equal(self):
        seen, unseen = ({name: (turtle.pose(), turtle.pen_on, turtle.pen_colour, turtle.pen_width)
                         for name, turtle in world.turtles.items()} for world in self.worlds)
        assert seen == unseen and set(seen) == self.names


TestMachine = Machine.TestCase
TestMachine.settings = settings(max_examples=60, stateful_step_count=30, derandomize=True, deadline=None, database=None)
