"""mimic: one turtle copies another one. The node reads the speeds in input/pose and sends them to output/cmd_vel.

Threading contract: poses arrive in rospy's threads, the shutdown in the main one; a lock orders what they publish.
"""
import threading

import rospy
from geometry_msgs.msg import Twist

from plain_support import InvalidInput, require_sane
from rospy_support import nodes
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from turtlesim.msg import Pose

WARNING_PERIOD = 5.0  # [s]


def twist_from_pose(pose: Pose) -> Twist:
    """Return the Twist with the speeds [m/s, rad/s] of a turtlesim/Pose; raise InvalidInput if they are invalid.

    A pose carries no direction of travel: a turtle that drives backward is mimicked by one that drives forward.
    """
    require_sane('pose', linear_velocity=pose.linear_velocity, angular_velocity=pose.angular_velocity)
    twist = Twist()
    twist.linear.x = pose.linear_velocity
    twist.angular.z = pose.angular_velocity
    return twist


def topic_below(namespace: str, name: str) -> str:
    """Return the name with which to register a topic, so that its namespace can be remapped as well as the topic.

    ``input:=turtle1`` and ``input/pose:=turtle1/pose`` mean the same; rospy itself supports only the second form.
    """
    return rospy.resolve_name(namespace).rstrip('/') + '/' + name


class MimicNode:
    """Copies the speeds, and stops the copying turtle once when the node ends. rospy must be initialised."""

    def __init__(self) -> None:
        self._lock = threading.RLock()  # a signal may end the node while its main thread holds it
        self._moving = self._ended = False
        self._publisher = LatestPublisher(topic_below('output', 'cmd_vel'), Twist)
        source = topic_below('input', 'pose')
        self._input = rospy.resolve_name(source)
        self._refusals = WallThrottle(WARNING_PERIOD)
        rospy.on_shutdown(self._stop)
        rospy.loginfo('%s controls %s (choose other turtles with input:=turtle1 output:=turtle2)',
                      self._input, self._publisher.resolved_name)
        rospy.Subscriber(source, Pose, self._copy, queue_size=1, tcp_nodelay=True)

    def _copy(self, pose: Pose) -> None:
        try:
            twist = twist_from_pose(pose)
        except InvalidInput as refusal:
            self._refusals.warn('pose', 'Ignored a message on %s: %s', self._input, refusal)
            return
        with self._lock:
            if not self._ended:
                self._publisher.publish(twist)
                self._moving = bool(twist.linear.x or twist.angular.z)

    def _stop(self) -> None:
        with self._lock:
            self._ended = True
            if self._moving:
                self._publisher.publish(Twist())


def main() -> None:
    nodes.init_node('turtle_mimic')
    MimicNode()
    rospy.spin()
