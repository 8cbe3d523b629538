#!/usr/bin/env python3
"""drive_shape.py: the corners of every shape, measured on the turtle's own poses; its end; refused parameters."""
import math

import rospy

from rostest_support.common import DEADLINE, one_in, run
from rostest_support.course import CourseCase

SHAPE_DEADLINE = 90.0  # [s] a shape takes 4 to 8
START = (8.0, 3.0, 2.0)  # of the turtle: x [m], y [m], theta [rad]


def ahead(start, distance, turn):
    """Return where a turtle gets from ``start`` (x, y, theta) by turning and then driving a distance [m]."""
    return start[0] + distance * math.cos(start[2] + turn), start[1] + distance * math.sin(start[2] + turn)


class ShapeCase(CourseCase):

    def draw(self, *arguments, speed=2.0):
        """Draw a shape; return its poses, after assertions that hold for all shapes."""
        poses = self.poses()
        self.ended(self.start('drive_shape.py', *arguments), deadline=SHAPE_DEADLINE)
        self.assert_stands(poses)
        self.assert_driven(poses.messages, speed)
        return poses.messages


class DriveShapeTest(ShapeCase):

    def test_drive_shape_refuses_what_does_not_fit(self):
        """Exit code 1 with what would fit, before the turtle has moved at all."""
        poses, commands = self.poses(), self.commands()
        for shape, outside, fits in one_in(3, (('square', r'corner 1 \(12\.54, 5\.54\)', r'5\.54'),
                                               ('circle', r'upper end', r'5\.54'),
                                               ('triangle', r'corner 1 \(12\.54, 5\.54\)', r'5\.54'))):
            with self.subTest(shape):
                said = self.ended(self.start('drive_shape.py', f'_shape:={shape}', '_size:=7'), code=1)
                self.assertRegex(said, fr'\[FATAL\].*a {shape} of size 7 m .*{outside}.*'
                                       fr'the largest possible size is {fits} m')
        self.assertEqual([], commands.messages)
        self.assertEqual(poses.messages[0], self.pose())


class TopicsAloneTest(ShapeCase):
    """The teleport services of this simulator have names that no node expects."""

    def setUp(self):
        rospy.wait_for_service('/elsewhere/teleport_absolute', DEADLINE)

    def test_drive_shape_triangle(self):
        """From another pose, at another speed."""
        self.call('elsewhere/teleport_absolute', *START)
        self.assert_at(self.pose(), *START)
        corners = [START[:2], ahead(START, 3.0, 0.0), ahead(START, 3.0, math.pi / 3.0), START[:2]]
        track = self.draw('_shape:=triangle', '_size:=3', '_speed:=4', '_turn_speed:=10', speed=4.0)
        self.assert_passes(track, corners)
        self.assert_sides(track, corners)
        self.assert_at(track[-1], *START)


if __name__ == '__main__':
    run(DriveShapeTest, TopicsAloneTest)
