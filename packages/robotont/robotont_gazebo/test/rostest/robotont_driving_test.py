#!/usr/bin/env python3
"""The simulated Robotont drives, stops, and refuses nonsense."""
import math

from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log

from rostest_support.common import NodeLog, run, until
from rostest_support.robotont import COMMAND_LASTS, RobotontCase, place, stands

STOPPED = r'No message on /cmd_vel for 0.5 s: the robot stops\. .*'


class DrivingTest(RobotontCase):

    def test_robotont_drives_for_half_a_second(self):
        """One command lasts half a second, to the step; the first time, the watchdog says so."""
        log = NodeLog('/robotont_gazebo')
        # an arc of v = (0.4, 0.2) m/s and w = 2 rad/s over 0.5 s, which is 1 rad: in the robot's first frame
        # x = (vx sin 1 - vy (1 - cos 1)) / w, y = (vy sin 1 + vx (1 - cos 1)) / w
        sin, cos = math.sin(1.0), 1.0 - math.cos(1.0)
        x, y = (0.4 * sin - 0.2 * cos) / 2.0, (0.2 * sin + 0.4 * cos) / 2.0
        self.assertEqual(0.5, COMMAND_LASTS)
        self.assert_at(self.drive_once(0.4, 0.2, 2.0), x, y, 1.0)
        self.assert_at(self.odometry(), x, y, 1.0)
        log.wait(Log.WARN, STOPPED)
        self.drive_once(0.0, 0.0, 2.0)
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


if __name__ == '__main__':
    run(DrivingTest)
