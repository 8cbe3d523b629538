#!/usr/bin/env python3
"""The service turtle1/draw_shape: shapes, answers, and refused requests."""
import math

import rospy
from geometry_msgs.msg import Point
from turtle_robotont.srv import DrawShape

from rostest_support.common import DEADLINE, MIDDLE, proxy, run
from rostest_support.course import POSITION_TOLERANCE, CourseCase
from turtle_robotont.driving.shapes import SHAPES

MEASURED_TOLERANCE = 0.02  # [m] between two measurements: the server may miss the first and last poses
REFUSED = [  # shape, size, corners, speed, words in the reason
    ('star', 0.0, [], 0.0, ["'star'", ', '.join(SHAPES)]),
    ('square', 7.0, [], 0.0, ['(12.54, 5.54)', 'the largest possible size is 5.54 m']),
    ('triangle', 2.0, [], 11.0, ['speed is 11 m/s', '0.05 to 10 m/s']),
    ('corners', 0.0, [(1.0, 1.0)], 0.0, ['1 corners', 'at least 2']),
]


class DrawShapeTest(CourseCase):

    def setUp(self):
        super().setUp()
        rospy.wait_for_service('/turtle1/draw_shape', DEADLINE)

    def draw(self, shape, size=0.0, corners=(), speed=0.0):
        return proxy('/turtle1/draw_shape', DrawShape)(shape, size, [Point(x, y, 0.0) for x, y in corners], speed)

    def assert_drawn(self, answer, track, corners):
        """Assert that a track has the corners, and that the answer says how closely."""
        self.assertTrue(answer.drawn, answer)
        self.assertEqual('', answer.reason)
        self.assert_passes(track, corners)
        worst = max(min(math.hypot(pose.x - x, pose.y - y) for pose in track) for x, y in corners)
        self.assertAlmostEqual(worst, answer.corner_error, delta=MEASURED_TOLERANCE)
        gap = math.hypot(track[-1].x - corners[-1][0], track[-1].y - corners[-1][1])
        self.assertAlmostEqual(gap, answer.closing_error, delta=MEASURED_TOLERANCE)

    def test_draw_shape_circle(self):
        """corner_error is how far the line is off the circle."""
        poses = self.poses()
        answer = self.draw('circle', 2.0, speed=4.0)
        self.assertTrue(answer.drawn, answer)
        worst = max(abs(math.hypot(pose.x - MIDDLE, pose.y - MIDDLE - 1.0) - 1.0) for pose in poses.messages)
        self.assertLess(worst, POSITION_TOLERANCE)
        self.assertAlmostEqual(worst, answer.corner_error, delta=MEASURED_TOLERANCE)
        self.assertLess(answer.closing_error, POSITION_TOLERANCE)

    def test_draw_shape_corners(self):
        """Those of ~corners, where the request has none."""
        poses = self.poses()
        self.assert_drawn(self.draw('corners', speed=6.0), poses.messages, [(6.0, 6.0), (6.5, 6.5), (6.0, 6.0)])

    def test_draw_shape_refuses(self):
        """Nonsense, and shapes that do not fit, are answered with a reason, and the turtle does not move."""
        before, commands = self.pose(), self.commands()
        for shape, size, corners, speed, texts in REFUSED:
            with self.subTest(shape=shape, size=size, corners=corners, speed=speed):
                answer = self.draw(shape, size, corners, speed)
                self.assertFalse(answer.drawn)
                self.assertTrue(math.isnan(answer.corner_error) and math.isnan(answer.closing_error), answer)
                self.assertEqual(0.0, answer.elapsed)
                for text in texts:
                    self.assertIn(text, answer.reason)
        self.assertEqual(before, self.pose())
        self.assertEqual([], commands.messages)


if __name__ == '__main__':
    run(DrawShapeTest)
