#!/usr/bin/env python3
# expected: failed: the time was over before the last goal
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


def do(goal):
    seq = [0, 1]
    while len(seq) < goal.order + 1:
        if srv.is_preempt_requested():
            srv.set_preempted()
            return
        seq.append(seq[-2] + seq[-1])
        fb = FibonacciFeedback()
        fb.sequence = seq
        srv.publish_feedback(fb)
        rospy.sleep(2)  # for two numbers a second, 0.5
    srv.set_succeeded(FibonacciResult(sequence=seq))


rospy.init_node('fib')
srv = actionlib.SimpleActionServer('/fibonacci', FibonacciAction, do, False)
srv.start()
rospy.spin()
