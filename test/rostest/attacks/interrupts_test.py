#!/usr/bin/env python3
"""Ctrl-C, at random moments, in rospy programs of the course's texts: all of them end.

Several run at once and load the machine, so a program is likely to be interrupted inside publish or loginfo. There,
rospy without the repair of rospy_support (TURTLE_ROBOTONT_REPAIR_ROSPY=0) waits for a lock that it holds itself.
"""
import contextlib
import os
import random
import signal
import subprocess
import tempfile
import time
import unittest

from attacked_nodes import running
from rostest_support import course_texts
from rostest_support.common import DEADLINE, Process, run, until

COUNT = int(os.environ.get('COUNT', '60'))
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


class InterruptsTest(unittest.TestCase):

    def test_programs_end_at_every_moment(self):
        sources = [BUSY, *(course_texts.endless().values() if course_texts.FOLDER.is_dir() else ())]
        numbers, hung = random.Random(1), []
        with contextlib.ExitStack() as stack:
            running(stack, ('turtlesim',))
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            for number, source in enumerate(sources):
                with open(os.path.join(folder, f'{number}.py'), 'w', encoding='utf-8') as file:
                    file.write(source)
            for first in range(0, COUNT, TOGETHER):
                files = [os.path.join(folder, f'{number % len(sources)}.py')
                         for number in range(first, min(first + TOGETHER, COUNT))]
                hung += interrupted(files, [numbers.uniform(0.0, MAX_RUN) for _ in files])
        self.assertFalse(hung, f'{len(hung)} of {COUNT} still run {END_TIMEOUT:g} s after Ctrl-C:\n' + '\n'.join(hung))


def interrupted(files, pauses):
    """Run programs, interrupt each after its pause [s]; return the output of those that do not end."""
    with contextlib.ExitStack() as stack:
        programs = [stack.enter_context(Process('python3', file, f'__name:=program{number}'))
                    for number, file in enumerate(files)]
        for program in programs:
            until(lambda program=program: catches_signals(program), lambda program=program: program.output(), DEADLINE)
        begun = time.monotonic()
        for pause, program in sorted(zip(pauses, programs), key=lambda pair: pair[0]):
            time.sleep(max(0.0, begun + pause - time.monotonic()))
            program.process.send_signal(signal.SIGINT)
        end = time.monotonic() + END_TIMEOUT
        return [program.output() for program in programs if not ends(program, end)]


def catches_signals(program):
    """Return whether a program catches SIGTERM, as rospy does from init_node on."""
    with open(f'/proc/{program.process.pid}/status', encoding='ascii', errors='replace') as file:
        caught = next(line for line in file if line.startswith('SigCgt'))
    return int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1


def ends(program, end):
    """Return whether a program has ended at ``end`` [s, monotonic]; kill it otherwise."""
    try:
        program.process.wait(max(0.0, end - time.monotonic()))
        return True
    except subprocess.TimeoutExpired:
        program.process.kill()
        return False


if __name__ == '__main__':
    run(InterruptsTest)
