#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist

rospy.init_node('robot_forward')
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
velocity = Twist()
# solution
velocity.linear.x = 0.2
rate = rospy.Rate(1)
while not rospy.is_shutdown():
    publisher.publish(velocity)
    rospy.loginfo('%.2f m/s forward', velocity.linear.x)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
# end of solution
