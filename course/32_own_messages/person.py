#!/usr/bin/env python3
import rospy
from topic_demo.msg import Person
from topic_demo.srv import Greet, GreetResponse


def greet(request):
    return GreetResponse('Hello, ' + request.name + '!')


rospy.init_node('person')
publisher = rospy.Publisher('/person', Person, queue_size=10)
# solution
rospy.Service('/greet', Greet, greet)
person = Person()
person.name = 'Mari'
person.age = 21
person.height = 1.68
# end of solution
rate = rospy.Rate(2)
while not rospy.is_shutdown():
    # solution
    publisher.publish(person)
    rospy.loginfo('Published %s, %d years', person.name, person.age)
    # end of solution
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
