"""A Robotont that obeys cmd_vel on an endless floor: the common part of fake_driver_node and driver_node.

Threading contract: the main thread moves the robot and publishes; messages arrive in rospy's threads, which change the
world and the board under one lock.
"""
import threading

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

from kinematic_core.worlds.robot_world import RobotWorld
from plain_support import InvalidInput
from rospy_support import parameters
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from sim_ros import robotont_messages as messages

RATE = 100  # [Hz] of odometry and transform
MAX_DELAY = 0.5  # [s] of motion that is caught up after the machine stood still
WARNING_PERIOD = 1.0  # [s] of wall time between two warnings about refused messages


class DriverNode:
    """The motors and the odometry of a Robotont; ``lock`` guards its state."""

    def __init__(self, frames: parameters.Table) -> None:
        """Register everything; ``frames`` is a Table with the names of the frames of odometry and base."""
        self._odom_frame, self._base_frame = frames.read()
        self._world = RobotWorld(dt=1.0 / RATE)
        self.lock = threading.Lock()
        self.refusals = WallThrottle(WARNING_PERIOD)
        self._odometry = LatestPublisher('odom', Odometry)
        self._transform = LatestPublisher('/tf', TFMessage)
        rospy.Subscriber('cmd_vel', Twist, self._command, queue_size=1, tcp_nodelay=True)
        parameters.log_effective()

    def run(self) -> None:
        """Move until shutdown."""
        rate, dt, moved_until = rospy.Rate(RATE, reset=True), self._world.dt, rospy.get_time()
        while not rospy.is_shutdown():
            rate.sleep()
            now = rospy.get_time()
            moved_until = min(max(moved_until, now - MAX_DELAY), now)
            with self.lock:
                while now - moved_until >= dt:
                    moved_until += dt
                    self._world.step()
                    self.stepped(self._world)
                self._publish(rospy.Time.from_sec(now))

    def stepped(self, world: RobotWorld) -> None:
        """Hook for subclasses: called after each step."""

    def _publish(self, stamp: rospy.Time) -> None:
        pose, twist = self._world.pose, self._world.twist
        self._transform.publish(TFMessage([messages.base_transform(stamp, self._odom_frame, self._base_frame, pose)]))
        self._odometry.publish(messages.odometry(stamp, self._odom_frame, self._base_frame, pose, twist))

    def _command(self, twist: Twist) -> None:
        try:
            with self.lock:
                self._world.command(twist.linear.x, twist.linear.y, twist.angular.z)
        except InvalidInput as refusal:
            self.refusals.warn('velocity', 'Ignored a message on %s, and the robot stops: %s',
                                rospy.resolve_name('cmd_vel'), refusal)
