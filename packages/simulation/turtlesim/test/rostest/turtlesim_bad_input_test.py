#!/usr/bin/env python3
"""Bad input is refused with an error that names the value and the range; turtles and picture do not change."""
import re
import time

import rospy
from geometry_msgs.msg import Twist, Vector3
from rosgraph_msgs.msg import Log

from rostest_support.common import MIDDLE, NodeLog, SimulatorCase, registered_names, run, until

NAN, INF = float('nan'), float('inf')
BAD = ((NAN, 'nan', 'finite'), (INF, 'inf', 'finite'), (-INF, '-inf', 'finite'), (1e30, '1e+30', '1e+06'),
       (-2e6, '-2e+06', '1e+06'))  # a value, its text in the error, the limit in the error
WARNING_PERIOD = 1.0  # [s] of the warning about velocities
COMMAND = '/turtle1/cmd_vel'
LONG = 'a' * 100000


class BadInputTest(SimulatorCase):

    def assert_says(self, text, *parts):
        for part in parts:
            self.assertIn(part, text)

    def refuses_numbers(self, name, good, *rest):
        """Put each bad value in each place of a service's good numbers; every call has to fail and change nothing."""
        before = self.state()
        for place in range(len(good)):
            for value, shown, allowed in BAD:
                values = [*good[:place], value, *good[place + 1:], *rest]
                self.assert_says(self.refused(name, *values), shown, allowed)
        self.assert_unchanged(before)
        self.call(name, *good, *rest)

    def test_turtlesim_bad_spawn(self):
        """Spawn with numbers that are not finite or absurd."""
        self.refuses_numbers('spawn', (1.0, 2.0, 3.0), 'anna')
        self.assertEqual({'turtle1', 'anna'}, self.turtles())
        self.refused('spawn', NAN, 0.0, 0.0, '')
        self.assertEqual('turtle2', self.call('spawn', 1.0, 1.0, 0.0, '').name, 'a refused call takes no number')

    def bad_twists(self):
        """Yield (Twist, field, how its text shows the value)."""
        for value, shown in ((NAN, 'nan'), (INF, 'inf'), (-INF, '-inf'), (1e300, '1e+300'), (-2e6, '-2e+06')):
            yield Twist(Vector3(value, 0.0, 0.0), Vector3()), 'linear.x', shown
            yield Twist(Vector3(0.0, value, 0.0), Vector3()), 'linear.y', shown
            yield Twist(Vector3(), Vector3(0.0, 0.0, value)), 'angular.z', shown

    def publisher(self):
        publisher = rospy.Publisher(COMMAND, Twist, queue_size=100)
        until(publisher.get_num_connections, 'a subscriber')
        return publisher

    def test_turtlesim_bad_velocity(self):
        """Each bad value alone: a warning that names topic, field, value and range; the turtle stays."""
        log, publisher = NodeLog('/turtlesim'), self.publisher()
        before = self.state()
        twists = list(self.bad_twists())
        for twist, field, shown in (twists[0], twists[4], twists[8], twists[9]):
            pattern = rf'.*{COMMAND}: .*{re.escape(f"{field} is {shown};")}.*(finite|1e\+06).*'
            until(lambda: self.warned(log, publisher, twist, pattern),  # noqa: B023
                  lambda: f'a warning {pattern!r}; there were {log.texts(Log.WARN)}')  # noqa: B023
        self.assert_unchanged(before)

    def warned(self, log, publisher, twist, pattern):
        """Publish a bad Twist once more; return whether there is a warning of it. Warnings come once a second."""
        publisher.publish(twist)
        return any(re.fullmatch(pattern, text) for text in log.texts(Log.WARN))

    def test_turtlesim_bad_velocity_while_driving(self):
        """Bad commands have no effect: the good one before them continues and ends at its time."""
        publisher, poses = self.publisher(), self.poses()
        publisher.publish(Twist(Vector3(1.0, 0.0, 0.0), Vector3()))
        first = poses.index(lambda pose: pose.linear_velocity == 1.0, 'a turtle that moves')
        for twist, _, _ in self.bad_twists():
            publisher.publish(twist)
        stopped = poses.index(lambda pose: not pose.linear_velocity, 'a turtle that stands', first)
        way = poses.messages[stopped].x - MIDDLE
        self.assertAlmostEqual(63 * 0.016, way, delta=0.017)  # one step
        self.assertEqual({1.0}, {pose.linear_velocity for pose in poses.messages[first:stopped]})
        self.assertEqual({0.0}, {pose.theta for pose in poses.messages})

    def test_turtlesim_bad_velocity_throttled(self):
        """Many bad commands give one warning a second."""
        log, publisher = NodeLog('/turtlesim'), self.publisher()
        start = time.monotonic()

        def flood():
            for twist, _, _ in self.bad_twists():
                publisher.publish(twist)
            return log.texts(Log.WARN)
        for _ in range(5):
            flood()
        publisher.publish(Twist(Vector3(1.0, 0.0, 0.0), Vector3()))
        until(lambda: self.pose().x > MIDDLE, 'a turtle that obeys the good command after the bad ones')
        until(flood, 'a warning')
        self.assertLessEqual(len(log.texts(Log.WARN)), 1 + (time.monotonic() - start) / WARNING_PERIOD)

    def test_turtlesim_bad_long_name(self):
        """Spawn with a very long name."""
        before = self.state()
        said = self.refused('spawn', 1.0, 1.0, 0.0, LONG)
        self.assert_says(said, str(len(LONG)), '200')
        self.assertLess(len(said), 1000)
        self.assertLess(len(self.refused('spawn', 1.0, 1.0, 0.0, ' ' + LONG)), 1000)
        self.assertLess(len(self.refused('kill', LONG)), 1000)
        self.assert_unchanged(before)
        self.call('spawn', 1.0, 1.0, 0.0, 'a' * 200)
        self.assert_pose(self.pose('a' * 200), 1.0, 1.0, 0.0)

    def test_turtlesim_bad_colliding_names(self):
        """Names of the simulator itself, and other spellings of a turtle's name."""
        before = self.state()
        for name in ('clear', 'reset', 'spawn', 'kill', 'turtlesim', '/clear', '/kill', '/turtlesim', '/turtle1'):
            self.assert_says(self.refused('spawn', 1.0, 1.0, 0.0, name), name.lstrip('/'), 'choose another')
        self.assert_unchanged(before)

    def test_turtlesim_other_spellings(self):
        """Turtles spelled with the namespace get in the way neither of numbering nor of reset."""
        self.call('spawn', 1.0, 1.0, 0.0, '/turtle2')
        self.assertEqual('turtle3', self.call('spawn', 1.0, 1.0, 0.0, '').name)
        self.call('kill', 'turtle1')
        self.call('spawn', 1.0, 1.0, 0.0, '/turtle1')
        self.call('reset')
        until(lambda: self.turtles() == {'turtle1'}, 'turtle1 alone')
        self.assert_pose(self.pose(), MIDDLE, MIDDLE, 0.0)
        self.call('turtle1/teleport_absolute', 2.0, 2.0, 0.0)
        self.assert_pose(self.pose(), 2.0, 2.0, 0.0)

    def refuses_background(self, service):
        log = NodeLog('/turtlesim')
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        self.call('turtle1/teleport_absolute', 3.0, 4.0, 0.0)
        before = self.state()
        for channel, value in (('r', 'red'), ('g', 256), ('b', -1), ('r', 1.5), ('g', True), ('b', [1]), ('g', ''),
                               ('r', {'a': 1}), ('b', 1e30)):
            name = f'/turtlesim/background_{channel}'
            good = rospy.get_param(name)
            rospy.set_param(name, value)
            self.assert_says(self.refused(service), name, repr(value), '0 to 255')
            rospy.set_param(name, good)
        self.assert_unchanged(before)
        log.wait(Log.ERROR, r'.*/turtlesim/background_r.*')
        self.call(service)

    def test_turtlesim_bad_background_clear(self):
        """clear with a background parameter of a wrong type or range."""
        self.refuses_background('clear')

    def test_turtlesim_bad_background_reset(self):
        """reset with a background parameter of a wrong type or range: the turtles stay."""
        self.refuses_background('reset')

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
