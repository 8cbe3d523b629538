#!/usr/bin/env python3
"""The topic turtle1/drive_status: its contents and its rate."""
import math

import rospy
from turtle_robotont.msg import DriveStatus
from turtle_robotont.srv import DrawShape, DriveTo

from rostest_support.common import DEADLINE, FLOAT32_TOLERANCE, MIDDLE, Collected, median_rate, proxy, run, until
from rostest_support.course import BackgroundCall, CourseCase

ENDED = (DriveStatus.ARRIVED, DriveStatus.FAILED, DriveStatus.PREEMPTED)
LEFT_TOLERANCE = 0.01  # [m, rad] that may remain after an arrival
OVERSHOOT = 0.02  # [m] by which the distance left may grow again
RATE, RATE_TOLERANCE = 10.0, 2.0  # [Hz]


class DriveStatusTest(CourseCase):

    def setUp(self):
        super().setUp()
        rospy.wait_for_service('/turtle1/draw_shape', DEADLINE)
        self.status = Collected('/turtle1/drive_status', DriveStatus)
        until(lambda: self.status.subscriber.get_num_connections(), 'the server on drive_status')

    def until_ended(self, number=1):
        """Return the messages as soon as so many drives have ended."""
        until(lambda: sum(message.state in ENDED for message in self.status.messages) == number, f'{number} ends')
        return list(self.status.messages)

    def test_drive_status_of_an_arrival(self):
        """All states in their order, the goal, and errors that fall to nothing."""
        proxy('/turtle1/drive_to', DriveTo)(7.0, 7.0, -1.0, True, 0.0, 0.0)
        messages = self.until_ended()
        states = [message.state for message in messages]
        self.assertEqual([DriveStatus.TURNING, DriveStatus.DRIVING, DriveStatus.ALIGNING, DriveStatus.SETTLING,
                          DriveStatus.ARRIVED], sorted(set(states), key=states.index))
        self.assertEqual(sorted(states), states, 'a state came back')
        self.assertEqual({(7.0, 7.0, -1.0, True, '')}, {
            (message.goal_x, message.goal_y, message.goal_theta, message.use_heading, message.reason)
            for message in messages})
        left = [message.distance_left for message in messages]
        self.assertAlmostEqual((7.0 - MIDDLE) * math.sqrt(2.0), left[0], delta=FLOAT32_TOLERANCE)
        self.assertAlmostEqual(math.pi / 4.0, messages[0].heading_error_left, delta=FLOAT32_TOLERANCE)
        self.assertTrue(all(b < a + OVERSHOOT for a, b in zip(left, left[1:])), left)
        self.assertLess(left[-1], LEFT_TOLERANCE)
        aligning = next(message for message in messages if message.state == DriveStatus.ALIGNING)
        self.assertAlmostEqual(-1.0 - math.pi / 4.0, aligning.heading_error_left, delta=0.1)
        self.assertLess(abs(messages[-1].heading_error_left), LEFT_TOLERANCE)
        stamps = [message.header.stamp for message in messages]
        self.assertEqual(sorted(stamps), stamps)

    def test_drive_status_rate(self):
        """Ten a second while it drives, none after it has ended."""
        proxy('/turtle1/drive_to', DriveTo)(9.0, MIDDLE, 0.0, False, 1.25, 0.0)
        messages = self.until_ended()
        driving = [message.header.stamp.to_sec() for message in messages if message.state == DriveStatus.DRIVING]
        self.assertAlmostEqual(RATE, median_rate(driving, span=5), delta=RATE_TOLERANCE)
        self.poses().more(20)
        self.assertEqual(len(messages), len(self.status.messages))

    def test_drive_status_of_a_takeover(self):
        """PREEMPTED with its reason and its goal, then the newer goal's states up to ARRIVED."""
        poses = self.poses()
        older = BackgroundCall('/turtle1/drive_to', DriveTo, 10.0, MIDDLE, 0.0, False, 0.0, 0.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle driving')
        proxy('/turtle1/drive_to', DriveTo)(6.0, 6.0, 0.0, False, 0.0, 0.0)
        older.ended()
        ends = [message for message in self.until_ended(2) if message.state in ENDED]
        self.assertEqual([(DriveStatus.PREEMPTED, 10.0), (DriveStatus.ARRIVED, 6.0)],
                         [(message.state, message.goal_x) for message in ends])
        self.assertEqual('preempted: a newer goal took over', ends[0].reason)

    def test_drive_status_of_a_shape(self):
        """The goals are the corners, one after the other."""
        proxy('/turtle1/draw_shape', DrawShape)('triangle', 0.5, [], 4.0)
        messages = self.until_ended()
        goals = [(round(message.goal_x - MIDDLE, 3), round(message.goal_y - MIDDLE, 3)) for message in messages]
        self.assertEqual([(0.5, 0.0), (0.25, 0.433), (0.0, 0.0)], sorted(set(goals), key=goals.index))
        self.assertEqual(DriveStatus.ARRIVED, messages[-1].state)

    def test_drive_status_of_a_failure(self):
        """FAILED with its reason: the turtle is killed."""
        poses = self.poses()
        call = BackgroundCall('/turtle1/drive_to', DriveTo, 10.0, MIDDLE, 0.0, False, 0.0, 0.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle driving')
        self.call('kill', 'turtle1')
        reason = call.ended().reason
        last = self.until_ended()[-1]
        self.assertEqual((DriveStatus.FAILED, reason), (last.state, last.reason))
        self.assertIn('no pose', reason)


if __name__ == '__main__':
    run(DriveStatusTest)
