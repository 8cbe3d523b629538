#!/usr/bin/env python3
"""set_pen.py and teleport_tour.py: the lines that they leave, seen by the turtle's own colour sensor."""

from rostest_support.common import BACKGROUND, FLOAT32_TOLERANCE, PEN, PIXELS_PER_METRE, run, until
from rostest_support.course import CourseCase

PIXEL = 1.0 / PIXELS_PER_METRE  # [m]


class PenTest(CourseCase):

    def color_at(self, x, y):
        """Return the colour at a position; the turtle is there afterwards, its pen up."""
        self.call('turtle1/set_pen', 0, 0, 0, 0, 1)
        self.call('turtle1/teleport_absolute', x, y, 0.0)
        until(lambda: abs(self.pose().x - x) < FLOAT32_TOLERANCE, 'the turtle there')
        return self.color()

    def test_set_pen_default(self):
        """Blue, 5 px wide: 2 px to each side."""
        self.call('turtle1/set_pen', *PEN, 1, 1)
        self.call('turtle1/teleport_absolute', 4.0, 4.0, 0.0)
        self.ended(self.start('set_pen.py'))
        self.call('turtle1/teleport_relative', 2.0, 0.0)
        self.assertEqual(((0, 0, 255), BACKGROUND), (self.color_at(5.0, 4.0), self.color_at(5.0, 4.0 + 3 * PIXEL)))


class TourTest(PenTest):

    def jumps(self, poses):
        """Return the positions that a turtle was at, one after the other."""
        places = [(round(pose.x, 5), round(pose.y, 5)) for pose in poses]
        return [place for before, place in zip([None, *places], places) if place != before]

    def test_teleport_tour_parameters(self):
        """~positions, ~color, ~width and ~turtle."""
        self.call('spawn', 3.0, 3.0, 0.0, 'anna')
        first, poses = self.pose(), self.poses('anna')
        self.ended(self.start('teleport_tour.py', '_turtle:=anna', '_pause:=0.1', '_color:=[9,8,7]', '_width:=9',
                              '_positions:=[[5,3],[5,4]]'))
        self.assertEqual([(3.0, 3.0), (5.0, 3.0), (5.0, 4.0)], self.jumps(poses.messages))
        self.assertEqual(first, self.pose(), 'turtle1 stays')
        for pixels, colour in ((0, (9, 8, 7)), (3, (9, 8, 7)), (7, BACKGROUND)):
            self.assertEqual(colour, self.color_at(4.0, 3.0 - pixels * PIXEL), pixels)


if __name__ == '__main__':
    run(PenTest, TourTest)
