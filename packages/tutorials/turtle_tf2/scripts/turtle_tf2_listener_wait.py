#!/usr/bin/env python3
"""Spawn a turtle, and drive it to turtle1: wait in tf2 for where that is now, up to 1 s."""
import math

import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from turtlesim.srv import Spawn


def main():
    """Drive until Ctrl-C."""
    rospy.init_node('turtle_tf2_listener_wait')
    turtle = rospy.get_param('turtle', 'turtle2')
    buffer = tf2_ros.Buffer()
    _listener = tf2_ros.TransformListener(buffer)  # fills the buffer as long as this variable exists
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
            transform = buffer.lookup_transform(turtle, 'turtle1', rospy.Time.now(), rospy.Duration(1.0))
        except tf2_ros.TransformException as error:
            rospy.logwarn_throttle(5.0, f'No transform from {turtle} to turtle1: {error}')
            rate.sleep()
            continue
        x = transform.transform.translation.x  # [m] ahead of the turtle
        y = transform.transform.translation.y  # [m] to its left
        command = Twist()
        command.linear.x = 0.5 * math.hypot(x, y)
        command.angular.z = 4.0 * math.atan2(y, x)
        publisher.publish(command)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
