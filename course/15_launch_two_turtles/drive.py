#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist


def main():
    rospy.init_node('drive')
    publisher = rospy.Publisher('cmd_vel', Twist, queue_size=10)
    velocity = Twist()
    # solution
    velocity.linear.x = rospy.get_param('~linear', 1.0)
    velocity.angular.z = rospy.get_param('~angular', 0.0)
    # end of solution
    rate = rospy.Rate(10)
    while not rospy.is_shutdown():
        publisher.publish(velocity)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass
