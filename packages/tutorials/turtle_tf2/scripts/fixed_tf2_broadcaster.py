#!/usr/bin/env python3
"""Send the frame carrot1, which stays 2 m to the left of turtle1."""
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped


def main():
    """Send the frame ten times a second until Ctrl-C."""
    rospy.init_node('fixed_tf2_broadcaster')
    broadcaster = tf2_ros.TransformBroadcaster()
    message = TransformStamped()
    message.header.frame_id = 'turtle1'
    message.child_frame_id = 'carrot1'
    message.transform.translation.y = 2.0  # [m]
    message.transform.rotation.w = 1.0  # not turned
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        message.header.stamp = rospy.Time.now()
        broadcaster.sendTransform(message)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
