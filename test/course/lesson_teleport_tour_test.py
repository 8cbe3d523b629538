#!/usr/bin/env python3
"""teleport_tour.py puts the turtle to four positions, with a black path."""
from turtlesim.msg import Color, Pose

from lesson_case import LessonCase, run


class LessonTeleportTour(LessonCase):

    def test_four_positions_in_black(self):
        """In their order, each by a jump; the path under the turtle is black."""
        self.until_ended(self.start('teleport_tour.py', '_pause:=0.3'))
        self.until(lambda: self.colours and self.colours[-1] == Color(0, 0, 0), 'a black path')
        self.assertEqual([(2.0, 2.0), (9.0, 2.0), (9.0, 9.0), (2.0, 9.0)], self.jumps(self.poses))

    def test_parameters(self):
        """~turtle, ~positions, ~color and ~width."""
        self.spawn('anna')
        poses, colours = self.record('anna/pose', Pose), self.record('anna/color_sensor', Color)
        self.until(lambda: poses, 'anna')
        self.until_ended(self.start('teleport_tour.py', '_turtle:=anna', '_pause:=0.1', '_color:=[9,8,7]', '_width:=9',
                                    '_positions:=[[5,3],[5,5]]'))
        self.until(lambda: len(self.jumps(poses)) == 2 and colours[-1] == Color(9, 8, 7), lambda: f'{poses}, {colours}')
        self.assertEqual([(5.0, 3.0), (5.0, 5.0)], self.jumps(poses))
        self.assertEqual([], self.jumps(self.poses), 'turtle1 stays')

    @staticmethod
    def jumps(poses):
        """Return the positions to which a turtle jumped."""
        return [(round(b.x, 3), round(b.y, 3)) for a, b in zip(poses, poses[1:])
                if abs(b.x - a.x) + abs(b.y - a.y) > 1.0]


if __name__ == '__main__':
    run(LessonTeleportTour)
