#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose


def log(pose):
    if pose.x < 6:
        rospy.logdebug('x = %.2f m', pose.x)
    elif pose.x < 8:
        rospy.loginfo('x = %.2f m', pose.x)
    elif pose.x < 10:
        rospy.logwarn_throttle(0.5, 'x = %.2f m: the wall is near', pose.x)
    else:
        rospy.logerr_throttle(0.5, 'x = %.2f m: stop!', pose.x)


def main():
    rospy.init_node('log_levels', log_level=rospy.DEBUG)
    publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
    rospy.Subscriber('/turtle1/pose', Pose, log)
    velocity = Twist()
    velocity.linear.x = 1.0
    rate = rospy.Rate(10)
    while not rospy.is_shutdown():
        publisher.publish(velocity)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
