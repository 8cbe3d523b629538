#!/usr/bin/env python3
"""The service turtle1/drive_to: answers, speed and tolerance, refused requests; the topic turtle1/drive_status."""
import math
import statistics

import rospy
from turtle_robotont.msg import DriveStatus
from turtle_robotont.srv import DriveTo

from rostest_support.common import DEADLINE, DT, FLOAT32_TOLERANCE, MIDDLE, Collected, proxy, run, until
from rostest_support.course import HEADING_TOLERANCE, SPEED_TOLERANCE, BackgroundCall, CourseCase, stands, wrapped

DEFAULT_TOLERANCE = 0.01  # [m]
OVERSHOOT = 0.02  # [m] by which the distance left may grow again
STATUS_PERIOD = 0.09  # [s] of 0.1 s wall time
ELAPSED_TOLERANCE = 0.5  # [s] poses may come late
GOAL = {'x': 5.0, 'y': 6.0, 'theta': 0.0, 'use_heading': False, 'speed': 0.0, 'tolerance': 0.0}
REFUSED = [  # request, words in the reason
    ({'x': math.nan}, ['x is nan', 'finite']),
    ({'x': 11.09}, ['x is 11.09 m', '0 to 11.0889 m']),
    ({'speed': 10.5}, ['speed is 10.5 m/s', '0.05 to 10 m/s']),
    ({'tolerance': 0.001}, ['tolerance is 0.001 m', '0.002 to 1 m']),
    ({'tolerance': math.inf}, ['tolerance is inf', '0.002 to 1 m']),
]


class DriveToTest(CourseCase):

    def setUp(self):
        super().setUp()
        rospy.wait_for_service('/turtle1/drive_to', DEADLINE)

    def drive_to(self, **values):
        return proxy('/turtle1/drive_to', DriveTo)(*dict(GOAL, **values).values())

    def status(self):
        """Return the Collected messages of drive_status."""
        status = Collected('/turtle1/drive_status', DriveStatus)
        until(status.subscriber.get_num_connections, 'the server on drive_status')
        return status

    def assert_arrived(self, answer, x, y, tolerance=DEFAULT_TOLERANCE):
        """Assert that the turtle stands at (x, y), and that the answer says so."""
        self.assertTrue(answer.arrived, answer)
        self.assertEqual('', answer.reason)
        pose = self.pose()
        self.assertTrue(stands(pose))
        self.assertAlmostEqual(math.hypot(pose.x - x, pose.y - y), answer.position_error, delta=FLOAT32_TOLERANCE)
        self.assertLessEqual(answer.position_error, tolerance)

    def test_drive_to_arrives(self):
        """With a heading: the errors answered are those of the turtle's pose, the time is that of the drive."""
        poses = self.poses()
        answer = self.drive_to(x=7.0, y=4.0, theta=2.0 + 4.0 * math.pi, use_heading=True)
        self.assert_arrived(answer, 7.0, 4.0)
        off = abs(wrapped(self.pose().theta - 2.0))
        self.assertLess(off, HEADING_TOLERANCE)
        self.assertAlmostEqual(off, answer.heading_error, delta=FLOAT32_TOLERANCE)
        driving = [number for number, pose in enumerate(poses.messages) if not stands(pose)]
        self.assertAlmostEqual((driving[-1] - driving[0]) * DT, answer.elapsed, delta=ELAPSED_TOLERANCE)

    def test_drive_to_speed(self):
        """The speed asked for, else ~speed, is reached and not exceeded."""
        poses = self.poses()
        for x, asked, allowed in ((8.0, 3.5, 3.5), (6.0, 0.0, 1.25)):
            with self.subTest(asked=asked):
                begin = len(poses.messages)
                self.assert_arrived(self.drive_to(x=x, y=MIDDLE, speed=asked), x, MIDDLE)
                track = poses.messages[begin:]
                self.assertAlmostEqual(allowed, max(pose.linear_velocity for pose in track), delta=SPEED_TOLERANCE)
                self.assert_driven(track, allowed)

    def test_drive_status(self):
        """All states in their order, ten messages a second while it drives, and the goal."""
        status = self.status()
        self.drive_to(x=7.0, y=7.0, theta=-1.0, use_heading=True)
        until(lambda: status.messages[-1].state == DriveStatus.ARRIVED, 'the last message')
        messages = list(status.messages)
        states = [message.state for message in messages]
        self.assertEqual(sorted(states), states, 'a state came back')
        self.assertEqual({DriveStatus.TURNING, DriveStatus.DRIVING, DriveStatus.ALIGNING, DriveStatus.SETTLING,
                          DriveStatus.ARRIVED}, set(states))
        self.assertEqual({(7.0, 7.0, -1.0, True, '')}, {
            (message.goal_x, message.goal_y, message.goal_theta, message.use_heading, message.reason)
            for message in messages})
        left = [message.distance_left for message in messages]
        self.assertAlmostEqual((7.0 - MIDDLE) * math.sqrt(2.0), left[0], delta=FLOAT32_TOLERANCE)
        self.assertTrue(all(b < a + OVERSHOOT for a, b in zip(left, left[1:])), left)
        self.assertLess(max(left[-1], abs(messages[-1].heading_error_left)), DEFAULT_TOLERANCE)
        self.assertAlmostEqual(math.pi / 4.0, messages[0].heading_error_left, delta=FLOAT32_TOLERANCE)
        times = [message.header.stamp.to_sec() for message in messages if message.state == DriveStatus.DRIVING]
        self.assertGreater(statistics.median(b - a for a, b in zip(times, times[1:])), STATUS_PERIOD)

    def test_drive_status_of_a_takeover(self):
        """PREEMPTED with its reason and its goal, then ARRIVED at the newer goal."""
        status, poses = self.status(), self.poses()
        older = BackgroundCall('/turtle1/drive_to', DriveTo, 10.0, MIDDLE, 0.0, False, 0.0, 0.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.3, 'the turtle driving')
        self.drive_to(x=6.0, y=6.0)
        self.assertFalse(older.ended().arrived)

        def ends():
            return [(message.state, message.goal_x, message.reason) for message in status.messages
                    if message.state in (DriveStatus.ARRIVED, DriveStatus.FAILED, DriveStatus.PREEMPTED)]
        until(lambda: len(ends()) == 2, lambda: f'two ends, not {ends()}')
        self.assertEqual([(DriveStatus.PREEMPTED, 10.0, 'preempted: a newer goal took over'),
                          (DriveStatus.ARRIVED, 6.0, '')], ends())

    def test_drive_to_refuses(self):
        """Nonsense is answered with a reason, and the turtle has not moved."""
        before, commands = self.pose(), self.commands()
        for values, texts in REFUSED:
            with self.subTest(values):
                answer = self.drive_to(**values)
                self.assertFalse(answer.arrived)
                self.assertTrue(math.isnan(answer.position_error) and math.isnan(answer.heading_error), answer)
                self.assertEqual(0.0, answer.elapsed)
                for text in texts:
                    self.assertIn(text, answer.reason)
        self.assertEqual(before, self.pose())
        self.assertEqual([], commands.messages)


if __name__ == '__main__':
    run(DriveToTest)
