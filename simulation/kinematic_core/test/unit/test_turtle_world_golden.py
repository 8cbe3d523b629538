"""kinematic_core.worlds.turtle_world against recordings of the real turtlesim: every pose, bit for bit as float32."""
import csv
import pathlib
import struct

import pytest

from kinematic_core.worlds.turtle_world import TurtleWorld

GOLDEN = pathlib.Path(__file__).resolve().parents[4] / 'test' / 'data' / 'golden'
RECORDINGS = sorted(GOLDEN.glob('*.csv'))
POSE_FIELDS = ('x', 'y', 'theta', 'linear_velocity', 'angular_velocity')
TURTLE = 'turtle1'


def test_all_recordings_are_there():
    assert {path.stem for path in RECORDINGS} >= {'arc', 'holonomic', 'pens', 'spin_wraps', 'square_teleport',
                                                  'straight', 'teleports', 'walls'}


@pytest.mark.parametrize('path', RECORDINGS, ids=lambda path: path.stem)
def test_every_pose_is_equal_in_every_bit_with_the_built_in_watchdog(path):
    world = TurtleWorld()
    ticks = 0
    with open(path, newline='', encoding='utf-8') as file:
        for row in csv.DictReader(file):
            assert int(row['tick']) == world.steps, 'the recording has no gaps'
            for event in filter(None, row['event'].split(';')):
                apply(world, *event.split())
            (advance,) = world.step()
            recorded = tuple(float(row[field]) for field in POSE_FIELDS)
            assert float32_bits(advance.turtle.pose()) == float32_bits(recorded), f'tick {row["tick"]}'
            ticks += 1
    assert ticks > 60  # one watchdog time at least


def apply(world, kind, *values):
    numbers = [float(value) for value in values]
    if kind == 'cmd':
        world.command(TURTLE, *numbers)
    elif kind == 'pen':
        world.set_pen(TURTLE, *map(int, numbers))
    elif kind in ('teleport_absolute', 'teleport_relative'):
        getattr(world, kind)(TURTLE, *numbers)
    else:  # the watchdog strikes by itself, the canvas is not the world's
        assert kind in ('timeout', 'clear')


def float32_bits(pose):
    return struct.pack('<5f', *pose)
