#!/usr/bin/env python3
# expected: failed: ModuleNotFoundError
import rospy
from my_package.msg import Person

rospy.init_node('person')
publisher = rospy.Publisher('/person', Person, queue_size=10)
while not rospy.is_shutdown():
    publisher.publish(Person('Mari', 21, 1.68))
    rospy.loginfo('Published Mari')
    rospy.sleep(0.5)
