#!/usr/bin/env python3
"""drive_shape.py draws a square of 2 m by topics alone."""
from lesson_case import LessonCase, run

TOLERANCE = 0.05  # [m]
STEP = 0.1  # [m] in 16 ms: 6 m/s
CORNERS = (7.544, 5.544), (7.544, 7.544), (5.544, 7.544), (5.544, 5.544)


class LessonSquare(LessonCase):

    def test_draws_a_square(self):
        """It comes by all corners, drives, and ends where it started."""
        self.until_ended(self.start('drive_shape.py'))
        self.until_the_turtle_stands()
        for corner in CORNERS:
            self.assertLess(self.nearest(*corner), TOLERANCE, corner)
        self.assertLess(self.largest_step(), STEP)
        self.assertAlmostEqual(CORNERS[-1][0], self.poses[-1].x, delta=TOLERANCE)
        self.assertAlmostEqual(CORNERS[-1][1], self.poses[-1].y, delta=TOLERANCE)

    def test_refuses_what_does_not_fit(self):
        """Exit code 1 with what would fit, before the turtle has moved at all."""
        program = self.start('drive_shape.py', '_size:=7')
        self.until_ended(program, code=1)
        for text in ('[FATAL]', 'a square of size 7 m', 'corner 1 (12.54, 5.54)', 'largest possible size is 5.54 m'):
            self.assertIn(text, program.output())
        self.assertEqual([], self.commands)


if __name__ == '__main__':
    run(LessonSquare)
