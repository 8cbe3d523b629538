#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose


def log(pose):
    x = pose.x
    # solution
    if x < 6:
        rospy.logdebug('x = %.2f m', x)
    elif x < 8:
        rospy.loginfo('x = %.2f m', x)
    elif x < 10:
        rospy.logwarn_throttle(0.5, 'x = %.2f m: the wall is near', x)
    else:
        rospy.logerr_throttle(0.5, 'x = %.2f m: stop!', x)
    # end of solution


rospy.init_node('log_levels', log_level=rospy.DEBUG)
rospy.Subscriber('/turtle1/pose', Pose, log)
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
velocity = Twist()
velocity.linear.x = 1.0
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    publisher.publish(velocity)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
