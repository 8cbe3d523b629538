#!/usr/bin/env python3
"""Lesson 3, the first challenge: drive a turtle, watch its pose, and stop at x = 10."""
import math
import sys

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

from turtle_robotont.params import check_params, number, ros_name

GAIN = 4.0     # speed for each metre, or radian, that is left [1/s]
NEAR = 0.005   # close enough [m]
ALIGNED = 0.05  # faces the right direction [rad]
pose = None    # the newest pose


def store_pose(message):
    global pose
    pose = message


def limited(value, limit):
    return max(-limit, min(limit, value))


def main():
    global pose
    rospy.init_node('stop_at_x')
    check_params(x=number(0.0, 11.0889, 'm'), speed=number(0.05, 10.0, 'm/s'), turn_speed=number(0.1, 10.0, 'rad/s'),
                 turtle=ros_name('turtle1'))
    x = rospy.get_param('~x', 10.0)                   # where to stop [m]
    speed = rospy.get_param('~speed', 1.0)            # at most [m/s]
    turn_speed = rospy.get_param('~turn_speed', 5.0)  # at most [rad/s]
    turtle = rospy.get_param('~turtle', 'turtle1')

    publisher = rospy.Publisher(f'{turtle}/cmd_vel', Twist, queue_size=10)
    rospy.on_shutdown(lambda: publisher.publish(Twist()))  # all zeros: the turtle stops
    pose = rospy.wait_for_message(f'{turtle}/pose', Pose, timeout=10.0)
    rospy.Subscriber(f'{turtle}/pose', Pose, store_pose)
    rospy.loginfo('Driving from x = %.3f to x = %.3f m at %.2f m/s', pose.x, x, speed)

    rate = rospy.Rate(50)
    while abs(x - pose.x) > NEAR:
        if rospy.is_shutdown():   # Ctrl-C
            return
        direction = 0.0 if x > pose.x else math.pi     # to the right or to the left
        turn = math.remainder(direction - pose.theta, 2.0 * math.pi)  # the shorter way round, -pi to pi
        velocity = Twist()
        velocity.angular.z = limited(GAIN * turn, turn_speed)
        if abs(turn) < ALIGNED:
            velocity.linear.x = limited(GAIN * abs(x - pose.x), speed)
        publisher.publish(velocity)
        rate.sleep()
    publisher.publish(Twist())
    rospy.loginfo('Stopped at x = %.4f m, y = %.4f m: error %.4f m', pose.x, pose.y, abs(x - pose.x))


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
    except rospy.ROSException as error:
        rospy.logfatal('No pose: %s. Is the simulator running, and does the turtle exist? (rostopic list)', error)
        sys.exit(1)
