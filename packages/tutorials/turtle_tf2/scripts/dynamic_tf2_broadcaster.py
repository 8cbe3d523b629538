#!/usr/bin/env python3
"""Send the frame carrot1, which goes around turtle1 at a distance of 10 m, once in 2 s."""
import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped


def main():
    """Send the frame ten times a second until Ctrl-C."""
    rospy.init_node('dynamic_tf2_broadcaster')
    broadcaster = tf2_ros.TransformBroadcaster()
    message = TransformStamped()
    message.header.frame_id = 'turtle1'
    message.child_frame_id = 'carrot1'
    message.transform.rotation.w = 1.0  # not turned
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        message.header.stamp = rospy.Time.now()
        angle = math.pi * message.header.stamp.to_sec()  # [rad] half a round per second
        message.transform.translation.x = 10.0 * math.sin(angle)  # [m]
        message.transform.translation.y = 10.0 * math.cos(angle)
        broadcaster.sendTransform(message)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
