#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('robot_turning')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
velocity = Twist()
# solution
velocity.linear.x = 0.2
velocity.angular.z = 0.5
rospy.loginfo('A circle with a radius of %.2f m', velocity.linear.x / velocity.angular.z)
rate = rospy.Rate(1)
while not rospy.is_shutdown():
    publisher.publish(velocity)
    rospy.loginfo('%.2f m/s forward, %.2f rad/s to the left', velocity.linear.x, velocity.angular.z)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
# end of solution
