"""Bags that the page records: which topics, how much of the disk they may take, and those that were cut off.

Raw images and point clouds are left out unless asked for: a camera of 1280x720 sends more than 100 MB/s. Compressed
images stay: those of turtlesim take 0.1 MB/s, those of a webcam 1 to 3 MB/s.
"""
import contextlib
import glob
import io
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import time
from typing import Collection, Dict, List, Optional, Set, Tuple, Union

import psutil
import rosbag

from plain_support.processes import BackgroundProcess
from rospy_support.master import Master, NoMaster

PREFIX = 'page'  # of the names of the files
LARGEST, SMALLEST = 1000, 10  # [MiB] of one recording
TOGETHER = 5000  # [MiB] of the recordings of a folder
RESERVE = 1024  # [MiB] that stay free on the disk; rosbag record itself writes nothing below
SHARE = 0.5  # of the other free space that one recording may take
LONGEST = 10  # [min]
MIB = 1 << 20
ASK_TIMEOUT = 1.0  # [s] of a request to the master
RAW_TYPES = ('sensor_msgs/Image', 'sensor_msgs/PointCloud', 'sensor_msgs/PointCloud2', 'stereo_msgs/DisparityImage')
RAW_NAMES = r'(.*/)?([^/]*image(_raw|_rect|_mono|_color|_rect_raw|_rect_color)?|[^/]*points2?|[^/]*cloud|' \
            r'disparity|compressedDepth|theora)'  # of topics that appear later, or have no type yet
IDLE = 20.0  # [s] without a written byte, after which a recorder is ended by force
POLL = 0.1  # [s]
AT_REST = 60.0  # [s] since the last change of a file that is taken for one that nobody writes


class Refused(ValueError):
    """What was asked for is not possible; the text says why."""


class CutOff(ValueError):
    """A bag that cannot be indexed; the text says why."""


def limit(folder: str) -> int:
    """Return how large a recording in a folder may become now [MiB]; raise Refused if there is no room."""
    try:
        free = shutil.disk_usage(folder).free / MIB
    except OSError as error:
        raise Refused(f'no bag can be written into {folder}: {error.strerror}') from None
    if not os.access(folder, os.W_OK):
        raise Refused(f'no bag can be written into {folder}: it is write-protected')
    taken = sum(_size(path) for path in glob.glob(os.path.join(glob.escape(folder), f'{PREFIX}_*.bag*'))) / MIB
    if free - RESERVE < SMALLEST / SHARE:
        raise Refused(f'the disk of {folder} has only {free:.0f} MB left, and {RESERVE} MB stay free: delete what is '
                      'not needed there')
    if TOGETHER - taken < SMALLEST:
        raise Refused(f'the recordings {PREFIX}_*.bag in {folder} take {taken:.0f} MB already, and {TOGETHER} MB are '
                      'allowed: delete some of them')
    return int(min(LARGEST, TOGETHER - taken, SHARE * (free - RESERVE)))


def _size(path: Union[str, pathlib.Path]) -> int:
    try:
        return os.path.getsize(path)
    except OSError:  # it has just been renamed
        return 0


def command(largest: int, with_images: bool, raw_topics: Collection[str] = ()) -> Tuple[str, ...]:
    """Return the command that records; ``raw_topics``: those that are known to have images and point clouds."""
    names = '|'.join([RAW_NAMES, *map(re.escape, sorted(raw_topics))])
    return ('rosbag', 'record', '--all', *([] if with_images else [f'--exclude={names}']), f'--size={largest}',
            f'--duration={LONGEST}m', f'--output-prefix={PREFIX}')


def raw_topics() -> List[str]:
    """Return the topics with raw images or point clouds whose names do not tell; raise Refused without a master."""
    try:
        (_, _, types), = Master(ASK_TIMEOUT).request([('getTopicTypes',)])
    except NoMaster:
        raise Refused('there is nothing to record yet: no ROS master answers. Start a simulator first') from None
    return [topic for topic, kind in types if kind in RAW_TYPES and not re.fullmatch(RAW_NAMES, topic)]


def master_id() -> Optional[int]:
    """Return the process number of the master, which another master does not have; None if none answers."""
    try:
        (_, _, number), = Master(ASK_TIMEOUT).request([('getPid',)])
    except NoMaster:
        return None
    return number


def reason_to_end(folder: str, since: float, master: Optional[int]) -> Optional[str]:
    """Return why a recording that began at ``since`` (time.monotonic) with a master has to end; None if it may go on.

    rosbag's own limit counts ROS time, which may stand still.
    """
    if time.monotonic() - since > 60 * LONGEST:
        return f'{LONGEST} minutes are over'
    try:
        if shutil.disk_usage(folder).free < RESERVE * MIB:
            return f'the disk has less than {RESERVE} MB left'
    except OSError as error:
        return f'{folder}: {error.strerror}'
    return 'the ROS master has ended' if master_id() != master else None


def close(process: BackgroundProcess, number: int, idle: float = IDLE) -> None:
    """End a recorder, a BackgroundProcess, by a signal; by force only when it has written nothing for ``idle`` [s]."""
    process.signal(number)
    written, since = -1, time.monotonic()
    while time.monotonic() - since < idle:
        members = process.members()
        if not members:
            break
        now = sum(map(_written, members))
        if now != written:
            written, since = now, time.monotonic()
        time.sleep(POLL)
    process.stop()


def _written(process: psutil.Process) -> int:
    try:
        return process.io_counters().write_chars
    except psutil.Error:
        return 0


def outcome(folder: str, before: Set[str], size: int, why: Optional[str] = None) -> str:
    """Return a text about the recordings that are not in ``before``, a set of names; index those that were cut off.

    ``size``: the limit [MiB]; ``why``: the reason for the end, if it did not end by itself or by its user.
    """
    sentences = [f'The recording has ended: {why}.'] if why else []
    for path in sorted(pathlib.Path(folder).glob(f'{PREFIX}_*.bag*')):
        if _name(path) in before:
            continue
        if path.suffix == '.bag':
            if not why and _size(path) > size * MIB:
                sentences.append(f'The recording has ended: it has reached {size} MB.')
            sentences.append(f'Saved as {path.name}, {_size(path) / MIB:.1f} MB.')
        elif path in cut_off(folder):
            sentences.append(f'The recording was cut off. {_indexed_apart(path)}')
    return ' '.join(sentences) or 'Nothing was recorded.'


def names(folder: str) -> Set[str]:
    """Return the names of the recordings of the page in a folder, closed or not."""
    return set(map(_name, pathlib.Path(folder).glob(f'{PREFIX}_*.bag*')))


def _name(path: pathlib.Path) -> str:
    return path.name.partition('.bag')[0]


def _indexed_apart(path: pathlib.Path) -> str:
    """Index a recording in a process of its own, which may take long; return what it says."""
    done = subprocess.run(['rosrun', 'course_page', 'index_bag', path.name], cwd=path.parent, text=True, check=False,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return (done.stdout.strip().splitlines() or [f'{path.name} cannot be indexed.'])[-1]


def cut_off(folder: str) -> Dict[pathlib.Path, bool]:
    """Return {path of a recording that was not closed, and that no process of this machine has open: at rest}.

    ``at rest``: whether it is also one of the page, of this user, and has not changed for AT_REST.
    """
    at_rest = {}
    for path in sorted(pathlib.Path(folder).glob('*.bag.active')):
        try:
            status = path.stat()
        except OSError:
            continue
        at_rest[path] = (path.name.startswith(f'{PREFIX}_') and status.st_uid == os.getuid()
                         and time.time() - status.st_mtime > AT_REST)
    opened = _open_files() if at_rest else set()
    return {path: rests for path, rests in at_rest.items() if str(path.resolve()) not in opened}


def _open_files() -> Set[str]:
    paths = set()
    for link in glob.glob('/proc/[0-9]*/fd/*'):
        try:
            paths.add(os.readlink(link))
        except OSError:
            continue
    return paths


def index(path: str) -> Tuple[str, int]:
    """Write the index of a recording that was cut off, as rosbag reindex does, but without a copy; name it .bag.

    Return the new path and the number of messages; raise CutOff or OSError.
    """
    if not os.path.isfile(path) or not str(path).endswith('.bag.active'):
        raise CutOff(f'{path} is not a file that ends with .bag.active')
    new = os.path.splitext(path)[0]
    if os.path.exists(new):
        raise CutOff(f'{new} exists already: rename one of the two files')
    try:
        count = _read(path, 'r')  # what cannot be read stays as it is
        if count:
            _read(path, 'a')
    except (rosbag.ROSBagException, ValueError, KeyError, struct.error) as error:
        raise CutOff(f'{path} is not a bag that can be read ({error}): delete it') from None
    if not count:
        raise CutOff(f'{path} holds no complete message: the recording was cut off too early. Delete it')
    os.rename(path, new)
    return new, count


def _read(path: str, mode: str) -> int:
    """Read a bag without an index; return the number of messages. Mode 'a' also writes the index."""
    with rosbag.Bag(path, mode, allow_unindexed=True) as bag:
        with contextlib.suppress(io.UnsupportedOperation):  # the end of the file, which is torn, would be cut off
            for _ in bag.reindex():
                pass
        return bag.get_message_count()


def main() -> None:
    """Index the recordings that are named on the command line."""
    if len(sys.argv) < 2 or sys.argv[1].startswith('-'):
        sys.exit('usage: rosrun course_page index_bag FILE.bag.active ...')
    for path in sys.argv[1:]:
        try:
            new, count = index(path)
        except OSError as error:
            sys.exit(f'{path} cannot be indexed: {error.strerror or error}. The file stays as it is.')
        except CutOff as error:
            sys.exit(f'{error}.')
        print(f'{path} was indexed: {count} messages. It is now {new}.')
