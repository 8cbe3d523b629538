"""Fibonacci: an action that computes a number per second.

Threading contract: a goal is executed in the thread of its SimpleActionServer.
"""
import time

import rospy

from actionlib_tutorials.core.numbers_of_actions import LONGEST, SEEDS, fibonacci
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciGoal, FibonacciResult
from rospy_support import actions, nodes
from rospy_support.parameters import Table

PARAMETERS = Table()
ACTION = 'fibonacci'
PERIOD = 1.0  # [s] between two numbers
POLL = 0.05  # [s] between two looks for a cancelled goal
ORDER, CLASS_ORDER = 20, 10  # of the clients' goals
PATIENCE = 30.0  # [s] of the client that was written in C++


def serve(extra, name=None):
    """Serve the action; the sequence has ``extra`` numbers more than the order of the goal; ``name``: of actions."""
    def execute(goal, server):
        longest = LONGEST - extra
        if not 0 <= goal.order <= longest:
            raise actions.Refused(f'order is {goal.order}; it must be 0 to {longest}, so that the numbers fit into an '
                                  'int32')
        rospy.loginfo('%s: Executing, creating fibonacci sequence of order %d with seeds %d, %d', rospy.get_name(),
                      goal.order, *SEEDS)
        sequence = list(SEEDS)
        for sequence in fibonacci(goal.order + extra):
            actions.check(server)
            server.publish_feedback(FibonacciFeedback(sequence))
            pause(server)
        return FibonacciResult(sequence)
    actions.serve(FibonacciAction, execute, name)
    rospy.spin()


def pause(server):
    """Wait for PERIOD of ROS time; a goal that is cancelled ends it at once."""
    end = rospy.get_time() + PERIOD
    while rospy.get_time() < end:
        actions.check(server)
        time.sleep(POLL)


def ask(order, patience=None, feedback=None):
    """Send a goal to the server and return its ClientGoalHandle once it has ended."""
    options = {} if patience is None else {'patience': patience}
    return actions.run_goal(ACTION, FibonacciAction, FibonacciGoal(order), feedback=feedback, **options)


def main():
    """Run the server that was written in Python: an order of 5 gives 6 numbers."""
    nodes.init_node(ACTION, PARAMETERS)
    serve(extra=1)


def main_cpp():
    """Run the server that was written in C++: an order of 5 gives 7 numbers, and the action never has another name."""
    nodes.init_node(ACTION, PARAMETERS)
    serve(extra=2, name=ACTION)


def client():
    """Ask for a sequence and print it."""
    nodes.init_node('fibonacci_client_py', PARAMETERS)
    done = ask(ORDER)
    print('Result:', ', '.join(map(str, done.get_result().sequence)), flush=True)
    actions.report(done)


def client_cpp():
    """Ask for a sequence and log it, unless it takes longer than 30 s."""
    nodes.init_node('test_fibonacci', PARAMETERS)
    done = ask(ORDER, PATIENCE)
    rospy.loginfo('Action result: %s', ' '.join(map(str, done.get_result().sequence)))
    actions.report(done)


def callback_client():
    """Ask for a sequence and log each feedback."""
    nodes.init_node('test_fibonacci_callback', PARAMETERS)
    say_answer(ask(ORDER, feedback=lambda now: rospy.loginfo('Got Feedback of length %d', len(now.sequence))))


def class_client():
    """Ask for a short sequence and log its last number."""
    nodes.init_node('test_fibonacci_class_client', PARAMETERS)
    say_answer(ask(CLASS_ORDER))


def say_answer(done):
    """Log the last number of a client's result."""
    sequence = done.get_result().sequence
    if sequence:
        rospy.loginfo('Answer: %d', sequence[-1])
    actions.report(done)
