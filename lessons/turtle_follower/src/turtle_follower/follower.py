"""Spawns a turtle and lets it follow a frame of tf.

Threading contract: tf listens in rospy's threads; the main thread looks transforms up and publishes, and a lock orders
its last velocity and the one that stops the turtle.
"""
import threading
from typing import NamedTuple

import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from turtlesim.srv import Spawn

from kinematic_core.worlds.planar import STILL
from rospy_support import nodes
from rospy_support.parameters import ParameterError, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from rospy_support.velocities import to_twist
from turtle_follower.broadcaster import is_turtle
from turtle_follower.core.following import Freshness, velocity_towards

PARAMETERS = Table(Text('turtle', 'turtle2'))
RATE = 10.0  # [Hz]
WARNING_PERIOD = 5.0  # [s]
REMINDER = 5.0  # [s] while the simulator is not there
START = 4.0, 2.0, 0.0  # [m, m, rad] of the turtle that follows, that of the tutorials
LONGEST_WAIT = 1.0  # [s] for a transform of the present time


class Following(NamedTuple):
    """What is followed, and how.

    ``turtle`` follows the frame ``target``, as seen from ``frame`` (the turtle's own, if it is empty); ``start``: x, y,
    theta where it is spawned [m, m, rad]; ``wait``: look up the transform of the present time, and wait for it.
    """

    turtle: str = 'turtle2'
    target: str = 'turtle1'
    frame: str = ''
    start: tuple = START
    wait: bool = False


class Follower:
    """Drives the turtle. rospy must be initialised."""

    def __init__(self, following):
        """Spawn the turtle and register its topic."""
        self._following = following
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        spawn(following.turtle, following.start)
        self._lock, self._moving, self._ended = threading.RLock(), False, False
        self._freshness, self._throttle = Freshness(), WallThrottle(WARNING_PERIOD)
        self._publisher = LatestPublisher(f'{following.turtle}/cmd_vel', Twist)
        rospy.on_shutdown(self._end)

    def run(self):
        """Follow until the shutdown."""
        rate = rospy.Rate(RATE)
        while not rospy.is_shutdown():
            self._publish(self._velocity())
            rate.sleep()

    def _velocity(self):
        """Return the velocity towards the target; STILL while it is not known where that is."""
        follower, target = self._following.frame or self._following.turtle, self._following.target
        now = rospy.Time.now()
        when, patience = (now, LONGEST_WAIT) if self._following.wait else (rospy.Time(), 0.0)
        try:
            found = self._buffer.lookup_transform(follower, target, when, rospy.Duration(patience))
        except tf2_ros.TransformException as error:
            self._throttle.warn('lost', 'No transform from %s to %s: %s. The turtle stands until there is one',
                                follower, target, error)
            return STILL
        if not self._freshness.is_fresh(found.header.stamp.to_nsec(), now.to_sec()):
            self._throttle.warn('old', 'The transform from %s to %s is no longer sent: does a broadcaster run for each?'
                                ' The turtle stands until it is sent again', follower, target)
            return STILL
        return velocity_towards(found.transform.translation.x, found.transform.translation.y)

    def _publish(self, velocity):
        """Publish a velocity; one that stops the turtle only once, so that another node can drive it."""
        with self._lock:
            if not self._ended and (self._moving or velocity != STILL):
                self._moving = velocity != STILL
                self._publisher.publish(to_twist(velocity))

    def _end(self):
        with self._lock:
            self._publish(STILL)
            self._ended = True


def spawn(turtle, start):
    """Wait for the simulator and spawn a turtle; one of this name that is already there does as well."""
    service = rospy.resolve_name('spawn')
    while True:
        try:
            rospy.wait_for_service(service, REMINDER)
            break
        except rospy.ROSException as error:
            if isinstance(error, rospy.ROSInterruptException) or rospy.is_shutdown():
                raise
            rospy.logwarn('Waiting for the service %s: is the simulator running? rosrun turtlesim turtlesim_node',
                          service)
    try:
        rospy.ServiceProxy(service, Spawn)(*start, turtle)
    except rospy.ServiceException as error:
        rospy.logwarn('%s did not spawn %s, so the one that is there follows: %s', service, turtle, error)


def main(name='turtle_tf2_listener', **options):
    """Follow a frame; ``name``: of the node; ``options``: those of Following, without the turtle."""
    nodes.init_node(name, PARAMETERS)
    following = Following(turtle=PARAMETERS['turtle'].read(), **options)
    if not is_turtle(following.turtle) or following.turtle.strip('/') == following.target:
        resolved = rospy.resolve_name('turtle')
        raise ParameterError(f'parameter {resolved} is {following.turtle!r}; it must be the name of another turtle '
                             f'than {following.target}. Set it with rosparam set {resolved} turtle2')
    Follower(following).run()
