#!/usr/bin/env python3
"""As on a busy machine: its publisher takes a client some time after the client has seen the connection."""
import time

import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult
from rospy.topics import _PublisherImpl

add_connection = _PublisherImpl.add_connection


def add_late(self, connection):
    end = time.process_time() + 0.3
    while time.process_time() < end:
        pass
    return add_connection(self, connection)


def execute(goal):
    sequence = [0, 1]
    rate = rospy.Rate(2)
    while len(sequence) <= goal.order:
        if server.is_preempt_requested():
            server.set_preempted(FibonacciResult(sequence))
            return
        sequence.append(sequence[-1] + sequence[-2])
        server.publish_feedback(FibonacciFeedback(sequence))
        rate.sleep()
    server.set_succeeded(FibonacciResult(sequence))


_PublisherImpl.add_connection = add_late
rospy.init_node('fibonacci_server')
server = actionlib.SimpleActionServer('/fibonacci', FibonacciAction, execute, False)
server.start()
rospy.spin()
