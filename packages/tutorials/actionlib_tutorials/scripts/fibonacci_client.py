#!/usr/bin/env python3
"""Ask the action fibonacci for a sequence, and print it."""
import actionlib
import rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciGoal


def main():
    """Send a goal and wait for its result."""
    rospy.init_node('fibonacci_client_py')
    client = actionlib.SimpleActionClient('fibonacci', FibonacciAction)
    rospy.loginfo('Waiting for action server to start.')
    if not client.wait_for_server():
        return  # Ctrl-C
    rospy.loginfo('Action server started, sending goal.')
    client.send_goal(FibonacciGoal(order=20))
    if client.wait_for_result():  # False after Ctrl-C
        print('Result:', ', '.join(str(number) for number in client.get_result().sequence))


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
