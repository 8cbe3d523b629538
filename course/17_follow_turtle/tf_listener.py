#!/usr/bin/env python3
import math

import rospy
import tf
from geometry_msgs.msg import Twist


def main():
    rospy.init_node('tf_listener')
    publisher = rospy.Publisher('/turtle2/cmd_vel', Twist, queue_size=10)
    listener = tf.TransformListener()
    rate = rospy.Rate(10)
    while not rospy.is_shutdown():
        velocity = Twist()
        # solution
        try:
            (x, y, z), rotation = listener.lookupTransform('turtle2', 'turtle1', rospy.Time(0))
            velocity.linear.x = 0.5 * math.hypot(x, y)
            velocity.angular.z = 4.0 * math.atan2(y, x)
        except tf.Exception as error:
            rospy.loginfo_throttle(1, 'No transform yet: %s', error)
        # end of solution
        publisher.publish(velocity)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
