"""kinematic_core.worlds.turtle_world against an integrator without any shortcut, in every bit of every double.

The reference below follows the order of one tick as the real turtlesim keeps it, turtle by turtle and step by step,
knows no rest and shares nothing with the world but the constants.
"""
import ctypes
import math
import struct

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinematic_core.worlds.turtle_world import TurtleWorld

pytestmark = pytest.mark.slow

ARENA = ctypes.c_float(499 / 45).value  # [m]
PI = 3.14159265
DT = 0.016  # [s]
NAMES = ('a', 'turtle1', 'turtle2')


def f32(value):
    return ctypes.c_float(value).value


class Reference:
    """One turtle, the plain way."""

    def __init__(self, x, y, theta):
        self.x, self.y, self.theta = f32(x), f32(ARENA - f32(y)), f32(theta)
        self.v = (0.0, 0.0, 0.0)
        self.since_command = None  # [steps]
        self.pen = (179, 184, 255), 3
        self.teleports = []

    def line(self, old):
        return (self.x, self.y, *old, *self.pen)

    def step(self):
        teleport_lines, motion_line, wall = [], None, None
        for kind, values in self.teleports:
            old = self.x, self.y
            if kind == 'teleport_absolute':
                self.x, self.y, self.theta = f32(values[0]), max(0.0, ARENA - f32(values[1])), f32(values[2])
            else:
                self.theta += f32(values[1])
                self.x += math.cos(self.theta) * f32(values[0])
                self.y += -math.sin(self.theta) * f32(values[0])
            if self.pen:
                teleport_lines.append(self.line(old))
        self.teleports = []
        if self.since_command is not None and self.since_command * DT > 1.0:
            self.v = (0.0, 0.0, 0.0)
        if self.since_command is not None:
            self.since_command += 1
        vx, vy, w = self.v
        old = self.x, self.y
        self.theta += w * DT
        self.theta -= 2 * PI * math.floor((self.theta + PI) / (2 * PI))
        self.x += math.cos(self.theta) * vx * DT - math.sin(self.theta) * vy * DT
        self.y -= math.cos(self.theta) * vy * DT + math.sin(self.theta) * vx * DT
        if self.x < 0 or self.x > ARENA or self.y < 0 or self.y > ARENA:
            wall = (self.x, self.y)
        self.x, self.y = min(max(self.x, 0.0), ARENA), min(max(self.y, 0.0), ARENA)
        if self.pen and old != (self.x, self.y):
            motion_line = self.line(old)
        return teleport_lines, wall, motion_line

    def pose(self):
        return self.x, ARENA - self.y, self.theta, math.sqrt(self.v[0] ** 2 + self.v[1] ** 2), self.v[2]


class ReferenceWorld:
    """The turtles of NAMES, all spawned at the beginning."""

    def __init__(self):
        self.turtles = {'turtle1': Reference(ARENA / 2, ARENA / 2, 0.0), 'a': Reference(0.3, 0.7, 2.0),
                        'turtle2': Reference(11.0, 11.0, -3.0)}

    def do(self, kind, name, values):
        turtle = self.turtles[name]
        if kind == 'command':
            turtle.v, turtle.since_command = values, 0
        elif kind == 'set_pen':
            *colour, width, off = values
            turtle.pen = None if off else (tuple(colour), max(width, 1))
        else:
            turtle.teleports.append((kind, values))

    def step(self):
        return [self.turtles[name].step() for name in sorted(self.turtles)]


def new_pair():
    world = TurtleWorld()
    world.spawn(11.0, 11.0, -3.0, 'turtle2')
    world.spawn(0.3, 0.7, 2.0, 'a')
    return world, ReferenceWorld()


def do_both(pair, action):
    kind, name, values = action
    world, reference = pair
    getattr(world, kind)(name, *values)
    reference.do(kind, name, values)


def assert_equal_step(pair):
    world, reference = pair
    advances, expected = world.step(), reference.step()
    assert [advance.turtle.name for advance in advances] == list(NAMES)
    for advance, (teleport_lines, wall, motion_line) in zip(advances, expected):
        assert list(advance.teleports) == teleport_lines
        assert advance.wall == wall
        assert advance.stroke == motion_line
        assert bits(advance.turtle.pose()) == bits(reference.turtles[advance.turtle.name].pose()), world.steps


def bits(pose):
    return struct.pack('<5d', *pose)


speeds = st.one_of(st.just(0.0), st.just(-0.0), st.floats(-10.0, 10.0), st.floats(-1e3, 1e3))
places = st.one_of(st.floats(0.0, 11.0), st.floats(-20.0, 20.0), st.just(0.0), st.just(-0.0))
angles = st.one_of(st.just(0.0), st.just(-0.0), st.just(math.pi), st.just(-PI), st.floats(-10.0, 10.0))
byte = st.integers(0, 255)
actions = st.one_of(
    st.tuples(st.just('command'), st.sampled_from(NAMES), st.tuples(speeds, speeds, speeds)),
    st.tuples(st.just('teleport_absolute'), st.sampled_from(NAMES), st.tuples(places, places, angles)),
    st.tuples(st.just('teleport_relative'), st.sampled_from(NAMES), st.tuples(places, angles)),
    st.tuples(st.just('set_pen'), st.sampled_from(NAMES), st.tuples(byte, byte, byte, byte, st.booleans())),
)
pauses = st.sampled_from([0, 1, 2, 61, 62, 63, 64, 65, 130])  # [steps]


@settings(max_examples=60)
@given(st.lists(st.tuples(actions, pauses), max_size=12))
def test_any_commands_give_the_reference_in_every_bit(script):
    pair = new_pair()
    assert_equal_step(pair)
    for action, pause in script:
        do_both(pair, action)
        for _ in range(pause):
            assert_equal_step(pair)
    for _ in range(66):
        assert_equal_step(pair)
