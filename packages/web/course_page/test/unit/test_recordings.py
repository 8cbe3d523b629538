"""course_page.recordings: which topics are recorded, the limits of the disk, and what becomes of recordings cut off."""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import genpy
import pytest
import rosbag
from std_msgs.msg import String

from course_page import recordings
from course_page.recordings import MIB, Refused
from plain_support.processes import BackgroundProcess
from rostest_support.waiting import until


def disk(monkeypatch, free):
    """Let every disk have so much free space [MiB]."""
    monkeypatch.setattr(shutil, 'disk_usage', lambda folder: SimpleNamespace(free=free * MIB))


def sparse(path, size):
    """Make a file of ``size`` [MiB] that takes no space."""
    with open(path, 'wb') as file:
        file.truncate(size * MIB)


def cut(path, messages=3, keep=None):
    """Write a bag as a recorder leaves it that is killed: without an index; ``keep`` [bytes] of it."""
    whole = path.with_suffix('.whole')
    with rosbag.Bag(str(whole), 'w', chunk_threshold=1) as bag:  # each message in a chunk of its own
        for number in range(messages):
            bag.write('/said', String(data=f'message {number}'), genpy.Time(10 + number))
        bag.flush()
        bag._file.flush()
        shutil.copy(str(whole), str(path))
    os.unlink(str(whole))
    with open(str(path), 'r+b') as file:
        file.truncate(keep or os.path.getsize(str(path)))
    return path


def texts(path):
    with rosbag.Bag(str(path)) as bag:
        return [message.data for _, message, _ in bag.read_messages()]


@pytest.mark.parametrize('topic, raw', [
    ('/camera/color/image_raw', True), ('/camera/depth/points', True), ('/camera/depth/image_rect_raw', True),
    ('/camera/aligned_depth_to_color/image_raw', True), ('/turtlesim/image_raw', True), ('/usb_cam/image_mono', True),
    ('/ar_track_alvar/explained_image', True), ('/image', True), ('/a/compressedDepth', True), ('/image/theora', True),
    ('/turtlesim/image_raw/compressed', False), ('/camera/color/camera_info', False), ('/odom', False),
    ('/scan', False), ('/move_base/NavfnROS/plan', False), ('/robotont_gazebo/world', False),
    ('/waypoints_reached', False)])
def test_the_names_of_raw_topics(topic, raw):
    exclude = next(one for one in recordings.command(100, False) if one.startswith('--exclude='))
    assert bool(re.fullmatch(exclude.partition('=')[2], topic)) == raw


def test_a_topic_with_images_whose_name_does_not_tell_is_left_out_unless_images_are_asked_for():
    exclude = next(one for one in recordings.command(100, False, ['/my+eye']) if one.startswith('--exclude='))
    assert re.fullmatch(exclude.partition('=')[2], '/my+eye')
    assert not [one for one in recordings.command(100, True, ()) if one.startswith('--exclude')]


@pytest.mark.parametrize('free, there, expected', [
    (79_000, 0, 1000), (79_000, 4_500, 500),
    (1_424, 0, 200),  # half of 400 MiB
    (1_040, 0, 'has only 1040 MB left, and 1024 MB stay free'), (0, 0, 'has only 0 MB left'),
    (79_000, 5_000, 'take 5000 MB already, and 5000 MB are allowed')])
def test_no_number_of_recordings_fills_the_disk(tmp_path, monkeypatch, free, there, expected):
    disk(monkeypatch, free)
    sparse(tmp_path / 'page_1.bag', there // 2)
    sparse(tmp_path / 'page_2.bag.active', there - there // 2)
    sparse(tmp_path / 'mine.bag', 9_000)  # not made by the page
    if isinstance(expected, int):
        assert recordings.limit(str(tmp_path)) == expected
    else:
        with pytest.raises(Refused, match=expected):
            recordings.limit(str(tmp_path))


def test_a_folder_that_has_gone_is_told(tmp_path):
    with pytest.raises(Refused, match='no bag can be written into .*gone: No such file'):
        recordings.limit(str(tmp_path / 'gone'))


@pytest.mark.parametrize('age, free, master, expected', [
    (0, 9_000, 7, None), (601, 9_000, 7, '10 minutes are over'), (0, 1_000, 7, 'the disk has less than 1024 MB left'),
    (0, 9_000, None, 'the ROS master has ended'), (0, 9_000, 8, 'the ROS master has ended')])
def test_a_recording_ends_at_its_limits_or_with_the_master(monkeypatch, age, free, master, expected):
    disk(monkeypatch, free)
    monkeypatch.setattr(recordings, 'master_id', lambda: master)
    assert recordings.reason_to_end('.', time.monotonic() - age, 7) == expected


WRITES = '''
import signal, sys, time
signal.signal(signal.SIGINT, lambda *_: None)
print('runs', flush=True)
signal.pause()
for number in range(10):
    with open(sys.argv[1], 'a') as file:
        file.write('x')
    time.sleep(0.1)
if sys.argv[2] == 'hangs':
    time.sleep(60)
'''


@pytest.mark.parametrize('then', ['ends', 'hangs'])
def test_a_recorder_is_ended_by_force_only_when_it_no_longer_writes(tmp_path, then):
    process = BackgroundProcess([sys.executable, '-c', WRITES, str(tmp_path / 'bag'), then], str(tmp_path / 'log'))
    until(lambda: 'runs' in process.output())
    recordings.close(process, signal.SIGINT, idle=0.5)  # s; it writes for one
    assert (tmp_path / 'bag').read_text() == 'x' * 10
    assert not process.members()


def test_what_was_cut_off_is_indexed_and_keeps_its_messages(tmp_path):
    path = cut(tmp_path / 'page_1.bag.active')
    with pytest.raises(rosbag.ROSBagUnindexedException):
        texts(path)
    new, count = recordings.index(str(path))
    assert (new, count) == (str(tmp_path / 'page_1.bag'), 3) and not path.exists()
    assert texts(new) == ['message 0', 'message 1', 'message 2']


def test_the_last_message_that_is_torn_is_left_out(tmp_path):
    path = cut(tmp_path / 'page_1.bag.active')
    with open(str(path), 'r+b') as file:
        file.truncate(path.stat().st_size - 100)
    assert texts(recordings.index(str(path))[0]) == ['message 0', 'message 1']


@pytest.mark.parametrize('content, expected', [
    (b'', 'empty file'), (b'\x98\x00' * 999, 'is not a bag'), (b'#ROSBAG V2.0\n', 'is not a bag'),
    (b'#ROSBAG V2.0\n' + b'\xff' * 99, 'is not a bag'), (b'#ROSBAG V9.0\n' + b'\x00' * 99, 'is not a bag'),
    (None, 'exists already')])
def test_what_cannot_be_indexed_stays_and_is_told(tmp_path, content, expected):
    path = tmp_path / 'page_1.bag.active'
    if content is None:
        cut(path)
        (tmp_path / 'page_1.bag').write_text('kept')
    else:
        path.write_bytes(content)
    before = path.read_bytes()
    with pytest.raises(recordings.CutOff, match=expected):
        recordings.index(str(path))
    assert path.read_bytes() == before
    assert not (tmp_path / 'page_1.bag').exists() or (tmp_path / 'page_1.bag').read_text() == 'kept'


def test_a_recording_without_a_whole_message_is_told(tmp_path):
    path = cut(tmp_path / 'page_1.bag.active', keep=4150)  # the file's header takes 4109 bytes
    with pytest.raises(recordings.CutOff, match='holds no complete message'):
        recordings.index(str(path))
    assert path.stat().st_size == 4150


def test_a_recording_that_is_written_is_left_alone(tmp_path):
    path = cut(tmp_path / 'page_1.bag.active')
    os.utime(str(path), (1, 1))
    assert recordings.cut_off(str(tmp_path)) == {path: True}
    with open(str(path), 'ab'):
        assert recordings.cut_off(str(tmp_path)) == {}
    other = cut(tmp_path / 'mine.bag.active')
    os.utime(str(other), (1, 1))
    assert recordings.cut_off(str(tmp_path)) == {path: True, other: False}
    path.touch()
    assert recordings.cut_off(str(tmp_path))[path] is False


def test_the_outcome_tells_what_there_is(tmp_path, monkeypatch):
    monkeypatch.setattr(recordings, '_indexed_apart', lambda path: f'{path.name} is indexed')
    before = recordings.names(str(tmp_path))
    assert recordings.outcome(str(tmp_path), before, 1) == 'Nothing was recorded.'
    sparse(tmp_path / 'page_1.bag', 2)
    assert recordings.outcome(str(tmp_path), before, 1) == (
        'The recording has ended: it has reached 1 MB. Saved as page_1.bag, 2.0 MB.')
    before = recordings.names(str(tmp_path))
    cut(tmp_path / 'page_2.bag.active')
    assert recordings.outcome(str(tmp_path), before, 1, 'the ROS master has ended') == (
        'The recording has ended: the ROS master has ended. The recording was cut off. page_2.bag.active is indexed')


def test_the_program_tells_in_one_line(tmp_path):
    script = pathlib.Path(recordings.__file__).resolve().parents[2] / 'scripts' / 'index_bag'
    cut(tmp_path / 'a.bag.active')
    done = subprocess.run([sys.executable, str(script), 'a.bag.active'], cwd=str(tmp_path), text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.stdout == 'a.bag.active was indexed: 3 messages. It is now a.bag.\n' and not done.returncode
    done = subprocess.run([sys.executable, str(script), 'none.bag.active'], cwd=str(tmp_path), text=True, check=False,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.stdout == 'none.bag.active is not a file that ends with .bag.active.\n' and done.returncode == 1
