#!/usr/bin/env python3
# expected: failed: the cancelled goal is PREEMPTING
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


def execute(goal):
    sequence = [0, 1]
    rate = rospy.Rate(2)
    while len(sequence) <= goal.order:
        sequence.append(sequence[-1] + sequence[-2])
        server.publish_feedback(FibonacciFeedback(sequence))
        rate.sleep()
    server.set_succeeded(FibonacciResult(sequence))


rospy.init_node('fibonacci_server')
server = actionlib.SimpleActionServer('/fibonacci', FibonacciAction, execute, False)
server.start()
rospy.spin()
