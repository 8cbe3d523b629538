#!/usr/bin/env python3
"""A server that is ended while it drives: the turtle is stopped, long before the simulator does that by itself."""
import signal

import rospy
from turtle_robotont.srv import DriveTo

from rostest_support.common import DEADLINE, MIDDLE, run
from rostest_support.course import BackgroundCall, CourseCase

SPEED = 1.0  # [m/s]


class ShutdownTest(CourseCase):

    def test_drive_shutdown_of_a_server(self):
        """Ctrl-C: the caller's call fails rather than hang."""
        process = self.start('drive_server.py')
        rospy.wait_for_service('/turtle1/drive_to', DEADLINE)
        call = BackgroundCall('/turtle1/drive_to', DriveTo, 10.5, MIDDLE, 0.0, False, SPEED, 0.0)
        poses, commands = self.poses(), self.commands()
        poses.next(lambda pose: pose.linear_velocity > 0.9 * SPEED, 'the turtle driving')
        process.process.send_signal(signal.SIGINT)
        self.ended(process)
        self.assert_stopped_by(poses, commands, len(poses.messages))
        self.assertLess(poses.messages[-1].x, MIDDLE + 3.0, 'it drove on to its goal')
        answer = call.ended()
        self.assertTrue(call.error or 'preempted: the node is shutting down' in answer.reason, answer)


if __name__ == '__main__':
    run(ShutdownTest)
