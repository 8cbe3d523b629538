#!/usr/bin/env python3
"""The launch files, started for real: the motion of the turtle, and the effect of the arguments.

The nodes may be done before a test looks, so most of what is asserted stays: where the turtle stands, what it drew.
"""
import itertools
import math
import re
import sys

import rosnode
import rospy
from rosgraph_msgs.msg import Log
from turtlesim.srv import TeleportAbsolute

from rostest_support.common import BACKGROUND, FLOAT32_TOLERANCE, MIDDLE, PEN, Collected, Process, proxy, run, until
from rostest_support.course import POSITION_TOLERANCE, CourseCase, stands

DRIVE_DEADLINE = 90.0  # [s] drives take up to 10
LAUNCH_DEADLINE = 90.0  # [s] of a roslaunch of its own


class LaunchFilesTest(CourseCase):

    def until_at(self, x, y, turtle='turtle1'):
        """Wait until a turtle stands at a position."""
        until(lambda: turtle in self.turtles(), turtle)
        self.poses(turtle).next(
            lambda pose: stands(pose) and math.hypot(pose.x - x, pose.y - y) < POSITION_TOLERANCE,
            f'{turtle} standing at ({x}, {y})', DRIVE_DEADLINE)

    def until_gone(self, node):
        """Wait until a node has ended."""
        until(lambda: node not in rosnode.get_node_names(), f'the end of {node}', DRIVE_DEADLINE)

    def until_driven(self, node, x, y, turtle='turtle1'):
        """Wait until a turtle has left the pose (x, y, 0) that it began with, and the node that drives it has ended."""
        until(lambda: turtle in self.turtles(), turtle)
        self.poses(turtle).next(lambda pose: math.hypot(pose.x - x, pose.y - y) + abs(pose.theta) > 1e-4,
                                f'{turtle} having moved')
        self.until_gone(node)

    def color_at(self, x, y, turtle='turtle1'):
        """Return the colour at a position; the turtle is there afterwards."""
        self.jump(x, y, turtle=turtle)
        self.pose(turtle)
        return self.color(turtle)

    def until_pen(self, colour, turtle='turtle1'):
        """Draw with a turtle, there and back, until it does so in a colour."""
        steps = itertools.cycle((0.5, -0.5))

        def drawn():
            self.call(f'{turtle}/teleport_relative', next(steps), 0.0)
            self.pose(turtle)
            return self.color(turtle)
        until(lambda: drawn() == colour, f'a line of {turtle} in {colour}')

    @staticmethod
    def until_printed(x, y, times=1):
        """Wait until pose_subscriber has printed a position that often; return when [s] it did."""
        log = Collected('/rosout', Log)

        def printed():
            found = [(entry, re.match(r'Turtle pose: x:([\d.]+), y:([\d.]+)$', entry.msg)) for entry in log.messages]
            return [entry.header.stamp.to_sec() for entry, match in found if match and math.hypot(
                float(match.group(1)) - x, float(match.group(2)) - y) < POSITION_TOLERANCE]
        return until(lambda: len(printed()) >= times and printed(), f'({x}, {y}) printed {times} times')

    def test_launch_turtlesim(self):
        """The simulator, its window as the argument says."""
        self.pose()
        self.assertIs(False, rospy.get_param('/turtlesim/window'))

    def test_launch_velocity_publisher(self):
        self.poses().next(lambda pose: (pose.linear_velocity, round(pose.angular_velocity, 5)) == (0.5, 0.2),
                          'the turtle driving its circle')

    def test_launch_velocity_publisher_arguments(self):
        """sim, turtle, linear, angular, rate."""
        until(lambda: 'anna' in self.turtles(), 'anna')
        self.poses('anna').next(lambda pose: (pose.linear_velocity, pose.angular_velocity) == (0.75, -0.5),
                                'anna driving')
        self.assertTrue(stands(self.pose()), 'turtle1 stays')
        self.assertEqual(4.0, rospy.get_param('/velocity_publisher/rate'))

    def test_launch_pose_subscriber(self):
        self.jump(2.5, 7.25)
        self.until_printed(2.5, 7.25, times=5)

    def test_launch_pose_subscriber_arguments(self):
        """sim, turtle, rate."""
        times = self.until_printed(3.0, 3.0, times=3)
        self.assertGreater(times[2] - times[0], 0.5, 'three lines at 2 Hz take a second')

    def test_launch_stop_at_x(self):
        """With stay: the node ends, the simulator does not."""
        self.until_at(10.0, MIDDLE)
        self.until_gone('/stop_at_x')
        self.pose()

    def test_launch_stop_at_x_arguments(self):
        """sim, turtle, x, speed, turn_speed."""
        self.until_at(6.0, 3.0, 'anna')
        self.assertEqual((4.0, 8.0), (rospy.get_param('/stop_at_x/speed'), rospy.get_param('/stop_at_x/turn_speed')))
        self.assertEqual(MIDDLE, self.pose().x, 'turtle1 stays')

    def test_launch_drive_shape(self):
        """With stay: a square of side 2 m, of which the upper side is looked at, and the node ends."""
        self.until_driven('/drive_shape', MIDDLE, MIDDLE)
        self.assert_at(self.pose(), MIDDLE, MIDDLE, 0.0)
        self.assertEqual(PEN, self.color_at(MIDDLE + 1.0, MIDDLE + 2.0))

    def test_launch_drive_shape_arguments(self):
        """sim, turtle, shape, corners, size, speed, turn_speed."""
        self.until_driven('/drive_shape', 3.0, 3.0, 'anna')
        self.assert_at(self.pose('anna'), 4.5, 3.0)
        self.assertNotEqual(BACKGROUND, self.color_at(4.5, 4.0, 'anna'))
        self.assertEqual((0.5, 6.0, 9.0), tuple(rospy.get_param(f'/drive_shape/{name}')
                                                for name in ('size', 'speed', 'turn_speed')))

    def test_launch_services(self):
        """A blue pen, and gotoPose drives."""
        self.until_pen((0, 0, 255))
        proxy('/turtle1/gotoPose', TeleportAbsolute)(6.5, MIDDLE, 0.0)
        self.assert_at(self.pose(), 6.5, MIDDLE, 0.0)
        self.assertEqual((0, 0, 255), self.color())

    def test_launch_services_arguments(self):
        """sim, turtle, mode, r, g, b, width."""
        self.until_pen((9, 8, 7), 'anna')
        proxy('/anna/gotoPose', TeleportAbsolute)(6.5, 7.0, 1.0)
        self.assert_pose(self.pose('anna'), 6.5, 7.0, 1.0)
        self.assertEqual(1, rospy.get_param('/set_pen/width'))

    def test_launch_teleport_tour(self):
        self.until_driven('/teleport_tour', MIDDLE, MIDDLE)
        self.assert_at(self.pose(), 2.0, 9.0, math.pi, tolerance=FLOAT32_TOLERANCE)
        self.assertEqual((0, 0, 0), self.color())

    def test_launch_teleport_tour_arguments(self):
        """sim, turtle, positions, color, width, pause."""
        self.until_driven('/teleport_tour', 3.0, 3.0, 'anna')
        self.assert_pose(self.pose('anna'), 7.0, 8.0, 0.0)
        self.assertEqual((9, 8, 7), self.color('anna'))
        self.assertEqual((5, 0.0), (rospy.get_param('/teleport_tour/width'), rospy.get_param('/teleport_tour/pause')))

    def test_launch_turtle_course(self):
        """Five turtles, each with what its node makes it do."""
        self.until_driven('/drive_shape', 1.0, 1.5, 'turtle3')
        self.assert_at(self.pose('turtle3'), 1.0, 1.5, 0.0)
        self.assertNotEqual(BACKGROUND, self.color_at(2.0, 3.5, 'turtle3'))
        self.poses('turtle2').next(lambda pose: (pose.linear_velocity, pose.angular_velocity) == (0.5, 0.5),
                                   'turtle2 driving its circle')
        self.until_at(10.0, 10.5, 'turtle4')
        self.until_at(1.0, 6.5, 'turtle5')
        self.assertEqual((0, 0, 0), self.color('turtle5'))
        proxy('/turtle1/gotoPose', TeleportAbsolute)(6.0, 6.0, 0.0)
        self.assert_at(self.pose(), 6.0, 6.0, 0.0)
        self.assertEqual((0, 0, 255), self.color())
        self.until_printed(6.0, 6.0)

    def test_launch_ends_by_itself(self):
        """roslaunch ends with the node whose work is done, its simulator with it. Each is in a namespace of its own."""
        files = [('stop_at_x', 'speed:=5.0'), ('drive_shape', 'size:=0.5'), ('teleport_tour', 'pause:=0.1')]
        launches = [Process('roslaunch', 'turtle_robotont', f'{name}.launch', argument, ROS_NAMESPACE=f'of_{name}')
                    for name, argument in files]
        for launch in launches:
            self.addCleanup(launch.stop)
        for (name, _), launch in zip(files, launches):
            with self.subTest(name):
                said = self.ended(launch, deadline=LAUNCH_DEADLINE)
                self.assertRegex(said, fr'REQUIRED process \[of_{name}/{name}-\d+\] has died!\n'
                                       'process has finished cleanly')
                self.until_gone(f'/of_{name}/turtlesim')


class NoSimulatorTest(LaunchFilesTest):
    simulator = None


if __name__ == '__main__':
    run(NoSimulatorTest if sys.argv[1] == 'test_launch_ends_by_itself' else LaunchFilesTest)
