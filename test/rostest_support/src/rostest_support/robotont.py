"""Helpers for rostests of the simulated Robotont: its topics and services, and private simulators."""
import ast
import json
import math
import os
import re
import subprocess
import unittest

import roslib.packages
import rospy
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from robotont_gazebo.srv import MoveMarker, SetPose
from std_msgs.msg import String

from rospy_support.rotations import yaw_of
from rostest_support.common import DEADLINE, Collected, Process, proxy, until

SIMULATOR = roslib.packages.find_node('robotont_gazebo', 'robotont_gazebo')[0]
LENGTH_TOLERANCE = 1e-6  # [m, rad]
RADIUS = 0.18  # [m] of the robot
COMMAND_LASTS = 0.5  # [s]


class RobotontCase(unittest.TestCase):
    """A test with a simulated Robotont in the namespace ``space``."""

    space = '/'

    def topic(self, name):
        """Return the full name of a topic or service; ``~`` stands for the simulator's node."""
        return self.space + name.replace('~', 'robotont_gazebo/')

    def collected(self, name, kind, wait=True):
        """Return the Collected messages of a topic, of which there is one already unless not to ``wait``."""
        collected = Collected(self.topic(name), kind)
        self.addCleanup(collected.subscriber.unregister)
        if wait:
            until(lambda: collected.messages, f'a first message on {collected.topic}')
        return collected

    def message(self, name, kind):
        """Return a message published after this was called; of a latched topic the last one."""
        return rospy.wait_for_message(self.topic(name), kind, DEADLINE)

    def truth(self):
        """Return the true pose of the robot: (x, y, yaw) [m, m, rad]."""
        return place(self.message('~ground_truth', Odometry))

    def odometry(self):
        """Return the pose in the robot's odometry: (x, y, yaw) [m, m, rad]."""
        return place(self.message('odom', Odometry))

    def driver(self):
        """Return a function (x, y, turn) that publishes a Twist to the simulator."""
        publisher = rospy.Publisher(self.topic('cmd_vel'), Twist, queue_size=10, tcp_nodelay=True)
        self.addCleanup(publisher.unregister)
        until(lambda: publisher.get_num_connections(), f'a subscriber of {publisher.name}')
        return lambda x=0.0, y=0.0, turn=0.0: publisher.publish(Vector3(x, y, 0.0), Vector3(0.0, 0.0, turn))

    def drive_until(self, condition, what, *command):
        """Command again and again until ``condition()`` is true."""
        drive = self.driver()

        def driven():
            drive(*command)
            return condition()
        until(driven, what)

    def drive_once(self, *command):
        """Give one command and wait until the watchdog has stopped the robot; return its pose."""
        truth = self.collected('~ground_truth', Odometry)
        start = len(truth.messages)
        self.driver()(*command)
        moving = truth.index(lambda message: not stands(message), 'a robot that moves', start)
        truth.index(stands, 'a robot that stands', moving)
        return place(truth.messages[-1])

    def set_pose(self, x, y, yaw):
        """Call ~set_pose."""
        return proxy(self.topic('~set_pose'), SetPose)(x, y, yaw)

    def move_marker(self, name, x, y, yaw):
        """Call ~move_marker."""
        return proxy(self.topic('~move_marker'), MoveMarker)(name, x, y, yaw)

    def refused(self, call, *values):
        """Call something that must fail; return the text of the failure."""
        with self.assertRaises(rospy.ServiceException, msg=str(values)) as failure:
            call(*values)
        said = re.search(r'b(["\']).*\1$', str(failure.exception), re.DOTALL)  # rospy quotes the text as bytes
        return ast.literal_eval(said.group()).decode() if said else str(failure.exception)

    def world(self):
        """Return the world that the simulator publishes, as in a world file."""
        return json.loads(self.message('~world', String).data)

    def panel(self, name):
        """Return one panel of ``world``."""
        return next(panel for panel in self.world()['panels'] if panel['name'] == name)

    def start(self, *arguments):
        """Start a simulator as a Process that ends with the test."""
        process = Process(SIMULATOR, *arguments)
        self.addCleanup(process.stop)
        return process

    def ended(self, process, code):
        """Wait until a Process ends by itself, with this exit code and no traceback; return its output."""
        try:
            ended_with = process.process.wait(DEADLINE)
        except subprocess.TimeoutExpired:
            self.fail(f'not ended within {DEADLINE:g} s: {process.process.args}\n{process.output()}')
        self.assertEqual(code, ended_with, process.output())
        self.assertNotIn('Traceback', process.output())
        return process.output()

    def assert_at(self, place, x, y, yaw, tolerance=LENGTH_TOLERANCE):
        """Assert a position [m] and a heading [rad]."""
        self.assertAlmostEqual(x, place[0], delta=tolerance, msg=place)
        self.assertAlmostEqual(y, place[1], delta=tolerance, msg=place)
        self.assertAlmostEqual(0.0, math.remainder(yaw - place[2], 2.0 * math.pi), delta=tolerance, msg=place)


def place(odometry):
    """Return (x, y, yaw) [m, m, rad] of a nav_msgs/Odometry."""
    pose = odometry.pose.pose
    return pose.position.x, pose.position.y, yaw_of(pose.orientation)


def stands(odometry):
    """Return whether an Odometry shows a robot at rest."""
    twist = odometry.twist.twist
    return twist.linear.x == twist.linear.y == twist.angular.z == 0.0


def used(pid):
    """Return the processor time [s] that a process has used."""
    with open(f'/proc/{pid}/stat', encoding='ascii') as file:
        fields = file.read().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')
