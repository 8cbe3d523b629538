"""Sends the pose of a turtle as the transform from world to the turtle's frame.

Threading contract: poses arrive in rospy's threads, one at a time.
"""
import rosgraph
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from turtlesim.msg import Pose

from kinematic_core.validation import InvalidInput, require_sane
from rospy_support import nodes
from rospy_support.parameters import ParameterError, Table, Text
from rospy_support.rotations import to_quaternion
from rospy_support.throttle import WallThrottle

PARAMETERS = Table(Text('~turtle', ''))
WARNING_PERIOD = 5.0  # [s]


class Broadcaster:
    """Sends a transform for each pose. rospy must be initialised."""

    def __init__(self, turtle):
        """``turtle``: its name; with a slash, or as a plain name, that in the root namespace."""
        self._frame = turtle.strip('/')
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._refusals = WallThrottle(WARNING_PERIOD)
        self._topic = f'/{self._frame}/pose'
        rospy.Subscriber(self._topic, Pose, self._send, queue_size=10, tcp_nodelay=True)
        rospy.loginfo('Sending the poses on %s as transforms from world to %s', self._topic, self._frame)

    def _send(self, pose):
        try:
            require_sane('pose', x=pose.x, y=pose.y, theta=pose.theta)
        except InvalidInput as refusal:
            self._refusals.warn('pose', 'Ignored a message on %s: %s', self._topic, refusal)
            return
        message = TransformStamped(child_frame_id=self._frame)
        message.header.stamp, message.header.frame_id = rospy.Time.now(), 'world'
        message.transform.translation.x, message.transform.translation.y = pose.x, pose.y
        message.transform.rotation = to_quaternion(0.0, 0.0, pose.theta)
        self._broadcaster.sendTransform(message)


def is_turtle(name):
    """Return whether a name can be that of a turtle, with or without a leading slash: topics begin with it."""
    return name.strip('/') != '' and not name.startswith('~') and rosgraph.names.is_legal_name(name)


def turtle_name():
    """Return the turtle's name: that of ~turtle, else the argument of the command line, as in the C++ tutorials."""
    arguments = rospy.myargv()[1:]
    turtle = PARAMETERS['~turtle'].read() or (arguments[0] if len(arguments) == 1 else '')
    if not is_turtle(turtle):
        raise ParameterError(f'the turtle is {turtle!r}; it must be the name of one, such as turtle1. '
                             'Set it with _turtle:=turtle1 on the command line')
    return turtle


def main(name='turtle_tf2_broadcaster'):
    """Send transforms until the shutdown; ``name``: of the node."""
    nodes.init_node(name, PARAMETERS)
    Broadcaster(turtle_name())
    rospy.spin()
