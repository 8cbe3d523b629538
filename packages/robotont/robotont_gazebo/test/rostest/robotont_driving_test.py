#!/usr/bin/env python3
"""The simulated Robotont drives, stops, is moved to another pose, and refuses nonsense."""
import math

from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan

from rostest_support.common import NodeLog, run, until
from rostest_support.robotont import COMMAND_LASTS, LENGTH_TOLERANCE, RADIUS, RobotontCase, place, stands

STOPPED = r'No message on /cmd_vel for 0.5 s: the robot stops\. .*'


class DrivingTest(RobotontCase):

    def test_robotont_drives_for_half_a_second(self):
        """One command lasts half a second, to the step."""
        # an arc of v = (0.4, 0.2) m/s and w = 2 rad/s over 0.5 s, which is 1 rad: in the robot's first frame
        # x = (vx sin 1 - vy (1 - cos 1)) / w, y = (vy sin 1 + vx (1 - cos 1)) / w
        sin, cos = math.sin(1.0), 1.0 - math.cos(1.0)
        x, y = (0.4 * sin - 0.2 * cos) / 2.0, (0.2 * sin + 0.4 * cos) / 2.0
        self.assertEqual(0.5, COMMAND_LASTS)
        self.assert_at(self.drive_once(0.4, 0.2, 2.0), x, y, 1.0)
        self.assert_at(self.odometry(), x, y, 1.0)

    def test_robotont_says_once_that_it_stops(self):
        """The watchdog stops the robot each time and says so the first time."""
        log = NodeLog('/robotont_gazebo')
        first = self.drive_once(0.4)
        log.wait(Log.WARN, STOPPED)
        second = self.drive_once(0.4)
        self.assertAlmostEqual(2.0 * first[0], second[0], delta=LENGTH_TOLERANCE)
        self.assertEqual(1, len(log.texts(Log.WARN)), log.texts(Log.WARN))

    def test_robotont_ignores_nonsense_and_stands(self):
        """NaN, infinite and enormous commands stop the robot; each is named."""
        log, drive = NodeLog('/robotont_gazebo'), self.driver()
        truth = self.collected('~ground_truth', Odometry)
        for bad, said in (((math.nan, 0.0, 0.0), 'linear.x is nan; it must be a finite number'),
                          ((0.0, math.inf, 0.0), 'linear.y is inf; it must be a finite number'),
                          ((0.0, 0.0, 1e9), 'angular.z is 1e+09 rad/s; it must be -50 to 50'),
                          ((30.0, 40.0, 0.0), 'linear is 50 m/s; it must be at most 10')):
            self.drive_until(lambda: not stands(truth.messages[-1]), 'a robot that moves', 0.1, 0.0, 0.3)

            def refused(bad=bad, said=said):
                drive(*bad)
                return [text for text in log.texts(Log.WARN) if text.endswith(said)]
            (text,) = until(refused, said)[:1]
            self.assertTrue(text.startswith('Ignored a message on /cmd_vel, and the robot stops: '), text)
            truth.next(stands, 'a robot that stands')
            self.assertTrue(all(map(math.isfinite, place(truth.messages[-1]))))

    def test_robotont_is_put_elsewhere(self):
        self.drive_until(lambda: self.truth()[0] > -1.9, 'a robot that drives', 0.3)
        self.set_pose(2.0, -1.0, 4.0)
        for where in (self.truth(), self.odometry()):
            self.assert_at(where, 2.0, -1.0, 4.0)
        for values, said in (((1.0, 0.0, 0.0), 'the robot cannot be at x=1, y=0: wall6 is closer than the radius'),
                             ((math.nan, 0.0, 0.0), 'the pose: x is nan; it must be a finite number'),
                             ((0.0, 0.0, 1e7), r'the pose: yaw is 1e\+07; it must be')):
            self.assertRegex(self.refused(self.set_pose, *values), said)
        self.assert_at(self.truth(), 2.0, -1.0, 4.0)
        # over the threshold of the door at x = 2.994 into the open
        self.set_pose(2.5, 2.0, 0.0)
        self.drive_until(lambda: self.truth()[0] > 3.5, 'a robot outside', 2.0)

    def test_robotont_markers_move(self):
        self.assertEqual((-2.0, 2.9), (self.panel('marker1')['x'], self.panel('marker1')['y']))
        scans = self.collected('scan', LaserScan)
        self.move_marker('marker1', -1.4, 0.0, 0.0)
        self.assertEqual((-1.4, 0.0, 0.0), tuple(self.panel('marker1')[key] for key in ('x', 'y', 'yaw')))
        # the scanner is at -2.01; straight ahead are the rays in the middle
        scans.next(lambda scan: abs(scan.ranges[359] - 0.61) < 0.06, 'a scan with the panel ahead')
        for values, said in ((('marker1', -2.1, 0.0, 0.0), "the panel 'marker1' cannot be at x=-2.1, y=0: the robot"),
                             (('marker9', 0.0, 0.0, 0.0), 'the panels are: marker1, marker2, marker3, marker4'),
                             (('marker1', math.inf, 0.0, 0.0), 'x is inf')):
            self.assertRegex(self.refused(self.move_marker, *values), said)
        self.assertEqual(-1.4, self.panel('marker1')['x'])
        odometry = self.collected('odom', Odometry)
        self.drive_until(lambda: abs(place(odometry.messages[-1])[0] - (-1.4 - RADIUS)) < LENGTH_TOLERANCE,
                         'a stop at the panel', 1.0)


if __name__ == '__main__':
    run(DrivingTest)
