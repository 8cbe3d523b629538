#!/usr/bin/env python3
"""pose_subscriber.py prints the poses of the turtle."""
from turtlesim.srv import TeleportAbsolute

from lesson_case import LessonCase, rospy, run


class LessonSubscriber(LessonCase):

    def test_prints_poses(self):
        """The first pose, and one after a teleport."""
        program = self.start('pose_subscriber.py')
        self.until_printed(program, 'Turtle pose: x:5.544445, y:5.544445')
        rospy.ServiceProxy('turtle1/teleport_absolute', TeleportAbsolute)(2.5, 7.25, 0.0)
        self.until_printed(program, 'Turtle pose: x:2.500000, y:7.250000')
        program.ctrl_c()
        self.until_ended(program)


if __name__ == '__main__':
    run(LessonSubscriber)
