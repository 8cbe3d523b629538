#!/usr/bin/env python3
"""A server of the action Fibonacci, whose name is that of the node: an order of 5 gives 6 numbers."""
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult


class FibonacciServer:
    """Computes one number of the Fibonacci sequence per second."""

    def __init__(self, name):
        """Start the server of the action ``name``."""
        self.name = name
        self.server = actionlib.SimpleActionServer(name, FibonacciAction, self.execute, auto_start=False)
        self.server.start()

    def execute(self, goal):
        """Compute the sequence of one goal; the server calls this method in a thread of its own."""
        sequence = [0, 1]
        rospy.loginfo('%s: Executing, creating fibonacci sequence of order %d with seeds %d, %d',
                      self.name, goal.order, sequence[0], sequence[1])
        rate = rospy.Rate(1)  # [Hz]
        for _ in range(1, goal.order):
            if self.server.is_preempt_requested() or rospy.is_shutdown():  # cancelled, or another goal has come
                rospy.loginfo('%s: Preempted', self.name)
                self.server.set_preempted()
                return
            sequence.append(sequence[-1] + sequence[-2])
            self.server.publish_feedback(FibonacciFeedback(sequence))
            try:
                rate.sleep()
            except rospy.ROSInterruptException:
                pass  # Ctrl-C
        rospy.loginfo('%s: Succeeded', self.name)
        self.server.set_succeeded(FibonacciResult(sequence))


def main():
    """Serve until Ctrl-C."""
    rospy.init_node('fibonacci')
    FibonacciServer(rospy.get_name())
    rospy.spin()


if __name__ == '__main__':
    main()
