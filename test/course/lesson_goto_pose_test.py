#!/usr/bin/env python3
"""goto_pose_server.py serves turtle1/gotoPose: the turtle drives to a pose."""
import math

from turtlesim.srv import TeleportAbsolute

from lesson_case import DEADLINE, LessonCase, rospy, run

TOLERANCE, HEADING_TOLERANCE = 0.05, 0.05  # [m, rad]
STEP = 0.1  # [m] in 16 ms: 6 m/s


class LessonGotoPose(LessonCase):

    def test_the_turtle_drives_to_the_pose(self):
        """The service answers when the turtle is there."""
        self.start('goto_pose_server.py')
        rospy.wait_for_service('turtle1/gotoPose', DEADLINE)
        rospy.ServiceProxy('turtle1/gotoPose', TeleportAbsolute)(1.5, 2.5, 3.14)
        self.until_the_turtle_stands()
        pose = self.poses[-1]
        self.assertLess(math.hypot(pose.x - 1.5, pose.y - 2.5), TOLERANCE)
        self.assertLess(abs(math.remainder(pose.theta - 3.14, math.tau)), HEADING_TOLERANCE)
        self.assertLess(self.largest_step(), STEP)


if __name__ == '__main__':
    run(LessonGotoPose)
