#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Empty

rospy.init_node('find_robot')
rospy.wait_for_service('/global_localization')
search = rospy.ServiceProxy('/global_localization', Empty)
publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
velocity = Twist()
velocity.angular.z = 0.8
rate = rospy.Rate(10)
count = 0
while not rospy.is_shutdown():
    # solution
    if count % 420 == 0:
        search()
    publisher.publish(velocity)
    count += 1
    # end of solution
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
