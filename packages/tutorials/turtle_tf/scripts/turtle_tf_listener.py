#!/usr/bin/env python3
"""Spawn a turtle, look up in tf where turtle1 is as that turtle sees it, and drive there."""
import math

import rospy
import tf
from geometry_msgs.msg import Twist
from turtlesim.srv import Spawn


def main():
    """Drive until Ctrl-C."""
    rospy.init_node('turtle_tf_listener')
    turtle = rospy.get_param('turtle', 'turtle2')
    listener = tf.TransformListener()
    rospy.wait_for_service('spawn')
    try:
        rospy.ServiceProxy('spawn', Spawn)(4.0, 2.0, 0.0, turtle)
    except rospy.ServiceException as error:
        rospy.logwarn('%s: the one that is there follows', error)
    publisher = rospy.Publisher(f'{turtle}/cmd_vel', Twist, queue_size=1)
    rospy.on_shutdown(lambda: publisher.publish(Twist()))  # stop
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        try:
            (x, y, _), _ = listener.lookupTransform(turtle, 'turtle1', rospy.Time())  # the latest
        except tf.Exception as error:
            rospy.logwarn_throttle(5.0, f'No transform from {turtle} to turtle1: {error}')
            rate.sleep()
            continue
        command = Twist()
        command.linear.x = 0.5 * math.hypot(x, y)  # x [m] ahead of the turtle, y [m] to its left
        command.angular.z = 4.0 * math.atan2(y, x)
        publisher.publish(command)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
