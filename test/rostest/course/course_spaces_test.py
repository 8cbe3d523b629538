#!/usr/bin/env python3
"""The course's nodes in namespaces: two simulators, each with nodes of its own, and none touches the other's turtle."""

import rospy
from turtle_robotont.msg import DriveStatus
from turtle_robotont.srv import DriveTo

from rostest_support.common import DEADLINE, MIDDLE, Collected, proxy, run, until
from rostest_support.course import CourseCase

NODES = [('stop_at_x.py', ('_speed:=4.0',)), ('set_pen.py', ()), ('teleport_tour.py', ('_pause:=0.1',))]


class Left(CourseCase):
    simulator, space = '/left/turtlesim', '/left/'


class Right(CourseCase):
    simulator, space = '/right/turtlesim', '/right/'


class SpacesTest(CourseCase):
    simulator = None

    def setUp(self):
        self.left, self.right = Left(), Right()
        for side in (self.left, self.right):
            side.setUp()
            self.addCleanup(side.doCleanups)

    def test_course_two_simulators(self):
        """A server in each namespace drives its own turtle, both at the same time."""
        status = Collected('/right/turtle1/drive_status', DriveStatus)
        goals = {self.left: (8.0, 7.0, 1.0), self.right: (3.0, 4.0, -1.0)}
        for side in goals:
            rospy.wait_for_service(f'{side.space}turtle1/drive_to', DEADLINE)
        before = self.left.pose()
        proxy('/right/turtle1/drive_to', DriveTo)(*goals[self.right], True, 0.0, 0.0)
        self.assert_at(self.right.pose(), *goals[self.right])
        self.assertEqual(before, self.left.pose(), 'the left turtle stays')
        until(lambda: status.messages and status.messages[-1].state == DriveStatus.ARRIVED, 'the status of the right')
        seen = len(status.messages)
        answer = proxy('/left/turtle1/drive_to', DriveTo)(*goals[self.left], True, 4.0, 0.0)
        self.assertTrue(answer.arrived, answer)
        self.assert_at(self.left.pose(), *goals[self.left])
        self.assert_at(self.right.pose(), *goals[self.right])
        self.assertEqual(seen, len(status.messages), 'the right server told of the left drive')

    def test_course_nodes_by_ns(self):
        """__ns:= on the command line, node after node."""
        before = self.left.pose()
        for script, arguments in NODES:
            with self.subTest(script=script):
                self.ended(self.start(script, '__ns:=right', *arguments))
        self.assert_at(self.right.pose(), 2.0, 9.0)
        self.assertEqual(before, self.left.pose(), 'the left turtle stays')

    def test_course_turtle_in_a_namespace(self):
        """~turtle may be a path to a turtle in another namespace."""
        before = self.left.pose()
        self.ended(self.start('stop_at_x.py', '_turtle:=right/turtle1', '_speed:=4.0', '_x:=7.0'))
        self.assert_at(self.right.pose(), 7.0, MIDDLE)
        self.assertEqual(before, self.left.pose(), 'the left turtle stays')


if __name__ == '__main__':
    run(SpacesTest)
