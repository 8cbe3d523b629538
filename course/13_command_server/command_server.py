#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import Twist
from std_srvs.srv import Trigger, TriggerResponse

driving = False


def start(request):
    global driving
    # solution
    driving = True
    return TriggerResponse(True, 'The turtle drives')
    # end of solution


rospy.init_node('command_server')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
rospy.Service('/turtle_command', Trigger, start)
velocity = Twist()
velocity.linear.x = 0.5
velocity.angular.z = 0.2
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    # solution
    if driving:
        publisher.publish(velocity)
    # end of solution
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
