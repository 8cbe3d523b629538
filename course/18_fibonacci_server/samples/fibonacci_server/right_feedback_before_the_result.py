#!/usr/bin/env python3
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


class FibonacciServer:
    def __init__(self, name):
        self.server = actionlib.SimpleActionServer(name, FibonacciAction, execute_cb=self.execute, auto_start=False)
        self.server.start()

    def execute(self, goal):
        rate = rospy.Rate(2)
        feedback = FibonacciFeedback()
        feedback.sequence = [0, 1]
        for i in range(1, goal.order):
            rate.sleep()
            if self.server.is_preempt_requested():
                self.server.set_preempted()
                return
            feedback.sequence.append(feedback.sequence[i] + feedback.sequence[i - 1])
            self.server.publish_feedback(feedback)
        self.server.set_succeeded(FibonacciResult(feedback.sequence))


rospy.init_node('fibonacci_server')
FibonacciServer('/fibonacci')
rospy.spin()
