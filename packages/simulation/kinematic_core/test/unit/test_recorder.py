"""kinematic_core.timing.recorder: what took effect in which tick, and who asked for it."""
import csv
import os
import resource

import pytest

from kinematic_core.timing import recorder as recorder_module
from kinematic_core.timing.recorder import ACTIVE, Recorder, open_growing


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
    recorder.close()
    assert rows(tmp_path / 'r.csv') == [
        ['tick', 'event', 'x', 'y', 'callers'], ['0', '', '1.5', '2', ''],
        ['1', 'cmd 1.0 0 0.1;pen 1', '1.6', '2', '/a;/b'], ['2', '', '', '', '']]


def test_of_commands_in_a_row_the_last_counts(tmp_path):
    recorder = Recorder(tmp_path / 'r.csv', ())
    for value, name in ((1, 'cmd'), (2, 'cmd'), (3, 'turtle2/cmd'), (4, 'cmd'), (5, 'pen'), (6, 'pen')):
        recorder.note(name, value, caller=f'/{value}')
    recorder.tick(0, ())
    recorder.close()
    assert rows(tmp_path / 'r.csv')[1] == ['0', 'cmd 2;turtle2/cmd 3;cmd 4;pen 5;pen 6', '/2;/3;/4;/5;/6']


def test_a_folder_that_does_not_exist(tmp_path):
    with pytest.raises(OSError):
        Recorder(tmp_path / 'none' / 'r.csv', ())


def test_it_has_its_name_when_it_is_closed_and_can_be_read_before(tmp_path):
    path = tmp_path / 'r.csv'
    assert open_growing(str(path)) is None
    recorder = Recorder(path, ())
    recorder.tick(0, ())
    assert os.listdir(tmp_path) == ['r.csv' + ACTIVE]
    with open_growing(str(path)) as file:
        assert file.read() == 'tick,event,callers\n0,,\n'
        recorder.tick(1, ())
        recorder.close()
        recorder.close()
        assert file.read() == '1,,\n'
    assert os.listdir(tmp_path) == ['r.csv']
    with open_growing(str(path)) as file:
        assert file.read().endswith('1,,\n')


@pytest.mark.parametrize('taken', ['r.csv', 'r.csv' + ACTIVE])
@pytest.mark.parametrize('dangling', [False, True])
def test_what_is_there_stays(tmp_path, taken, dangling):
    if dangling:
        (tmp_path / taken).symlink_to(tmp_path / 'nowhere')
    else:
        (tmp_path / taken).write_text('yesterday')
    for name in ('r_2.csv', 'r_3.csv'):
        recorder = Recorder(tmp_path / 'r.csv', ())
        assert recorder.path == str(tmp_path / name)
        recorder.close()
        assert rows(tmp_path / name) == [['tick', 'event', 'callers']]
    assert dangling or (tmp_path / taken).read_text() == 'yesterday'
    assert sorted(os.listdir(tmp_path)) == sorted([taken, 'r_2.csv', 'r_3.csv'])


def test_a_name_that_is_taken_while_it_grows(tmp_path):
    recorder = Recorder(tmp_path / 'r.csv', ())
    (tmp_path / 'r.csv').write_text('faster')
    recorder.close()
    assert recorder.path == str(tmp_path / 'r_2.csv')
    assert (tmp_path / 'r.csv').read_text() == 'faster' and len(rows(tmp_path / 'r_2.csv')) == 1


def test_a_full_disk_ends_it_with_its_last_whole_row(tmp_path):
    recorder, limits = Recorder(tmp_path / 'r.csv', ('x',)), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(OSError, match='File too large.*r.csv'):
            for number in range(100):
                recorder.tick(number, ('123456',))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert os.listdir(tmp_path) == ['r.csv']
    assert rows(tmp_path / 'r.csv')[1:] == [[str(n), '', '123456', ''] for n in range(number)]
    assert (tmp_path / 'r.csv').read_bytes().endswith(b'\n')


def test_no_room_for_the_first_row_leaves_nothing(tmp_path):
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (3, limits[1]))
    try:
        with pytest.raises(OSError, match='File too large'):
            Recorder(tmp_path / 'r.csv', ())
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert os.listdir(tmp_path) == []


def test_a_device_is_written_to(tmp_path):
    recorder = Recorder('/dev/null', ())
    recorder.tick(0, ())
    recorder.close()
    assert recorder.path == '/dev/null'
    with pytest.raises(OSError, match='No space left.*/dev/full'):
        Recorder('/dev/full', ())
    assert not os.path.exists('/dev/null' + recorder_module.ACTIVE)


def test_a_folder_is_no_recording(tmp_path):
    with pytest.raises(IsADirectoryError):
        Recorder(tmp_path, ())
