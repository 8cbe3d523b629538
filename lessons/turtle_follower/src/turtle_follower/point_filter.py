"""Prints where turtle3 is as turtle1 sees it: each point once tf knows the transform of its time.

Threading contract: points and the timer come in rospy's threads; a lock guards the points that wait.
"""
import collections
import threading

import rospy
import tf2_ros
from geometry_msgs.msg import PointStamped
from tf.transformations import quaternion_matrix

from rospy_support import nodes, threads
from rospy_support.parameters import Table

PARAMETERS = Table()
TARGET = 'turtle1'
WAITING = 10  # points; older ones are dropped, as those of the tutorials are
PERIOD = 0.02  # [s] between two looks at tf, a little more than that of turtlesim's poses


class PointFilter:
    """Holds points until they can be transformed. rospy must be initialised."""

    def __init__(self):
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._waiting, self._lock = collections.deque(maxlen=WAITING), threading.Lock()
        rospy.Subscriber('turtle_point_stamped', PointStamped, self._keep, queue_size=WAITING)
        threads.call_every(PERIOD, lambda _: self._look())

    def _keep(self, point):
        with self._lock:
            self._waiting.append(point)

    def _look(self):
        with self._lock:
            known = [point for point in self._waiting if self._buffer.can_transform(TARGET, frame_of(point),
                                                                                    point.header.stamp)]
            for point in known:
                self._waiting.remove(point)
        for point in known:
            transform = self._buffer.lookup_transform(TARGET, frame_of(point), point.header.stamp).transform
            rospy.loginfo('point of turtle 3 in frame of turtle 1 Position(x:%f y:%f z:%f)',
                          *moved(point.point, transform))


def frame_of(point):
    """Return the frame of a PointStamped; tf2 refuses the leading slash that tf has allowed."""
    return point.header.frame_id.lstrip('/')


def moved(point, transform):
    """Return (x, y, z) [m] of a Point after a Transform."""
    turned, shift = transform.rotation, transform.translation
    matrix = quaternion_matrix((turned.x, turned.y, turned.z, turned.w))
    x, y, z, _ = matrix.dot((point.x, point.y, point.z, 1.0))
    return x + shift.x, y + shift.y, z + shift.z


def main(name='pose_drawer'):
    """Print until the shutdown."""
    nodes.init_node(name, PARAMETERS)
    PointFilter()
    rospy.spin()
