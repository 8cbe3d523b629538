#!/usr/bin/env python3
"""turtle_course.launch, started for real: five turtles, each with what its node makes it do.

The nodes may be done before a test looks, so most of what is asserted stays: where a turtle stands, what it drew.
"""
import math
import re

import rosnode
from rosgraph_msgs.msg import Log
from turtlesim.srv import TeleportAbsolute

from rostest_support.common import BACKGROUND, Collected, proxy, run, until
from rostest_support.course import POSITION_TOLERANCE, CourseCase, stands

DRIVE_DEADLINE = 90.0  # [s] drives take up to 10


class LaunchFilesTest(CourseCase):

    def until_at(self, x, y, turtle):
        """Wait until a turtle stands at a position."""
        until(lambda: turtle in self.turtles(), turtle)
        self.poses(turtle).next(
            lambda pose: stands(pose) and math.hypot(pose.x - x, pose.y - y) < POSITION_TOLERANCE,
            f'{turtle} standing at ({x}, {y})', DRIVE_DEADLINE)

    def until_driven(self, node, x, y, turtle):
        """Wait until a turtle has left the pose (x, y, 0) that it began with, and the node that drives it has ended."""
        until(lambda: turtle in self.turtles(), turtle)
        self.poses(turtle).next(lambda pose: math.hypot(pose.x - x, pose.y - y) + abs(pose.theta) > 1e-4,
                                f'{turtle} having moved')
        until(lambda: node not in rosnode.get_node_names(), f'the end of {node}', DRIVE_DEADLINE)

    def color_at(self, x, y, turtle):
        """Return the colour at a position; the turtle is there afterwards."""
        self.jump(x, y, turtle=turtle)
        self.pose(turtle)
        return self.color(turtle)

    @staticmethod
    def until_printed(x, y):
        """Wait until pose_subscriber has printed a position."""
        log = Collected('/rosout', Log)

        def printed():
            found = [re.match(r'Turtle pose: x:([\d.]+), y:([\d.]+)$', entry.msg) for entry in log.messages]
            return any(match and math.hypot(float(match[1]) - x, float(match[2]) - y) < POSITION_TOLERANCE
                       for match in found)
        until(printed, f'({x}, {y}) printed')

    def test_launch_turtle_course(self):
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


if __name__ == '__main__':
    run(LaunchFilesTest)
