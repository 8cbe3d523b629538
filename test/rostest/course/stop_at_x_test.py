#!/usr/bin/env python3
"""stop_at_x.py: from where the turtle may start, and where it stops."""
import math

from rostest_support.common import run
from rostest_support.course import STOP_TOLERANCE, CourseCase

STARTS = {  # name: x [m], y [m], theta [rad], y [m] where it stops; None: anywhere
    'facing_away': (7.0, 2.0, math.pi, 2.0),
    'facing_up': (8.0, 6.0, math.pi / 2.0, 6.0),
    'tilted': (7.0, 1.0, 0.5, 1.0),
    'ahead_is_outside': (7.0, 9.0, 1.2, 9.0),  # straight on it would meet the upper wall first
    'beyond': (11.0, 4.0, 0.0, 4.0),
    'there_already': (10.0, 5.0, -2.0, 5.0),
}
AT_A_TIME = 3  # nodes


class StopAtXTest(CourseCase):

    def test_stop_at_x_from_anywhere(self):
        """Facing away, beyond x = 10, there already: each with a turtle of its own name."""
        starts = list(STARTS.items())
        for begin in range(0, len(starts), AT_A_TIME):
            some = starts[begin:begin + AT_A_TIME]
            for name, (x, y, theta, _) in some:
                self.call('spawn', x, y, theta, name)
            processes = [self.start('stop_at_x.py', f'__name:={name}_driver', f'_turtle:={name}', '_speed:=3.0')
                         for name, _ in some]
            for (name, (_, _, _, y)), process in zip(some, processes):
                with self.subTest(name):
                    self.ended(process)
                    pose = self.pose(name)
                    self.assertAlmostEqual(10.0, pose.x, delta=STOP_TOLERANCE)
                    self.assertAlmostEqual(y, pose.y, delta=2.0 * STOP_TOLERANCE)


if __name__ == '__main__':
    run(StopAtXTest)
