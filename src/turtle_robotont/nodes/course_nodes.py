"""The course's first nodes: a velocity publisher and a pose subscriber.

Threads: the publisher works in a timer's thread, and stops the turtle in rospy's shutdown hook, which runs in any
thread; a lock orders the two. The subscriber's callback runs in rospy's thread and shares no data.
"""
import threading

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

from rospy_support import threads
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher


class VelocityPublisher:
    """Publishes one constant velocity on ``topic``, and a stop when the node shuts down."""

    def __init__(self, topic, linear, angular, rate):
        """``linear`` [m/s], ``angular`` [rad/s], ``rate`` [Hz]."""
        self._velocity = Twist()
        self._velocity.linear.x, self._velocity.angular.z = linear, angular
        self._lock = threading.Lock()
        self._stopped = False
        self._publisher = LatestPublisher(topic, Twist)
        rospy.on_shutdown(self.stop)
        threads.call_every(1.0 / rate, self._publish)

    def _publish(self, _):
        with self._lock:
            if self._stopped:
                return
            self._publisher.publish(self._velocity)
        rospy.loginfo('Publish turtle velocity command[%0.2f m/s, %0.2f rad/s]',
                      self._velocity.linear.x, self._velocity.angular.z)

    def stop(self):
        """Publish a velocity of zero, once, and nothing after it."""
        with self._lock:
            self._stopped = True
            self._publisher.publish(Twist())


class PosePrinter:
    """Prints the poses of ``topic`` as the course does."""

    def __init__(self, topic, rate=0.0):
        """``rate`` [Hz]: print at most this many poses per second; 0: all."""
        self._throttle = WallThrottle(1.0 / rate if rate > 0.0 else 0.0)
        rospy.Subscriber(topic, Pose, self._on_pose)

    def _on_pose(self, pose):
        if self._throttle.due():
            rospy.loginfo('Turtle pose: x:%0.6f, y:%0.6f', pose.x, pose.y)
