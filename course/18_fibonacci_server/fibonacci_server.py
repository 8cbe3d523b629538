#!/usr/bin/env python3
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


def execute(goal):
    sequence = [0, 1]
    rate = rospy.Rate(2)
    # solution
    while len(sequence) <= goal.order:
        if server.is_preempt_requested():
            server.set_preempted(FibonacciResult(sequence))
            return
        sequence.append(sequence[-1] + sequence[-2])
        server.publish_feedback(FibonacciFeedback(sequence))
        rate.sleep()
    server.set_succeeded(FibonacciResult(sequence))
    # end of solution


rospy.init_node('fibonacci_server')
server = actionlib.SimpleActionServer('/fibonacci', FibonacciAction, execute, False)
server.start()
rospy.spin()
