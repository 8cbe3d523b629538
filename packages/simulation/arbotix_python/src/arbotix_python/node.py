"""The node arbotix_driver with ~sim: publishes odometry, tf and the states of joints that follow their commands.

Threading contract: rospy's threads store commands; the main thread steps and publishes; ``_lock`` guards both.
"""
import math
import threading
from typing import Tuple

import rospy
import tf2_ros
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from arbotix_python.core.robot import BASE, TIMEOUT, Base, Joint, split
from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Number, ParameterError, Table
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher
from sim_ros.robotont_messages import base_transform, joint_states, odometry

PARAMETERS = Table(Boolean('~sim', False), Number('~rate', 100.0, 1.0, 1000.0, 'Hz'))
WHEELS = ('base_l_wheel_joint', 'base_r_wheel_joint')  # of a differential base; their angles stay 0, as in the original
WARNING_PERIOD = 10.0  # [s] of wall time
LARGEST = 100.0  # [m/s, rad/s] of a command


class Driver:
    """Publishes ``odom``, ``joint_states`` and ``/tf``."""

    def __init__(self) -> None:
        """Read the parameters and register everything; raise ParameterError."""
        sim, self._rate = PARAMETERS.read('~sim', '~rate')
        if not sim:
            raise ParameterError('~sim is false, but there is no driver for ArbotiX hardware here. Set ~sim to true '
                                 'for a robot without hardware.')
        self._lock, self._throttle = threading.Lock(), WallThrottle(WARNING_PERIOD)
        try:
            bases, others = split(rospy.get_param('~controllers', {}))
            self._joints = {name: Joint(settings or {}) for name, settings in rospy.get_param('~joints', {}).items()}
        except (AttributeError, ValueError) as error:
            raise ParameterError(f'~controllers or ~joints: {error}') from None
        if others:
            rospy.logerr('These controllers do nothing here: %s. Only the type %s is there.', ', '.join(others), BASE)
        settings = next(iter(bases.values()), None)
        self._base = None if settings is None else Base(settings.get('timeout', TIMEOUT))
        frames = settings or {}
        self._odom, self._frame = frames.get('odom_frame_id', 'odom'), frames.get('base_frame_id', 'base_link')
        self._states = Publisher('joint_states', JointState, queue_size=1)
        if self._base:
            self._odometry = Publisher('odom', Odometry, queue_size=1)
            self._broadcaster = tf2_ros.TransformBroadcaster()
            rospy.Subscriber('cmd_vel', Twist, self._on_velocity, self._base, queue_size=1)
        for name, joint in self._joints.items():
            rospy.Subscriber(f'{name}/command', Float64, self._on_angle, callback_args=(name, joint), queue_size=1)
        parameters.log_effective()

    def _on_velocity(self, message: Twist, base: Base) -> None:
        speeds = message.linear.x, message.angular.z
        if not all(abs(speed) <= LARGEST for speed in speeds):  # NaN is not
            self._throttle.warn('cmd_vel', 'cmd_vel: %s is ignored, must be at most %g', speeds, LARGEST)
            return
        with self._lock:
            base.command(*speeds)

    def _on_angle(self, message: Float64, named: Tuple[str, Joint]) -> None:
        name, joint = named
        if not math.isfinite(message.data):
            self._throttle.warn(name, '%s/command: %s is ignored, must be a number', name, message.data)
            return
        with self._lock:
            within = joint.command(message.data)
        if not within:
            self._throttle.warn(name, '%s/command: %g rad is out of range, %g is taken', name, message.data, joint.goal)

    def run(self) -> None:
        """Step and publish until the shutdown."""
        rate = rospy.Rate(self._rate)
        before = rospy.Time.now()
        while not rospy.is_shutdown():
            try:
                rate.sleep()
            except rospy.ROSTimeMovedBackwardsException:
                before = rospy.Time.now()
            now = rospy.Time.now()
            if now > before:
                self._step(now, (now - before).to_sec())
                before = now

    def _step(self, now: rospy.Time, dt: float) -> None:
        with self._lock:
            for joint in self._joints.values():
                joint.step(dt)
            names = [*self._joints, *(WHEELS if self._base else ())]
            still = [0.0] * (len(names) - len(self._joints))
            angles = [joint.angle for joint in self._joints.values()] + still
            speeds = [joint.speed for joint in self._joints.values()] + still
            if self._base:
                self._base.step(dt)
                pose, twist = self._base.pose, self._base.twist
        if names:
            self._states.publish(joint_states(now, names, angles, speeds))
        if self._base:
            self._odometry.publish(odometry(now, self._odom, self._frame, pose, twist))
            self._broadcaster.sendTransform(base_transform(now, self._odom, self._frame, pose))


def main() -> None:
    """Run arbotix_driver."""
    nodes.init_node('arbotix', PARAMETERS)
    Driver().run()
