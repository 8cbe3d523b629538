"""Base class for tests of lessons: start a program as a student does, and watch the turtle.

They need rospy, rostest, any turtlesim and ar_track_alvar_msgs, and nothing else of this repository.
Threads: rospy appends messages to lists in threads of its own; the tests read these.
"""
import math
import os
import signal
import subprocess
import tempfile
import time
import unittest

import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty
from turtlesim.msg import Color, Pose
from turtlesim.srv import Spawn

import rostest

DEADLINE = 30.0  # [s] for whatever a test waits for, on a loaded machine, too
POLL = 0.02  # [s]
STANDING = 1e-4  # [m/s or rad/s]


class Program:
    """A program of the package, started with rosrun; its output goes to a file."""

    def __init__(self, *command):
        self._output = tempfile.TemporaryFile('w+')
        environment = {**os.environ, 'PYTHONUNBUFFERED': '1'}  # rospy does not flush what it prints into a file
        self._process = subprocess.Popen(['rosrun', 'turtle_robotont', *command], stdout=self._output,
                                         stderr=subprocess.STDOUT, env=environment)
        self.ended = lambda: self._process.poll() is not None

    def output(self):
        """Return its output."""
        self._output.seek(0)
        return self._output.read()

    def ctrl_c(self):
        """Press Ctrl-C."""
        self._process.send_signal(signal.SIGINT)

    def end(self):
        """End it, however it is."""
        self._process.kill()
        self._process.wait()
        self._output.close()

    @property
    def code(self):
        """Return its exit code, None while it runs."""
        return self._process.poll()


class LessonCase(unittest.TestCase):
    """A test with a turtle in the middle of an empty arena, whose poses and commands are recorded."""

    turtle = True

    def setUp(self):
        """Reset the simulator."""
        if not self.turtle:
            self.commands = self.record('cmd_vel', Twist)
            return
        rospy.wait_for_service('reset', DEADLINE)
        rospy.ServiceProxy('reset', Empty)()
        # after the reset, because the original then makes the turtle anew, with its topics
        self.commands = self.record('turtle1/cmd_vel', Twist)
        self.poses, self.colours = self.record('turtle1/pose', Pose), self.record('turtle1/color_sensor', Color)
        self.until(lambda: self.poses and abs(self.poses[-1].x - 5.544445) < 1e-3, 'a turtle in the middle')

    def record(self, topic, message_type):
        """Return a list that grows by each message of a topic."""
        messages = []
        subscriber = rospy.Subscriber(topic, message_type, messages.append, tcp_nodelay=True)
        self.addCleanup(subscriber.unregister)
        return messages

    def start(self, *command):
        """Start a program of the package; return the Program."""
        program = Program(*command)
        self.addCleanup(program.end)
        return program

    def until(self, condition, what):
        """Wait until ``condition()`` is true; fail after DEADLINE."""
        end = time.monotonic() + DEADLINE
        while not condition():
            self.assertLess(time.monotonic(), end, f'waited {DEADLINE:g} s for {what() if callable(what) else what}')
            time.sleep(POLL)

    def until_printed(self, program, text):
        """Wait until a program has printed a text."""
        self.until(lambda: text in program.output(), lambda: f'{text!r} in {program.output()!r}')

    def until_ended(self, program, code=0):
        """Wait until a program ends by itself with an exit code."""
        self.until(program.ended, lambda: f'the end of the program, which printed {program.output()!r}')
        self.assertEqual(code, program.code, program.output())

    def spawn(self, name):
        """Make a turtle of that name at (3, 3)."""
        rospy.ServiceProxy('spawn', Spawn)(3.0, 3.0, 0.0, name)

    def until_the_turtle_stands(self):
        """Wait until ten poses after each other have no velocity."""
        self.until(lambda: len(self.poses) > 10 and all(
            abs(pose.linear_velocity) < STANDING and abs(pose.angular_velocity) < STANDING
            for pose in self.poses[-10:]), 'a turtle that stands')

    def nearest(self, x, y):
        """Return the distance [m] at which the turtle has passed a position."""
        return min(math.hypot(pose.x - x, pose.y - y) for pose in self.poses)

    def largest_step(self):
        """Return the largest distance [m] between two poses after each other: a teleport, or 0.016 s of driving."""
        poses = list(self.poses)
        return max(math.hypot(b.x - a.x, b.y - a.y) for a, b in zip(poses, poses[1:]))


def run(case):
    """Run the tests of a class, as rostest wants it."""
    rospy.init_node(case.__name__.lower(), anonymous=True)
    rostest.rosrun('turtle_robotont', case.__name__.lower(), case)
