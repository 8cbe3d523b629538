#!/usr/bin/env python3
# expected: failed: its type is std_msgs/String
import rospy
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node('person')
publisher = rospy.Publisher('/person', String, queue_size=10)
rospy.Service('/greet', Trigger, lambda request: TriggerResponse(True, 'Hello!'))
rate = rospy.Rate(2)
while not rospy.is_shutdown():
    publisher.publish('Mari, 21, 1.68')
    rospy.loginfo('Published Mari')
    rate.sleep()
