#!/usr/bin/env python3
"""Send the frame carrot1, which stays 2 m to the left of turtle1."""
import rospy
import tf


def main():
    """Send the frame ten times a second until Ctrl-C."""
    rospy.init_node('fixed_tf_broadcaster')
    broadcaster = tf.TransformBroadcaster()
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        place = (0.0, 2.0, 0.0)  # [m]
        broadcaster.sendTransform(place, (0.0, 0.0, 0.0, 1.0), rospy.Time.now(), 'carrot1', 'turtle1')
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
