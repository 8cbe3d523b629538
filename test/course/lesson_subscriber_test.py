#!/usr/bin/env python3
"""pose_subscriber.py prints the poses of the turtle."""
import re

from geometry_msgs.msg import Twist, Vector3
from turtlesim.srv import TeleportAbsolute

from lesson_case import LessonCase, rospy, run


class LessonSubscriber(LessonCase):

    def test_prints_poses(self):
        """The first pose, one after a teleport, and each of a drive."""
        program = self.start('pose_subscriber.py')
        self.until_printed(program, 'Turtle pose: x:5.544445, y:5.544445')
        rospy.ServiceProxy('turtle1/teleport_absolute', TeleportAbsolute)(2.5, 7.25, 0.0)
        self.until_printed(program, 'Turtle pose: x:2.500000, y:7.250000')
        velocity = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)

        def driven_on():
            velocity.publish(Twist(linear=Vector3(x=1.0)))
            return self.poses[-1].x > 3.0
        self.until(driven_on, 'the turtle driving')
        driven = [f'x:{pose.x:.6f}, y:{pose.y:.6f}' for pose in self.poses if 2.51 < pose.x < 2.99]
        self.until_printed(program, driven[-1])
        printed = [line.split('pose: ')[1] for line in program.output().splitlines() if 'pose: ' in line]
        begin = printed.index(driven[0])
        self.assertEqual(driven, printed[begin:begin + len(driven)])
        program.ctrl_c()
        self.until_ended(program)

    def test_rate(self):
        """~rate: at most so many lines a second."""
        program = self.start('pose_subscriber.py', '_rate:=5')
        self.until(lambda: program.output().count('Turtle pose') > 5, 'lines')
        times = [float(time) for time in re.findall(r'\[(\d+\.\d+)\]: Turtle pose', program.output())]
        self.assertGreater((times[-1] - times[0]) / (len(times) - 1), 0.18)


if __name__ == '__main__':
    run(LessonSubscriber)
