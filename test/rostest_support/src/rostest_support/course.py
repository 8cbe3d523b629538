"""Helpers for rostests of the course's nodes: starting and ending nodes, calls in the background, tracks.

A track is a list of turtlesim/Pose in the order of time. It is judged here by its own values, without the functions of
the package under test.
"""
import contextlib
import math
import subprocess
import threading

import roslib.packages
import rospy
from geometry_msgs.msg import Twist

from rostest_support.common import DEADLINE, DT, PACKAGE, Collected, Process, SimulatorCase, until

POSITION_TOLERANCE = 0.05  # [m] of a corner or a goal that was driven to
HEADING_TOLERANCE = 0.05  # [rad] of a heading that was turned to
STOP_TOLERANCE = 0.02  # [m] of stopping at x
SPEED_TOLERANCE = 0.01  # [m/s] of a track's steps, which are rounded to float32
BRAKING = 30  # [poses] 0.48 s in which a turtle stops after a command; without one, it would take 62
STOP = Twist()


class CourseCase(SimulatorCase):
    """A test with the course's nodes."""

    @contextlib.contextmanager
    def subTest(self, *message, **values):
        """Do the same as unittest, but end the test at the first failure, as rosunit's report leaves out subtests."""
        try:
            yield
        except AssertionError as error:
            raise AssertionError(f'{message or values}: {error}') from error

    def start(self, script, *arguments, **environment):
        """Start one of the course's nodes as a Process that ends with the test."""
        process = Process(roslib.packages.find_node(PACKAGE, script)[0], *arguments, **environment)
        self.addCleanup(process.stop)
        return process

    def ended(self, process, code=0, deadline=DEADLINE):
        """Wait until a Process ends by itself, with this exit code (None: any) and no traceback; return its output."""
        try:
            ended_with = process.process.wait(deadline)
        except subprocess.TimeoutExpired:
            self.fail(f'not ended within {deadline:g} s: {process.process.args}\n{process.output()}')
        self.assertIn(code, (ended_with, None), process.output())
        self.assertNotIn('Traceback', process.output())
        return process.output()

    def commands(self, turtle='turtle1'):
        """Return the Collected velocities that are sent to a turtle."""
        collected = Collected(f'{self.space}{turtle}/cmd_vel', Twist)
        self.addCleanup(collected.subscriber.unregister)
        return collected

    def assert_stands(self, poses):
        """Assert that the turtle has come to rest and stays there for 20 poses."""
        poses.next(stands, 'a turtle that stands')
        last = poses.more(20)
        self.assertTrue(all(stands(pose) and pose == last[0] for pose in last), last)

    def assert_at(self, pose, x, y, theta=None, tolerance=POSITION_TOLERANCE):
        """Assert that a pose is at a position and, unless None, has a heading."""
        self.assertLess(math.hypot(pose.x - x, pose.y - y), tolerance, pose)
        if theta is not None:
            self.assertLess(abs(wrapped(pose.theta - theta)), HEADING_TOLERANCE, pose)

    def assert_driven(self, track, speed):
        """Assert that no step of a track is longer than one at ``speed`` [m/s]: it was driven, not teleported."""
        fastest = max(math.hypot(b.x - a.x, b.y - a.y) for a, b in zip(track, track[1:])) / DT
        self.assertLess(fastest, speed + SPEED_TOLERANCE)

    def assert_passes(self, track, corners):
        """Assert that a track passes corners (x, y) one after the other and ends in the last one."""
        rest = track
        for corner in corners:
            misses = [math.hypot(pose.x - corner[0], pose.y - corner[1]) for pose in rest]
            near = [number for number, miss in enumerate(misses) if miss < POSITION_TOLERANCE]
            self.assertTrue(near, f'{corner} missed by {min(misses):.3f} m')
            rest = rest[near[0]:]
        self.assert_at(track[-1], *corners[-1])

    def assert_stopped_by(self, poses, commands, ended):
        """Assert that a node's last command stopped the turtle, long before the simulator's watchdog would.

        ``ended`` is the number of poses there were when the node ended.
        """
        until(lambda: commands.messages[-1:] == [STOP], lambda: f'a last Twist of zeros, not {commands.messages[-1:]}')
        rest = poses.index(stands, 'a turtle that stands', start=ended)
        self.assertLess(rest - ended, BRAKING, 'it stopped only when the simulator did that')


class BackgroundCall(threading.Thread):
    """A service call in a thread; when it has ended, ``answer`` is set, or ``error``, the text of its failure."""

    def __init__(self, name, service, *values):
        super().__init__(daemon=True)
        self._proxy, self._values = rospy.ServiceProxy(name, service), values
        self.answer, self.error = None, ''
        self.start()

    def run(self):
        try:
            self.answer = self._proxy(*self._values)
        except rospy.ServiceException as error:
            self.error = str(error)

    def ended(self, deadline=DEADLINE):
        """Wait until the call is answered or has failed; return the answer, None if it failed."""
        until(lambda: not self.is_alive(), f'an answer of {self._proxy.resolved_name}', deadline)
        return self.answer


def stands(pose):
    """Return whether a pose is that of a turtle at rest."""
    return pose.linear_velocity == 0.0 and pose.angular_velocity == 0.0


def wrapped(angle):
    """Return an angle [rad] wrapped to [-pi, pi]."""
    return math.atan2(math.sin(angle), math.cos(angle))


def off_side(pose, a, b):
    """Return the distance [m] of a pose from the line from a to b, both (x, y)."""
    length = math.hypot(b[0] - a[0], b[1] - a[1])
    along = ((pose.x - a[0]) * (b[0] - a[0]) + (pose.y - a[1]) * (b[1] - a[1])) / length
    along = min(length, max(0.0, along)) / length
    return math.hypot(pose.x - a[0] - along * (b[0] - a[0]), pose.y - a[1] - along * (b[1] - a[1]))
