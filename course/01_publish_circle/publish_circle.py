#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('publish_circle')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
velocity = Twist()
# solution
velocity.linear.x = 0.5
velocity.angular.z = 0.2
# end of solution
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    # solution
    publisher.publish(velocity)
    rospy.loginfo('%.1f m/s, %.1f rad/s', velocity.linear.x, velocity.angular.z)
    # end of solution
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
