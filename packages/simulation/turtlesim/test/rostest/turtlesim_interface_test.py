#!/usr/bin/env python3
"""The simulator's topics and services as others find them: names, types, md5 sums, the first pose."""

import rospy
import rosservice
from sim_ros.msg import ClockStatus
from sim_ros.srv import SetRate
from std_srvs.srv import Trigger

from rostest_support.common import MIDDLE, Collected, SimulatorCase, proxy, run, until

TOPICS = {  # name: (type, md5 sum)
    '/turtle1/pose': ('turtlesim/Pose', '863b248d5016ca62ea2e895ae5265cf9'),
    '/turtle1/color_sensor': ('turtlesim/Color', '353891e354491c51aabe32df673fb446'),
}
SERVICES = {
    '/clear': ('std_srvs/Empty', 'd41d8cd98f00b204e9800998ecf8427e'),
    '/reset': ('std_srvs/Empty', 'd41d8cd98f00b204e9800998ecf8427e'),
    '/spawn': ('turtlesim/Spawn', '0b2d2e872a8e2887d5ed626f2bf2c561'),
    '/kill': ('turtlesim/Kill', 'c1f3d28f1b044c871e6eff2e9fc3c667'),
    '/turtle1/set_pen': ('turtlesim/SetPen', '9f452acce566bf0c0954594f69a8e41b'),
    '/turtle1/teleport_absolute': ('turtlesim/TeleportAbsolute', 'a130bc60ee6513855dc62ea83fcc5b20'),
    '/turtle1/teleport_relative': ('turtlesim/TeleportRelative', '9d5c2dcd348ac8f76ce2a4307bd63a13'),
    '/turtlesim/get_loggers': ('roscpp/GetLoggers', '32e97e85527d4678a8f9279894bb64b0'),
    '/turtlesim/set_logger_level': ('roscpp/SetLoggerLevel', '51da076440d78ca1684d36c868df61ea'),
    '/turtlesim/pause': ('std_srvs/Trigger', '937c9679a518e3a18d831e57125ea522'),
    '/turtlesim/resume': ('std_srvs/Trigger', '937c9679a518e3a18d831e57125ea522'),
    '/turtlesim/step': ('sim_ros/Step', 'de8674f0ac561dee8f656054462c0f11'),
    '/turtlesim/set_rate': ('sim_ros/SetRate', 'ff713bc82a0b54697232d420c256e891'),
    '/turtlesim/get_drawing': ('turtlesim/GetDrawing', '92e985596549eb5927fc523a67ab225a'),
    '/turtlesim/snapshot': ('std_srvs/Trigger', '937c9679a518e3a18d831e57125ea522'),
}


class InterfaceTest(SimulatorCase):

    def test_turtlesim_topic_types(self):
        """Types and md5 sums of a turtle's topics, as a subscriber gets them."""
        for topic, (kind, md5) in TOPICS.items():
            header = rospy.wait_for_message(topic, rospy.AnyMsg, 20.0)._connection_header
            self.assertEqual((kind, md5, '/turtlesim'), (header['type'], header['md5sum'], header['callerid']), topic)

    def test_turtlesim_service_types(self):
        """Types and md5 sums of the services."""
        for service, (kind, md5) in SERVICES.items():
            rospy.wait_for_service(service, 20.0)
            header = rosservice.get_service_headers(service, rosservice.get_service_uri(service))
            self.assertEqual((kind, md5), (header['type'], header['md5sum']), service)

    def test_turtlesim_first_pose(self):
        """turtle1 begins in the middle, at rest."""
        pose = self.pose()
        self.assert_pose(pose, MIDDLE, MIDDLE, 0.0, tolerance=0.0)
        self.assertEqual((0.0, 0.0), (pose.linear_velocity, pose.angular_velocity))

    def test_turtlesim_pose_rate(self):
        """By the wall clock, over half-second sections of four seconds."""
        self.assertAlmostEqual(62.5, self.poses().rate(250, span=31), delta=3.0)

    def test_turtlesim_clock_status(self):
        """Also without /clock, and when a step is due at the moment of the change."""
        self.addCleanup(lambda: set_rate(1.0))
        changes = [proxy(f'/turtlesim/{name}', kind) for name, kind in (('pause', Trigger), ('resume', Trigger))]
        set_rate = proxy('/turtlesim/set_rate', SetRate)
        status = Collected('/turtlesim/clock_status', ClockStatus)

        def follows(**fields):
            until(lambda: status.messages and all(getattr(status.messages[-1], name) == value
                                                  for name, value in fields.items()), fields)
        for number in range(5):
            for paused, change in zip((True, False), changes):
                change()
                follows(paused=paused)
            self.assertIn('other nodes use wall time', set_rate(0.5 + number).warning)
            follows(rate=0.5 + number)


if __name__ == '__main__':
    run(InterfaceTest)
