#!/usr/bin/env python3
"""stop_at_x.py drives the turtle to x = 10 and stops there."""
from turtlesim.srv import TeleportAbsolute

from lesson_case import LessonCase, rospy, run

TOLERANCE = 0.05  # [m]
STEP = 0.05  # [m] in 16 ms: 3 m/s


class LessonStopAtX(LessonCase):

    def test_stops_at_ten(self):
        """It drives there, and ends by itself."""
        self.until_ended(self.start('stop_at_x.py'))
        self.until_the_turtle_stands()
        self.assertAlmostEqual(10.0, self.poses[-1].x, delta=TOLERANCE)
        self.assertLess(self.largest_step(), STEP)

    def test_another_x(self):
        """~x, behind a turtle that looks up: on its way there it keeps y."""
        rospy.ServiceProxy('turtle1/teleport_absolute', TeleportAbsolute)(6.0, 9.0, 1.2)
        self.until_ended(self.start('stop_at_x.py', '_x:=3.5', '_speed:=2.0'))
        self.until_the_turtle_stands()
        self.assertAlmostEqual(3.5, self.poses[-1].x, delta=TOLERANCE)
        self.assertAlmostEqual(9.0, self.poses[-1].y, delta=TOLERANCE)


if __name__ == '__main__':
    run(LessonStopAtX)
