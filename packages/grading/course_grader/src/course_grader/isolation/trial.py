"""Tries what programs need of this machine, as the user that they run as: what it lacks is no fault of theirs.

A program's own words decide nothing, because it may say anything: they only say what is tried. What its user cannot
import, or get a little of, in a program of the grader either, is the machine's; what works there is the program's
mistake.
"""
import importlib.util
import re
import shlex
import sys
from typing import Iterable, List, Optional, Sequence, Tuple

from course_grader.isolation import view
from course_grader.isolation.limits import MEGABYTE, Limits

FIRST = 'rospy', 'geometry_msgs', 'std_msgs', 'std_srvs', 'turtlesim'  # what nearly each program imports
MODULES = (*FIRST, 'actionlib', 'actionlib_msgs', 'actionlib_tutorials', 'ar_track_alvar_msgs', 'cv2', 'cv_bridge',
           'dynamic_reconfigure', 'message_filters', 'move_base_msgs', 'nav_msgs', 'numpy', 'robotont_msgs', 'rosbag',
           'rosgraph', 'roslib', 'sensor_msgs', 'tf', 'tf2_geometry_msgs', 'tf2_msgs', 'tf2_ros', 'visualization_msgs',
           'yaml')  # of ROS, of the workspace and of its environment: a program may count on them
INTERFACES = 'msg', 'srv'
MISSING = re.compile(r"(?:No module named|cannot import name '\w+' from) '(\w+)")
SCARCE = re.compile(r"can't start new thread|Too many open files|Cannot allocate memory|MemoryError|No space left on "
                    r'device|Resource temporarily unavailable|unable to fork|Disk quota exceeded')
STACK = 8  # [MB] of a thread
SHARE = 8  # of each limit of a program, of which one part is tried
LITTLE = 32, 64 * MEGABYTE, 2 * MEGABYTE  # the most that is tried: threads and files, memory, and a file [bytes]
PROGRAM = '''
import importlib, os, sys, tempfile, threading
count, memory, size, *modules = sys.argv[1:]
step = ''
try:
    for step in modules:
        importlib.import_module(step)
    step = ''
    if int(count):
        over = threading.Event()
        threads = [threading.Thread(target=over.wait) for _ in range(int(count))]
        try:
            for thread in threads:
                thread.start()
            block = bytearray(int(memory))
            files = [open(os.devnull) for _ in range(int(count))]
            for folder in (os.environ['HOME'], tempfile.gettempdir()):
                with tempfile.TemporaryFile(dir=folder) as file:
                    file.write(bytes(int(size)))
        finally:
            over.set()
except BaseException as error:
    print(f'{"import " + step + ": " if step else ""}{type(error).__name__}: {error}')
    sys.exit(1)
'''


def command(modules: Iterable[str] = (), limits: Optional[Limits] = None) -> List[str]:
    """Return the command that imports modules, and with ``limits`` takes a small part of them; it ends with 0."""
    few = (0, 0, 0) if limits is None else (
        min(LITTLE[0], limits.processes // SHARE, limits.memory // STACK // SHARE),
        min(LITTLE[1], limits.memory * MEGABYTE // SHARE),
        min(LITTLE[2], min(limits.file_size, limits.disk) * MEGABYTE // SHARE))
    return [sys.executable, '-c', PROGRAM, *map(str, few), *modules]


def first_modules() -> List[str]:
    """Return the modules to import before the first program runs."""
    return _with_interfaces(FIRST)


def suspected(said: str) -> Tuple[List[str], bool]:
    """Return the modules to import, and whether to take some of the limits, after a program has failed with a text."""
    roots = [root for root in dict.fromkeys(MISSING.findall(said)) if root in MODULES]
    return _with_interfaces(roots), bool(SCARCE.search(said))


def _with_interfaces(roots: Iterable[str]) -> List[str]:
    """Return modules, and those of their messages and services, as far as the grader itself finds these."""
    found = []
    for root in roots:
        known = importlib.util.find_spec(root)
        found += [root, *(f'{root}.{kind}' for kind in INTERFACES
                          if known and importlib.util.find_spec(f'{root}.{kind}'))]
    return found


def cause(said: str, user: Optional[int], shown: Sequence[Tuple[str, str]]) -> str:
    """Return the text about a machine on which the command() failed and printed ``said``.

    ``user``: the user id of programs, if they have their own; ``shown``: what they see, see view.shown().
    """
    who = 'programs' if user is None else f'programs, which run as the user {user},'
    places = [source for source, _ in shown if not view.below(source, view.SYSTEM)]
    closed = '' if user is None else next(filter(None, map(view.unreadable, places)), '')
    text = f'this machine is the cause, and not the program: {who} fail here by themselves: {said or "no output"}'
    if closed:
        top = next(place for place in places if view.below(closed, [place]))
        return f'{text}. {closed} cannot be read by others; type: chmod -R go+rX {shlex.quote(top)}'
    above = '' if user is None else next((place for place in places if not view.reachable(place, deep=False)), '')
    if above:
        return f'{text}. Others cannot enter a folder above {above}: choose another workspace with TURTLE_ROBOTONT_WS'
    return f'{text}. ./run doctor looks for the reason'
