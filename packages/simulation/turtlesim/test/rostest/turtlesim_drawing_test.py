#!/usr/bin/env python3
"""clear, set_pen and teleports: their drawings, by the turtle's own colour sensor and the saved picture."""
import math

import rospy

from rostest_support.common import BACKGROUND, MIDDLE, PEN, SimulatorCase, run

RED = (255, 0, 0)


class DrawingTest(SimulatorCase):

    def color_at(self, x, y):
        """Move turtle1 to a place [m] without drawing; return the colour there."""
        self.jump(x, y)
        return self.color()

    def line(self, *pen):
        """Draw a line from (2, 2) to (6, 2) with a pen (r, g, b, width, off)."""
        self.jump(2.0, 2.0)
        self.call('turtle1/set_pen', *pen)
        self.call('turtle1/teleport_absolute', 6.0, 2.0, 0.0)

    def test_turtlesim_clear(self):
        """clear empties the canvas; the turtle does not change."""
        self.line(*RED, 5, 0)
        self.assertEqual(RED, self.color())
        before = self.pose()
        self.call('clear')
        self.assertEqual(before, self.pose())
        self.assertEqual(BACKGROUND, self.color())
        self.assertEqual(BACKGROUND, self.color_at(4.0, 2.0))

    def test_turtlesim_parameters_wait_for_clear(self):
        """A background parameter alone changes nothing; reset reads it as clear does, but none beside the simulator."""
        self.set_parameter('background_r', 200)
        rospy.set_param('/background_g', 7)
        self.assertEqual(BACKGROUND, self.color())
        self.call('reset')
        self.assertEqual((200, *BACKGROUND[1:]), self.color())

    def test_turtlesim_set_pen(self):
        """Colour and width: 40 px are 20 px to either side, 0.44 m."""
        self.line(*RED, 40, 0)
        self.assertEqual(RED, self.color())
        self.assertEqual([RED, RED, BACKGROUND, BACKGROUND],
                         [self.color_at(4.0, y) for y in (2.4, 1.6, 2.5, 1.5)])

    def test_turtlesim_teleport_absolute(self):
        """The turtle is there in the next pose, with a line drawn to it in the pen's colour."""
        self.call('turtle1/teleport_absolute', 2.0, 3.0, 1.0)
        self.assert_pose(self.pose(), 2.0, 3.0, 1.0)
        self.assertEqual(PEN, self.color())
        middle_of_the_way = (2.0 + MIDDLE) / 2.0, (3.0 + MIDDLE) / 2.0
        self.assertEqual(PEN, self.color_at(*middle_of_the_way))
        self.assertEqual(BACKGROUND, self.color_at(8.0, 8.0))

    def test_turtlesim_teleport_relative(self):
        """First the turn, then the way along the new heading."""
        self.jump(3.0, 4.0, 0.5)
        self.call('turtle1/set_pen', *RED, 5, 0)
        self.call('turtle1/teleport_relative', 2.0, 1.0)
        x, y = 3.0 + 2.0 * math.cos(1.5), 4.0 + 2.0 * math.sin(1.5)
        self.assert_pose(self.pose(), x, y, 1.5)
        self.assertEqual(RED, self.color_at(3.0 + math.cos(1.5), 4.0 + math.sin(1.5)))
        self.jump(x, y, 1.5)
        self.call('turtle1/teleport_relative', -2.0, 0.0)
        self.assert_pose(self.pose(), 3.0, 4.0, 1.5)


if __name__ == '__main__':
    run(DrawingTest)
