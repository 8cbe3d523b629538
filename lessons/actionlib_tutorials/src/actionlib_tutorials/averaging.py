"""Averaging: an action that takes numbers from a topic and succeeds if their mean is at least 5.

Threading contract: numbers arrive in rospy's threads and go into a queue; a goal is executed in the thread of its
SimpleActionServer.
"""
import math
import queue
import random

import rospy
from std_msgs.msg import Float32

from actionlib_tutorials.core.numbers_of_actions import Average
from actionlib_tutorials.msg import AveragingAction, AveragingFeedback, AveragingGoal, AveragingResult
from rospy_support import actions, nodes
from rospy_support.parameters import Table
from rospy_support.throttle import WallThrottle

PARAMETERS = Table()
ACTION, TOPIC = 'averaging', 'random_number'
LEAST_MEAN = 5.0  # below, the goal is aborted
SAMPLES, PATIENCE = 100, 30.0  # of the client's goal; [s]
MEAN, DEVIATION, RATE = 5.0, 1.0, 20.0  # of the generator; [Hz]
POLL = 0.05  # [s] between two looks for a cancelled goal
REMINDER = 5.0  # [s] while there are no numbers
QUEUE = 1000  # numbers


class Averager:
    """Executes goals. rospy must be initialised."""

    def __init__(self):
        self._numbers, self._throttle = queue.Queue(QUEUE), WallThrottle(REMINDER)
        self._subscriber = rospy.Subscriber(TOPIC, Float32, self._take)
        self._wanted = False
        actions.serve(AveragingAction, self._execute)

    def _take(self, message):
        if not math.isfinite(message.data):
            self._throttle.warn('number', 'Ignored a message on %s: it is %r; it must be a finite number',
                                self._subscriber.resolved_name, message.data)
        elif self._wanted and not self._numbers.full():
            self._numbers.put_nowait(message.data)

    def _execute(self, goal, server):
        """Return the result of a goal; as in the original, it takes one number more than the goal says."""
        if goal.samples < 0:
            raise actions.Refused(f'samples is {goal.samples}; it must be 0 or more')
        average, self._numbers = Average(), queue.Queue(QUEUE)
        self._wanted = True
        try:
            while average.count <= goal.samples:
                number = self._next(server)
                average.add(number)
                server.publish_feedback(AveragingFeedback(average.count, number, average.mean, average.deviation))
        finally:
            self._wanted = False
        if average.mean < LEAST_MEAN:
            raise actions.Refused(f'the mean is {average.mean:.3f}; it must be at least {LEAST_MEAN:g}',
                                  AveragingResult(average.mean, average.deviation))
        return AveragingResult(average.mean, average.deviation)

    def _next(self, server):
        """Return the next number."""
        while True:
            actions.check(server)
            try:
                return self._numbers.get(timeout=POLL)
            except queue.Empty:
                if not self._subscriber.get_num_connections():
                    self._throttle.warn('none', 'No numbers on %s. Start in another terminal: '
                                        'rosrun actionlib_tutorials gen_numbers.py', self._subscriber.resolved_name)


def main():
    """Run the server."""
    nodes.init_node(ACTION, PARAMETERS)
    Averager()
    rospy.spin()


def client():
    """Ask for the mean of 100 numbers."""
    nodes.init_node('test_averaging', PARAMETERS)
    actions.report(actions.run_goal(ACTION, AveragingAction, AveragingGoal(SAMPLES), PATIENCE))


def generate():
    """Publish random numbers."""
    nodes.init_node('random_number_generator', PARAMETERS)
    publisher, rate = rospy.Publisher(TOPIC, Float32, queue_size=10), rospy.Rate(RATE)
    rospy.loginfo('Generating random numbers')
    while not rospy.is_shutdown():
        publisher.publish(random.normalvariate(MEAN, DEVIATION))
        rate.sleep()
