#!/usr/bin/env python3
"""Nodes that are ended while they drive: the turtle is stopped, long before the simulator does that by itself."""
import signal
import subprocess

import rospy
from turtle_robotont.srv import DriveTo

from rostest_support.common import DEADLINE, MIDDLE, run
from rostest_support.course import BackgroundCall, CourseCase

SPEED = 1.0  # [m/s]


class ShutdownTest(CourseCase):

    def drive_and_end(self, process, end, code=1):
        """Wait until the turtle drives, end the node, and check how the turtle stops."""
        poses, commands = self.poses(), self.commands()
        poses.next(lambda pose: pose.linear_velocity > 0.9 * SPEED, 'the turtle driving')
        end()
        self.ended(process, code)
        self.assert_stopped_by(poses, commands, len(poses.messages))
        self.assertLess(poses.messages[-1].x, MIDDLE + 3.0, 'it drove on to its goal')

    def test_drive_shutdown_of_a_server(self):
        """Ctrl-C: the caller's call fails rather than hang."""
        process = self.start('drive_server.py')
        rospy.wait_for_service('/turtle1/drive_to', DEADLINE)
        call = BackgroundCall('/turtle1/drive_to', DriveTo, 10.5, MIDDLE, 0.0, False, SPEED, 0.0)
        self.drive_and_end(process, lambda: process.process.send_signal(signal.SIGINT), code=0)
        answer = call.ended()
        self.assertTrue(call.error or 'preempted: the node is shutting down' in answer.reason, answer)

    def test_drive_shutdown_of_a_shape(self):
        """SIGTERM, as roslaunch sends it."""
        process = self.start('drive_shape.py', '_size:=5', f'_speed:={SPEED}')
        self.drive_and_end(process, lambda: process.process.send_signal(signal.SIGTERM))

    def test_drive_shutdown_by_rosnode_kill(self):
        """A node that is ended by rosnode kill while it drives."""
        process = self.start('stop_at_x.py', f'_speed:={SPEED}')
        self.drive_and_end(process, lambda: subprocess.run(
            ['rosnode', 'kill', '/stop_at_x'], stdout=subprocess.DEVNULL, timeout=DEADLINE, check=True), code=0)


if __name__ == '__main__':
    run(ShutdownTest)
