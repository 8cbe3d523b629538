#!/usr/bin/env python3
"""Bad input is refused with an error that names the value and the range; turtles and picture do not change."""
import math
import time

import rospy
from geometry_msgs.msg import Twist, Vector3
from rosgraph_msgs.msg import Log

from rostest_support.common import MIDDLE, NodeLog, SimulatorCase, registered_names, run, until

WARNING_PERIOD = 1.0  # [s] of the warning about velocities
COMMAND = '/turtle1/cmd_vel'


class BadInputTest(SimulatorCase):

    def bad_twists(self):
        for value in (math.nan, math.inf, -math.inf, 1e300, -2e6):
            yield from (Twist(Vector3(value, 0.0, 0.0), Vector3()), Twist(Vector3(0.0, value, 0.0), Vector3()),
                        Twist(Vector3(), Vector3(0.0, 0.0, value)))

    def publisher(self):
        publisher = rospy.Publisher(COMMAND, Twist, queue_size=100)
        until(publisher.get_num_connections, 'a subscriber')
        return publisher

    def test_turtlesim_bad_velocity_while_driving(self):
        """Bad commands have no effect: the good one before them continues and ends at its time."""
        publisher, poses = self.publisher(), self.poses()
        publisher.publish(Twist(Vector3(1.0, 0.0, 0.0), Vector3()))
        first = poses.index(lambda pose: pose.linear_velocity == 1.0, 'a turtle that moves')
        for twist in self.bad_twists():
            publisher.publish(twist)
        stopped = poses.index(lambda pose: not pose.linear_velocity, 'a turtle that stands', first)
        way = poses.messages[stopped].x - MIDDLE
        self.assertAlmostEqual(63 * 0.016, way, delta=0.017)  # one step
        self.assertEqual({1.0}, {pose.linear_velocity for pose in poses.messages[first:stopped]})
        self.assertEqual({0.0}, {pose.theta for pose in poses.messages})

    def test_turtlesim_bad_velocity_throttled(self):
        """Many bad commands give one warning a second, which names topic, field, value and range."""
        log, publisher = NodeLog('/turtlesim'), self.publisher()
        start = time.monotonic()

        def flood():
            for twist in self.bad_twists():
                publisher.publish(twist)
            return log.texts(Log.WARN)
        for _ in range(5):
            flood()
        publisher.publish(Twist(Vector3(1.0, 0.0, 0.0), Vector3()))
        until(lambda: self.pose().x > MIDDLE, 'a turtle that obeys the good command after the bad ones')
        first = until(flood, 'a warning')[0]
        self.assertRegex(first, rf'{COMMAND}: .*(linear\.[xy]|angular\.z) is .*; .*(finite|1e\+06)')
        self.assertLessEqual(len(log.texts(Log.WARN)), 1 + (time.monotonic() - start) / WARNING_PERIOD)

    def test_turtlesim_other_spellings(self):
        """Turtles spelled with the namespace get in the way neither of numbering nor of reset."""
        self.assertIn('choose another', self.refused('spawn', 1.0, 1.0, 0.0, '/kill'))
        self.call('spawn', 1.0, 1.0, 0.0, '/turtle2')
        self.assertEqual('turtle3', self.call('spawn', 1.0, 1.0, 0.0, '').name)
        self.call('kill', 'turtle1')
        self.call('spawn', 1.0, 1.0, 0.0, '/turtle1')
        self.call('reset')
        until(lambda: self.turtles() == {'turtle1'}, 'turtle1 alone')
        self.assert_pose(self.pose(), MIDDLE, MIDDLE, 0.0)
        self.call('turtle1/teleport_absolute', 2.0, 2.0, 0.0)
        self.assert_pose(self.pose(), 2.0, 2.0, 0.0)

    def test_turtlesim_bad_background(self):
        """A background parameter of a wrong type or range: clear and reset fail, and the turtles stay."""
        log = NodeLog('/turtlesim')
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        self.call('turtle1/teleport_absolute', 3.0, 4.0, 0.0)
        before = self.state()
        for service, channel, value in (('clear', 'r', 'red'), ('reset', 'g', 256)):
            name = f'/turtlesim/background_{channel}'
            good = rospy.get_param(name)
            rospy.set_param(name, value)
            self.assertRegex(self.refused(service), f'{name} is {value!r}; .*0 to 255')
            rospy.set_param(name, good)
        self.assert_unchanged(before)
        log.wait(Log.ERROR, r'.*/turtlesim/background_r.*')
        self.call('clear')

    def test_turtlesim_background_deleted(self):
        """Deleted background parameters mean the defaults."""
        for channel in 'rgb':
            name = f'/turtlesim/background_{channel}'
            self.addCleanup(rospy.set_param, name, rospy.get_param(name))
            rospy.delete_param(name)
        self.call('clear')
        self.assertEqual((69, 86, 255), self.color())
        self.assertTrue(registered_names('/turtlesim')[2])


if __name__ == '__main__':
    run(BadInputTest)
