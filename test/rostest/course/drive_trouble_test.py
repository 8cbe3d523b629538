#!/usr/bin/env python3
"""What keeps a turtle from its goal while it drives: each is answered with a reason, and the node lives on."""
import time

import rospy
from std_srvs.srv import Trigger
from turtle_robotont.srv import DrawShape, DriveTo

from rostest_support.common import DEADLINE, MIDDLE, proxy, run, until
from rostest_support.course import STOP, BackgroundCall, CourseCase

FAR = (10.5, MIDDLE, 0.0, False, 1.0, 0.0)  # a request of drive_to that takes 5 s
NEAR = (6.0, 6.0, 0.0, False, 2.0, 0.0)
GONE = r'no pose on /turtle1/pose for 1 s; is the simulator running, and does the turtle turtle1 exist\?'


class TroubleTest(CourseCase):
    """With a simulator and a drive_server that roslaunch started."""

    def drive(self, *request):
        """Call drive_to in the background; return that when the turtle is driving."""
        rospy.wait_for_service('/turtle1/drive_to', DEADLINE)
        poses, self.sent = self.poses(), self.commands()
        call = BackgroundCall('/turtle1/drive_to', DriveTo, *request)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle driving')
        return call

    def assert_given_up(self, call):
        """Assert that no pose arrives any more: the answer says so, and the last Twist is all zeros."""
        answer = call.ended()
        self.assertFalse(answer.arrived)
        self.assertRegex(answer.reason, GONE)
        until(lambda: self.sent.messages[-1] == STOP, 'a last Twist of zeros')

    def assert_drives_again(self):
        """Assert that the server serves the next goal."""
        answer = proxy('/turtle1/drive_to', DriveTo)(*NEAR)
        self.assertTrue(answer.arrived, answer)
        self.assert_at(self.pose(), 6.0, 6.0)

    def test_drive_turtle_killed(self):
        """The turtle is killed; one of the same name that comes afterwards is driven again."""
        call = self.drive(*FAR)
        self.call('kill', 'turtle1')
        self.assert_given_up(call)
        self.assertEqual('turtle1', self.call('spawn', 5.0, 5.0, 0.0, 'turtle1').name)
        self.assert_drives_again()

    def test_drive_shape_teleported_away(self):
        """The turtle is teleported while it draws: the shape is given up, and the turtle stops."""
        rospy.wait_for_service('/turtle1/draw_shape', DEADLINE)
        poses = self.poses()
        call = BackgroundCall('/turtle1/draw_shape', DrawShape, 'square', 4.0, [], 1.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle driving')
        self.jump(7.0, 7.0)
        answer = call.ended()
        self.assertFalse(answer.drawn)
        self.assertRegex(answer.reason, r'corner 1 of 4: something else moved .* to \(7\.\d\d, 7\.\d\d\)')
        self.assert_stands(poses)

    def test_drive_paused(self):
        """Simulated time stands still for longer than a pose may take: the drive waits, and continues with the time."""
        call = self.drive(8.0, MIDDLE, 0.0, False, 1.0, 0.0)
        self.assertTrue(proxy('/turtlesim/pause', Trigger)().success)
        time.sleep(2.0)  # of wall time: there is nothing to poll for
        self.assertTrue(call.is_alive())
        self.assertTrue(proxy('/turtlesim/resume', Trigger)().success)
        answer = call.ended()
        self.assertTrue(answer.arrived, answer)
        self.assert_at(self.pose(), 8.0, MIDDLE)

    def test_drive_waits_in_vain(self):
        """No turtle, or no subscriber to its commands: the answer comes after a wait of 10 s."""
        turtles = ('nobody', 'lost/turtle1')
        for turtle in turtles:
            rospy.wait_for_service(f'/{turtle}/drive_to', DEADLINE)
        calls = [BackgroundCall(f'/{turtle}/drive_to', DriveTo, *NEAR) for turtle in turtles]
        for call, reason in zip(calls, ('no pose on /nobody/pose for 10 s; is the simulator running, and does the '
                                        'turtle nobody exist?', 'no subscriber on /lost/turtle1/cmd_vel after 10 s')):
            answer = call.ended()
            self.assertFalse(answer.arrived)
            self.assertIn(reason, answer.reason)


if __name__ == '__main__':
    run(TroubleTest)
