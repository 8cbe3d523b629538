"""turtlesim.core.recording: replay reads the values of a recorder, bit for bit."""
import csv
import errno
import os

import pytest
import rospy

from kinematic_core.timing import recorder
from kinematic_core.worlds.turtle_world import ARENA_SIZE, BACKGROUND, random_start
from turtlesim.core import replay
from turtlesim.core.recording import TURTLE
from turtlesim.shared_world import SharedWorld

RED = (255, 0, 0)


class Request:
    """A message or a service request as rospy hands it out."""

    def __init__(self, caller):
        self._connection_header = {'callerid': caller}


class Recorded:
    """A SharedWorld that records; each method is one call of the node's."""

    def __init__(self, path, background=BACKGROUND, **world):
        self.path = str(path)
        self.shared = SharedWorld(background, **world)
        self.shared.record(self.path)

    def do(self, event, *values, turtle=TURTLE, caller='/student'):
        """Change the world and note it, as TurtleInterface and TurtlesimNode do."""
        method = {'cmd': 'command', 'pen': 'set_pen'}.get(event, event)
        with self.shared.change() as world:
            if event == 'spawn':
                world.spawn(*values, turtle)
            elif event in ('clear', 'reset'):
                (self.shared.drawn.canvas.fill if event == 'clear' else self.shared.drawn.reset)(values or BACKGROUND)
            else:
                getattr(world, method)(turtle, *values)
            self.shared.note(event, *values, turtle=turtle, request=Request(caller))

    def ticks(self, number):
        for _ in range(number):
            self.shared.step()

    def rows(self):
        with recorder.open_growing(self.path) as file:
            return list(csv.DictReader(file))

    def assert_replays(self):
        self.shared.end_recording()
        result = replay.replay(self.path)
        assert (result.different_poses, result.different_colours) == (0, [])
        assert result.ticks == len(self.rows())


def drive(recorded):
    """Do a little of everything."""
    recorded.do('pen', *RED, 5, 0)
    recorded.do('cmd', 1.0, 0.1, 0.3)
    recorded.ticks(20)
    recorded.do('teleport_absolute', 0.1 + 0.2, 5.0, 1.0)
    recorded.do('teleport_relative', 1.0 / 3.0, -1.0)
    recorded.do('cmd', 2.0, 0.0, -3.0)
    recorded.ticks(80)  # the watchdog strikes in between


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'run.csv'


def test_everything_replays(path):
    recorded = Recorded(path)
    drive(recorded)
    recorded.do('clear')
    recorded.ticks(3)
    recorded.do('reset', 1, 2, 3)
    drive(recorded)
    recorded.assert_replays()
    assert ','.join(recorded.rows()[0]) == 'tick,event,x,y,theta,linear_velocity,angular_velocity,r,g,b,callers'


@pytest.mark.parametrize('world', [{'start': (3.0, 4.0, 0.7)}, {'background': RED}, {'start': random_start(5)}])
def test_a_run_that_began_otherwise_replays(path, world):
    recorded = Recorded(path, **world)
    drive(recorded)
    recorded.do('reset', *world.get('background', ()))
    drive(recorded)
    recorded.assert_replays()


def test_other_turtles_draw_on_the_same_canvas(path):
    recorded = Recorded(path)
    recorded.do('spawn', 5.0, ARENA_SIZE / 2.0, 0.0, turtle='turtle2')
    recorded.do('pen', *RED, 9, 0, turtle='turtle2')
    recorded.do('cmd', 1.0, 0.0, 0.0, turtle='turtle2')
    recorded.ticks(40)
    recorded.do('kill', turtle='turtle2')
    recorded.ticks(1)
    assert recorded.rows()[-1]['r'] == '255'  # turtle1 stands on turtle2's line
    recorded.assert_replays()


def test_there_are_no_poses_while_there_is_no_turtle1(path):
    recorded = Recorded(path)
    recorded.ticks(2)
    recorded.do('kill', caller='/cheat')
    recorded.ticks(2)
    recorded.do('spawn', 1.0, 1.0, 0.0)
    recorded.ticks(2)
    recorded.assert_replays()
    assert [row['x'] != '' for row in recorded.rows()] == [True, True, False, False, True, True]
    assert recorded.rows()[2]['event'] == 'kill'


def test_callers_stand_beside_their_events(path):
    recorded = Recorded(path)
    recorded.do('pen', 0, 0, 0, 3, 0, caller='/one')
    recorded.do('teleport_absolute', 1.0, 1.0, 0.0, caller='/two')
    recorded.ticks(1)
    (row,) = recorded.rows()
    assert (row['event'], row['callers']) == ('pen 0 0 0 3 0;teleport_absolute 1.0 1.0 0.0', '/one;/two')


def test_of_a_flood_of_commands_the_last_is_kept(path):
    recorded = Recorded(path)
    for speed in range(1000):
        recorded.do('cmd', float(speed), 0.0, 0.0)
    recorded.ticks(1)
    assert recorded.rows()[0]['event'] == 'cmd 999.0 0.0 0.0'
    recorded.assert_replays()


def test_the_same_calls_give_the_same_bytes(tmp_path):
    for name in 'ab':
        recorded = Recorded(tmp_path / name, start=random_start(3))
        drive(recorded)
        recorded.shared.end_recording()
    assert (tmp_path / 'a').read_bytes() == (tmp_path / 'b').read_bytes()


def test_rows_can_be_read_while_the_simulator_runs(path):
    recorded = Recorded(path)
    recorded.ticks(3)
    assert [row['tick'] for row in recorded.rows()] == ['0', '1', '2']


def test_a_full_disk_ends_the_recording_and_not_the_simulator(path, monkeypatch):
    errors = []
    monkeypatch.setattr(rospy, 'logerr', lambda text, *values: errors.append(text % values))
    recorded = Recorded(path)
    recorded.ticks(1)

    def write(*_):
        raise OSError(errno.ENOSPC, 'No space left on device')
    monkeypatch.setattr(recorder.os, 'write', write)
    recorded.ticks(4)
    assert recorded.shared.world.steps == 5
    assert len(errors) == 1 and 'No space left' in errors[0]
    assert [row['tick'] for row in recorded.rows()] == ['0'] and os.path.exists(path)
