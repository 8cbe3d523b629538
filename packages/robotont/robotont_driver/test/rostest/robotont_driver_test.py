#!/usr/bin/env python3
"""The fake driver moves and stops; the other one has LEDs and a battery."""
import math

import rospy
import tf2_ros
from geometry_msgs.msg import Twist, Vector3
from nav_msgs.msg import Odometry
from robotont_msgs.msg import ColorRGB, LedModulePixel, LedModuleSegment, PowerSupply
from rosgraph_msgs.msg import Log

from rostest_support.common import DEADLINE, Collected, NodeLog, run, until
from rostest_support.robotont import RobotontCase, place, stands

STEP = 0.01  # [s] of the driver


class DriverTest(RobotontCase):

    def test_a_command_lasts_half_a_second(self):
        odometry = self.collected('odom', Odometry)
        start = place(odometry.messages[-1])
        self.driver()(0.4)
        moving = odometry.index(lambda message: not stands(message), 'a robot that moves')
        odometry.index(stands, 'a robot that stands', moving)
        self.assertAlmostEqual(0.4 * 0.5, place(odometry.messages[-1])[0] - start[0], delta=0.4 * STEP)

    def test_the_frames_of_the_robot_are_published(self):
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        self.addCleanup(listener.unregister)
        found = buffer.lookup_transform('odom', 'base_link', rospy.Time(), rospy.Duration(DEADLINE))
        self.assertAlmostEqual(0.013, found.transform.translation.z)

    def test_nonsense_is_refused(self):
        log = NodeLog('/fake_driver_node')
        self.driver()(math.nan)
        log.wait(Log.WARN, 'Ignored a message on /cmd_vel, and the robot stops: .*nan.*')

    def test_leds_get_their_colours(self):
        leds = Collected('/real/driver_node/leds', LedModuleSegment)
        publishers = [rospy.Publisher(f'/real/{name}', kind, queue_size=10, latch=True)
                      for name, kind in (('led_pixel', LedModulePixel), ('led_segment', LedModuleSegment))]
        red, blue = ColorRGB(255, 0, 0), ColorRGB(0, 0, 255)
        publishers[0].publish(3, red)
        publishers[1].publish(10, [blue, red])
        until(lambda: leds.messages and [index for index, colour in enumerate(leds.messages[-1].colors)
                                         if colour != ColorRGB()] == [3, 10, 11], 'three LEDs')
        log = NodeLog('/real/driver_node')
        publishers[0].publish(60, red)
        log.wait(Log.WARN, 'Ignored a message for the LEDs: there is no LED 60; the strip has the LEDs 0 to 59')

    def test_the_battery_is_published(self):
        publisher = rospy.Publisher('/real/cmd_vel', Twist, queue_size=1)
        power = Collected('/real/power_supply', PowerSupply)
        until(lambda: power.messages, 'the battery')
        idle = min(message.current for message in power.messages)

        def drawn():
            publisher.publish(Vector3(0.5, 0.0, 0.0), Vector3())
            return power.messages[-1].current > idle
        until(drawn, 'a larger current of a robot that drives')
        self.assertFalse(power.messages[-1].estop_pressed)


if __name__ == '__main__':
    run(DriverTest)
