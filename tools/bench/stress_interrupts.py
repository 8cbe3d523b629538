"""Ctrl-C, at random moments, in rospy programs of the course's texts: which of them do not end?

Many of them run at once and load the machine, so a program is likely to be interrupted inside publish or loginfo.
There, rospy without the repair of rospy_support waits for a lock that it holds itself.
"""
import os
import signal
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack

from figures import Figure, Target, median
from rostest_support import course_texts
from session import find_node
from trial import running, until

OFF = {'TURTLE_ROBOTONT_REPAIR_ROSPY': '0'}
TOGETHER = 12  # programs that run at once
MAX_RUN = 2.0  # [s] from the moment at which rospy catches signals to Ctrl-C
END_TIMEOUT = 15.0  # [s] after Ctrl-C; a program that still runs then never ends
BUSY = '''import rospy
from geometry_msgs.msg import Twist

rospy.init_node('busy')
pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
while not rospy.is_shutdown():
    pub.publish(Twist())
    rospy.loginfo('published')
'''


def repaired(subject, scale, rng):
    """Programs as they run in a workspace."""
    return {f'repaired_{key}': values for key, values in _interrupted(subject, scale.count(1000, 24), rng).items()}


def original(subject, scale, rng):
    """The same programs with the original rospy."""
    return {f'original_{key}': values
            for key, values in _interrupted(subject, scale.count(300, TOGETHER), rng, **OFF).items()}


def _interrupted(subject, count, rng, **environment):
    """Interrupt this many programs; return {key: samples}."""
    files = _written({**(course_texts.endless() if course_texts.FOLDER.is_dir() else {}), 'busy': BUSY},
                     subject.folder)
    found = {'hung': [], 'time': [], 'failed': []}
    with running(subject, 'turtlesim'), subject.other(find_node('rosout', 'rosout')):
        for first in range(0, count, TOGETHER):
            with ExitStack() as stack:
                programs = [stack.enter_context(subject.start(
                    'program', ['python3', files[number % len(files)], f'__name:=program{number}'], **environment))
                    for number in range(first, min(first + TOGETHER, count))]
                for program in programs:
                    until(lambda program=program: _catches_signals(program), f'{program.name} calls init_node')
                with ThreadPoolExecutor(TOGETHER) as threads:
                    pauses = [rng.uniform(0.0, MAX_RUN) for _ in programs]
                    for program, seconds in zip(programs, threads.map(_ended, programs, pauses)):
                        found['hung'].append(int(seconds is None))
                        found['failed'].append(int('Traceback' in program.output()))
                        found['time'].append(END_TIMEOUT if seconds is None else seconds)
    return found


def _written(sources, folder):
    files = []
    for name, source in sources.items():
        files.append(os.path.join(folder, f'{name}.py'))
        with open(files[-1], 'w', encoding='utf-8') as file:
            file.write(source)
    return files


def _catches_signals(program):
    """Return whether a program catches SIGTERM, as rospy does from init_node on."""
    with open(f'/proc/{program.pid}/status', encoding='ascii', errors='replace') as file:
        caught = next(line for line in file if line.startswith('SigCgt'))
    return int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1


def _ended(program, pause):
    """Interrupt a program after a pause [s]; return the time to its end [s], or None, and kill it."""
    time.sleep(pause)
    program.process.send_signal(signal.SIGINT)
    begun = time.monotonic()
    try:
        program.process.wait(END_TIMEOUT)
    except subprocess.TimeoutExpired:
        program.process.kill()
        return None
    return time.monotonic() - begun


ATTACKS = {
    'repaired': (repaired, "Ctrl-C in the course texts' programs"),
    'original': (original, 'the same with rospy as it is'),
}
FIGURES = (
    Figure('Ctrl-C', 'repaired_hung', '', len),
    Figure(f'programs not ended after {END_TIMEOUT:g} s', 'repaired_hung', '', sum, Target('at_most', 0)),
    Figure('programs that ended with a traceback', 'repaired_failed', '', sum),
    Figure('time to the end, median', 'repaired_time', 's', median),
    Figure('time to the end, longest', 'repaired_time', 's', max, Target('below', END_TIMEOUT)),
    Figure('rospy as it is: Ctrl-C', 'original_hung', '', len),
    Figure(f'rospy as it is: programs not ended after {END_TIMEOUT:g} s', 'original_hung', '', sum),
    Figure('rospy as it is: programs that ended with a traceback', 'original_failed', '', sum),
    Figure('rospy as it is: time to the end, median', 'original_time', 's', median),
)
