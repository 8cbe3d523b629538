#!/usr/bin/env python3
"""teleport_tour.py puts the turtle to four positions, with a black path."""
from lesson_case import LessonCase, run


class LessonTeleportTour(LessonCase):

    def test_four_positions_in_black(self):
        """In their order, each by a jump; the path under the turtle is black."""
        self.until_ended(self.start('teleport_tour.py', '_pause:=0.3'))
        self.until(lambda: self.colours and self.colours[-1] == type(self.colours[-1])(0, 0, 0), 'a black path')
        jumps = [(round(b.x, 3), round(b.y, 3)) for a, b in zip(self.poses, self.poses[1:])
                 if abs(b.x - a.x) + abs(b.y - a.y) > 1.0]
        self.assertEqual([(2.0, 2.0), (9.0, 2.0), (9.0, 9.0), (2.0, 9.0)], jumps)


if __name__ == '__main__':
    run(LessonTeleportTour)
