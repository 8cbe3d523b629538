#!/usr/bin/env python3
"""A drive whose node is ended, or whose machine stands still."""
import os
import signal
import time
import xmlrpc.client

import rosgraph
import rosnode
import rospy
from turtle_robotont.srv import DriveTo

from rostest_support.common import DEADLINE, MIDDLE, nightly, run
from rostest_support.course import BackgroundCall, CourseCase

SPEED = 1.0  # [m/s]


class ShutdownTest(CourseCase):

    def test_drive_shutdown_of_a_server(self):
        """Ctrl-C: the turtle is stopped long before the simulator would, and the call fails rather than hang."""
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

    @nightly
    def test_drive_machine_stands_still(self):
        """The whole machine stands still for longer than a pose may take: the drive continues afterwards."""
        poses = self.poses()
        process = self.start('drive_shape.py', '_size:=1.0')
        poses.next(lambda pose: pose.x > MIDDLE + 0.1, 'the turtle driving')
        simulator = xmlrpc.client.ServerProxy(rosnode.get_api_uri(rosgraph.Master('/test'), '/turtlesim'))
        pids = process.process.pid, simulator.getPid('/test')[2]
        for sign, lasting in ((signal.SIGSTOP, 2.0), (signal.SIGCONT, 0.0)):
            for pid in pids:
                os.kill(pid, sign)
            time.sleep(lasting)  # a suspended machine: there is nothing to poll for
        self.assertIn('Drawn in', self.ended(process))


if __name__ == '__main__':
    run(ShutdownTest)
