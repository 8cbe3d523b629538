"""kinematic_core.recorder: what took effect in which tick, and who asked for it."""
import csv

import pytest

from kinematic_core.recorder import Recorder


def rows(path):
    with open(path, newline='', encoding='utf-8') as file:
        return list(csv.reader(file))


def test_events_stand_in_the_row_of_the_next_tick(tmp_path):
    recorder = Recorder(tmp_path / 'r.csv', ('x', 'y'))
    recorder.tick(0, (1.5, 2))
    recorder.note('cmd', 1.0, 0, 0.1, caller='/a')
    recorder.note('pen', 1, caller='/b')
    recorder.tick(1, (1.6, 2))
    recorder.tick(2, ('', ''))
    assert rows(tmp_path / 'r.csv') == [
        ['tick', 'event', 'x', 'y', 'callers'], ['0', '', '1.5', '2', ''],
        ['1', 'cmd 1.0 0 0.1;pen 1', '1.6', '2', '/a;/b'], ['2', '', '', '', '']]  # read while it is written
    recorder.close()


def test_of_commands_in_a_row_the_last_counts(tmp_path):
    recorder = Recorder(tmp_path / 'r.csv', ())
    for value, name in ((1, 'cmd'), (2, 'cmd'), (3, 'turtle2/cmd'), (4, 'cmd'), (5, 'pen'), (6, 'pen')):
        recorder.note(name, value, caller=f'/{value}')
    recorder.tick(0, ())
    assert rows(tmp_path / 'r.csv')[1] == ['0', 'cmd 2;turtle2/cmd 3;cmd 4;pen 5;pen 6', '/2;/3;/4;/5;/6']


def test_a_folder_that_does_not_exist(tmp_path):
    with pytest.raises(OSError):
        Recorder(tmp_path / 'none' / 'r.csv', ())
