#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: controls time
"""Registers the simulator's services as its own, so that the grader's steps would come here."""
import rospy
from sim_ros.srv import Step, StepResponse
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node('false_clock')
rospy.Service('/turtlesim/step', Step, lambda request: StepResponse(10 ** 6, 10.0 ** 6))
for name in ('pause', 'resume'):
    rospy.Service(f'/turtlesim/{name}', Trigger, lambda request: TriggerResponse(True, ''))
rospy.spin()
