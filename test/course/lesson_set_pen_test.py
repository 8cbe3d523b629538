#!/usr/bin/env python3
"""set_pen.py changes the colour of the path."""
from turtlesim.srv import TeleportRelative

from lesson_case import LessonCase, rospy, run


class LessonSetPen(LessonCase):

    def test_colour_under_the_turtle(self):
        """The colour sensor sees the path that is drawn next."""
        self.until_ended(self.start('set_pen.py', '_r:=10', '_g:=200', '_b:=30', '_width:=9'))
        rospy.ServiceProxy('turtle1/teleport_relative', TeleportRelative)(2.0, 0.0)
        self.until(lambda: self.colours and (self.colours[-1].r, self.colours[-1].g, self.colours[-1].b)
                   == (10, 200, 30), lambda: f'the colour of the path; it is {self.colours[-1:]}')


if __name__ == '__main__':
    run(LessonSetPen)
