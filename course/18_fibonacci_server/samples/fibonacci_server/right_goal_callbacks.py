#!/usr/bin/env python3
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


class FibonacciServer:
    def __init__(self, name):
        self.left = 0
        self.sequence = []
        self.server = actionlib.SimpleActionServer(name, FibonacciAction, auto_start=False)
        self.server.register_goal_callback(self.on_goal)
        self.server.register_preempt_callback(self.on_preempt)
        self.server.start()
        rospy.Timer(rospy.Duration(0.5), self.compute)

    def on_goal(self):
        self.left = self.server.accept_new_goal().order - 1
        self.sequence = [0, 1]

    def on_preempt(self):
        self.server.set_preempted(FibonacciResult(self.sequence))

    def compute(self, event):
        if not self.server.is_active():
            return
        self.sequence.append(self.sequence[-1] + self.sequence[-2])
        self.left -= 1
        self.server.publish_feedback(FibonacciFeedback(self.sequence))
        if self.left == 0:
            self.server.set_succeeded(FibonacciResult(self.sequence))


rospy.init_node('fibonacci_server')
FibonacciServer('/fibonacci')
rospy.spin()
