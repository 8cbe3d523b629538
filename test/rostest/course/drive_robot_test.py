#!/usr/bin/env python3
"""drive_shape.py _robot:=true and ar_maze.py, with a simulated robot in the loop: its path, and that it stops."""
import math

import rospy
from nav_msgs.msg import Odometry

from rostest_support.common import nightly, run, until
from rostest_support.course import STOP, off_side
from rostest_support.robot import RobotCase

CORNER_TOLERANCE = 0.02  # [m] on ideal odometry
HEADING_TOLERANCE = 0.03  # [rad]
SHAPE_DEADLINE = 90.0  # [s] a shape takes 5 to 15
START = (-2.0, 1.0, 0.5)
SIDE = 0.4  # [m]


def ahead_and_left(ahead, left):
    """Return the place that lies there as seen from START."""
    return (START[0] + ahead * math.cos(START[2]) - left * math.sin(START[2]),
            START[1] + ahead * math.sin(START[2]) + left * math.cos(START[2]))


class DriveRobotTest(RobotCase):

    def draw(self, *arguments):
        """Let a robot at START draw a shape; return its track [(x, y, theta)] after assertions for all shapes."""
        robot, velocities = self.robot(START), self.velocities()
        process = self.start('drive_shape.py', '_robot:=true', f'_size:={SIDE}', '_turn_speed:=2.0', *arguments)
        said = self.ended(process, deadline=SHAPE_DEADLINE)
        self.assertIn('Drawn in', said)
        until(robot.stands, 'a robot that stands')
        self.assertEqual(STOP, velocities.messages[-1])
        fastest = max(math.hypot(twist.linear.x, twist.linear.y) for twist in velocities.messages)
        self.assertLess(fastest, 0.5 + 1e-9)
        x, y, theta = robot.track[-1]
        self.assertLess(math.hypot(x - START[0], y - START[1]), CORNER_TOLERANCE)
        self.assertAlmostEqual(theta, START[2], delta=HEADING_TOLERANCE)
        return robot.track

    def assert_square(self, track):
        corners = [ahead_and_left(*place) for place in ((SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE), (0.0, 0.0))]
        for corner in corners:
            self.assertLess(min(math.dist(corner, pose[:2]) for pose in track), CORNER_TOLERANCE, corner)
        sides = list(zip([corners[-1], *corners], corners))
        for x, y, _ in track:
            self.assertLess(min(off_side(Place(x, y), a, b) for a, b in sides), CORNER_TOLERANCE)

    def test_drive_robot_square(self):
        """By turning: the robot looks into all four directions."""
        track = self.draw()
        self.assert_square(track)
        self.assertEqual({0, 1, 2, 3}, {round((theta - START[2]) / (math.pi / 2.0)) % 4 for _, _, theta in track})

    def test_drive_robot_odometry_stops(self):
        """No odometry any more: it stops the robot within a second, says so and ends with exit code 1."""
        robot, velocities = self.robot(START), self.velocities()
        process = self.start('drive_shape.py', '_robot:=true')
        until(lambda: velocities.messages and velocities.messages[-1].linear.x > 0.2, 'a robot told to drive')
        robot.silent = True
        said = self.ended(process, code=1, deadline=5.0)
        self.assertRegex(said, r'\[FATAL\].*no odometry on /odom for 0\.5 s; is the robot or its simulator running')
        until(lambda: velocities.messages[-1] == STOP, 'a last Twist of zeros')

    @nightly
    def test_drive_robot_stale_odometry(self):
        """Another node sends old odometry: it is ignored with one warning, and the square is driven."""
        stale = rospy.Publisher('odom', Odometry, queue_size=10)
        self.addCleanup(stale.unregister)
        message = Odometry()
        message.header.stamp, message.pose.pose.position.x = rospy.Time(1.0), 50.0
        message.pose.pose.orientation.w = 1.0
        robot = self.robot(START)
        process = self.start('drive_shape.py', '_robot:=true', '_strafe:=true')
        process.wait_for_output('Drawing: square')
        timer = rospy.Timer(rospy.Duration(0.05), lambda _: stale.publish(message))
        self.addCleanup(timer.shutdown)
        said = self.ended(process, deadline=SHAPE_DEADLINE)
        self.assertIn('Drawn in', said)
        self.assertLess(math.dist(robot.track[-1][:2], START[:2]), CORNER_TOLERANCE)
        self.assertRegex(said, r'/odom: the time 1\.000 s is not after .*ignored')

    def test_drive_robot_maze(self):
        """ar_maze.py: two markers, one behind the robot; near to each in their order, and exit code 0."""
        places = {7: (1.8, 0.3), 2: (-1.6, -0.5)}
        robot = self.robot(places=places)
        said = self.ended(self.start('ar_maze.py', '_markers:=[2,7]', '_search_speed:=2.0', '_turn_speed:=2.0'),
                          deadline=SHAPE_DEADLINE)
        self.assertRegex(said, r'Visited the markers 2 \((0\.9|1\.0)\d m\), 7 \((0\.9|1\.0)\d m\)')
        until(robot.stands, 'a robot that stands')
        near = [[number for number, (x, y, _) in enumerate(robot.track) if math.dist((x, y), places[marker]) < 1.08]
                for marker in (2, 7)]
        self.assertTrue(near[0] and near[1] and near[0][0] < near[1][0], 'first 2, then 7')

    @nightly
    def test_drive_robot_maze_without_marker(self):
        """ar_maze.py: a marker that is not there: exit code 1 and which one."""
        robot = self.robot(places={1: (9.0, 0.0)})
        said = self.ended(self.start('ar_maze.py', '_markers:=[4]', '_search_speed:=3.0', '_turn_speed:=3.0'), code=1)
        self.assertRegex(said, r'\[FATAL\].*marker 4 was not found in 2 turns')
        until(robot.stands, 'a robot that stands')


class Place:
    """A position [m]."""

    def __init__(self, x, y):
        self.x, self.y = x, y


if __name__ == '__main__':
    run(DriveRobotTest)
