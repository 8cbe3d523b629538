"""turtlesim.core.replay: which events take effect when: the watchdog, and pens and clears booked one tick early.

The recordings are made here, with a DrawnWorld, so that what really happened in which tick is known.
"""
import pytest

from kinematic_core.worlds.turtle_world import BACKGROUND, float32
from turtlesim.core import replay
from turtlesim.core.drawn_world import DrawnWorld
from unit_support.recordings import COLUMNS, read, write

T = 'turtle1'
# circles of 1 m/s / 3 rad/s = 0.33 m, one in 131 ticks; steps of 0.72 px stay on the line's own cap of 1.5 px
DRIVE = {0: 'cmd 1 0 3', 50: 'cmd 1 0 3', 100: 'cmd 1 0 3'}


def record(path, ticks, effects, booked=None):
    """Write the recording of a DrawnWorld: ``effects`` {tick: event} happen, ``booked`` are those in the file."""
    drawn, rows = DrawnWorld(), []
    actions = {'cmd': drawn.world.command, 'pen': drawn.world.set_pen}
    for tick in range(ticks):
        for event in filter(None, effects.get(tick, '').split(';')):
            kind, *values = event.split()
            if kind == 'clear':
                drawn.canvas.fill(BACKGROUND)
            else:
                actions[kind](T, *(float(value) if kind == 'cmd' else int(value) for value in values))
        ((turtle, colour, _),) = drawn.step()
        event = (effects if booked is None else booked).get(tick, '')
        rows.append(dict(zip(COLUMNS, (tick, event, *(f'{float32(value):.9g}' for value in turtle.pose()), *colour))))
    write(path, rows)
    return drawn


def test_watchdog_is_the_recordings_where_it_says_so_and_else_the_built_in_one(tmp_path):
    path = tmp_path / 'watchdog.csv'
    record(path, 80, {0: 'cmd 1 0 0'})
    assert replay.replay(str(path)).different_poses == 0
    rows = read(path)
    rows[63]['event'] = 'timeout'  # 63 steps: where it strikes anyway
    write(path, rows)
    assert replay.replay(str(path)).different_poses == 0
    rows[63]['event'], rows[60]['event'] = '', 'timeout'
    write(path, rows)
    result = replay.replay(str(path))
    assert result.different_poses == 20  # ticks 60 to 79: from where it stops on it is elsewhere
    assert result.first_difference.startswith('tick 60: ')
    rows[60]['event'], rows[70]['event'] = '', 'timeout'
    write(path, rows)
    assert replay.replay(str(path)).first_difference.startswith('tick 63: ')


@pytest.mark.parametrize('event', ['clear', 'pen 255 0 0 3 0', 'pen 0 0 0 3 1;clear'])
def test_a_pen_or_clear_booked_one_tick_early_is_moved_and_said(tmp_path, event, capsys):
    path = tmp_path / 'early.csv'
    record(path, 150, {**DRIVE, 140: event}, booked={**DRIVE, 139: event})
    result = replay.replay(str(path))
    assert (result.different_poses, result.different_colours) == (0, [])
    assert result.moved_events == 1
    assert result.booked_different_colours >= 1
    assert replay.main([str(path)]) == 0
    share = f'{100.0 * (1.0 - result.booked_different_colours / 150.0):.2f} %'
    assert ('100.00 % of the colours equal (with 1 pen or clear events one tick later than recorded; '
            f'{share} as recorded), no picture') in capsys.readouterr().out


def test_moved_event_counts_for_the_picture_too(tmp_path):
    import cv2
    path = tmp_path / 'early.csv'
    drawn = record(path, 145, {**DRIVE, 140: 'clear'}, booked={**DRIVE, 139: 'clear'})
    cv2.imwrite(str(tmp_path / 'early.png'), drawn.canvas.array()[:, :, ::-1])
    assert replay.replay(str(path)).equal_pixels == 1.0


@pytest.mark.parametrize('event', ['clear', 'pen 255 0 0 3 0'])
def test_an_event_booked_rightly_stays(tmp_path, event):
    path = tmp_path / 'right.csv'
    record(path, 150, {**DRIVE, 140: event})
    result = replay.replay(str(path))
    assert (result.different_colours, result.moved_events, result.booked_different_colours) == ([], 0, 0)


def test_an_event_stays_where_moving_it_does_not_help(tmp_path):
    path = tmp_path / 'right.csv'
    record(path, 150, {**DRIVE, 140: 'clear'})
    rows = read(path)
    rows[141]['r'] = '1'
    write(path, rows)
    result = replay.replay(str(path))
    assert (result.different_colours, result.moved_events, result.booked_different_colours) == ([141], 0, 1)


def test_an_event_that_cannot_be_placed_better_elsewhere_stays(tmp_path):
    path = tmp_path / 'resting.csv'
    record(path, 30, {10: 'pen 255 0 0 3 0'})  # a turtle at rest draws nothing
    rows = read(path)
    rows[11]['r'] = '1'
    write(path, rows)
    assert (replay.replay(str(path)).different_colours, replay.replay(str(path)).moved_events) == ([11], 0)


def test_every_event_is_placed_for_itself(tmp_path):
    path = tmp_path / 'both.csv'
    record(path, 150, {**DRIVE, 90: 'clear', 140: 'clear'}, booked={**DRIVE, 90: 'clear', 139: 'clear'})
    rows = read(path)
    rows[91]['r'] = '1'
    write(path, rows)
    result = replay.replay(str(path))
    assert (result.different_colours, result.moved_events) == ([91], 1)


@pytest.mark.parametrize('ticks', [101, 150])
def test_an_event_is_moved_into_a_tick_that_has_its_own_and_into_the_last_one(tmp_path, ticks):
    path = tmp_path / 'early.csv'
    record(path, ticks, {**DRIVE, 100: 'clear;cmd 1 0 3'}, booked={**DRIVE, 99: 'clear'})
    result = replay.replay(str(path))
    assert (result.different_poses, result.different_colours, result.moved_events) == (0, [], 1)


@pytest.mark.parametrize('booked', [137, 142])
def test_an_event_booked_elsewhere_is_a_difference(tmp_path, booked):
    path = tmp_path / 'wrong.csv'
    record(path, 150, {**DRIVE, 140: 'clear'}, booked={**DRIVE, booked: 'clear'})
    assert replay.replay(str(path)).different_colours != []


def test_command_is_never_moved(tmp_path):
    path = tmp_path / 'command.csv'
    start, both = {0: 'cmd 1 0 0'}, 'cmd 1 0 1;pen 255 0 0 3 0'
    record(path, 100, {**start, 20: both}, booked={**start, 19: both})
    assert replay.replay(str(path)).first_difference.startswith('tick 19: ')


def test_the_last_tick_has_nowhere_to_move_an_event_to(tmp_path):
    path = tmp_path / 'last.csv'
    record(path, 41, {0: 'cmd 1 0 0'}, booked={0: 'cmd 1 0 0', 40: 'clear'})
    assert (replay.replay(str(path)).different_colours, replay.replay(str(path)).moved_events) == ([40], 0)
