#!/usr/bin/env python3
"""Send the frame carrot1, which goes around turtle1 at a distance of 10 m, once in 2 s."""
import math

import rospy
import tf


def main():
    """Send the frame ten times a second until Ctrl-C."""
    rospy.init_node('dynamic_tf_broadcaster')
    broadcaster = tf.TransformBroadcaster()
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        angle = math.pi * now.to_sec()  # [rad] half a round per second
        place = (10.0 * math.sin(angle), 10.0 * math.cos(angle), 0.0)  # [m]
        broadcaster.sendTransform(place, (0.0, 0.0, 0.0, 1.0), now, 'carrot1', 'turtle1')
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
