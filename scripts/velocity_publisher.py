#!/usr/bin/env python3
"""Lesson 1, a publisher: a turtle drives in a circle, because this node publishes a velocity ten times a second."""
import rospy
from geometry_msgs.msg import Twist

from turtle_robotont.params import check_params, number


def main():
    rospy.init_node('velocity_publisher', anonymous=True)
    check_params(linear=number(unit='m/s'), angular=number(unit='rad/s'), rate=number(0.1, 1000.0, 'Hz'))
    velocity = Twist()
    velocity.linear.x = rospy.get_param('~linear', 0.5)    # forward [m/s]
    velocity.angular.z = rospy.get_param('~angular', 0.2)  # to the left [rad/s]
    rate = rospy.Rate(rospy.get_param('~rate', 10.0))      # [Hz]

    publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=10)
    rospy.on_shutdown(lambda: publisher.publish(Twist()))  # all zeros: the turtle stops
    while not rospy.is_shutdown():
        publisher.publish(velocity)
        rospy.loginfo('Publish turtle velocity command[%0.2f m/s, %0.2f rad/s]', velocity.linear.x, velocity.angular.z)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
