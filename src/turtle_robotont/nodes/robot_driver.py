"""Drive a robot that publishes odometry."""
import math

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry

from kinematic_core.timing.stall_free_timer import ActiveTimer
from kinematic_core.worlds.robot_world import WATCHDOG
from rospy_support.rotations import yaw_of
from rospy_support.throttle import WallThrottle
from rospy_support.topic_diagnosis import waiting_text
from rospy_support.topics import LatestPublisher, Publisher
from turtle_robotont.driving.vehicle import ROBOT, VehicleState
from turtle_robotont.msg import DriveStatus
from turtle_robotont.nodes.driver import Driver

WARNING_PERIOD = 5.0  # [s]
UNIT_TOLERANCE = 0.01  # by which the length of a quaternion may differ from 1


class RobotDriver(Driver):
    """Drives a robot by ``odom`` and ``cmd_vel``; publishes ``drive_status``. Poses are in the frame of odom.

    Odometry whose stamp is not later than the last one is ignored, until pose_timeout has passed without any other.
    Time in which this process stood still does not count.
    """

    pose_timeout = WATCHDOG  # [s] after which a Robotont without commands stops by itself

    def __init__(self):
        super().__init__(ROBOT, LatestPublisher('cmd_vel', Twist),
                         Publisher('drive_status', DriveStatus, queue_size=10), 'odom')
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._stamp, self._since = None, ActiveTimer()  # [s] stamp of the last odometry used, and the time since then
        self._subscriber = rospy.Subscriber('odom', Odometry, self._on_odometry, tcp_nodelay=True)

    def _on_odometry(self, odometry):
        stamp = odometry.header.stamp.to_sec() or rospy.get_time()
        before = self._stamp
        if before is not None and stamp <= before and self._since.look() < self.pose_timeout:
            self._throttle.warn('stamp', '%s: the time %.3f s is not after that of the last message, %.3f s; ignored. '
                                'Do two nodes publish it? (rostopic info)', self.pose_topic, stamp, before)
            return
        self._stamp, self._since = stamp, ActiveTimer()
        self._take(pose_of(odometry), 0.0 if before is None else step_time(before, stamp, self.pose_timeout))

    def _no_pose(self, timeout):
        text = f'no odometry on {self.pose_topic} for {timeout:g} s; is the robot or its simulator running?'
        return f'{text} {waiting_text(self._subscriber, "odom")}' if self._stamp is None else text


def step_time(before, stamp, longest):
    """Return the time [s] between two stamps, limited to 0 to ``longest`` in case a clock was set."""
    return min(max(0.0, stamp - before), longest)


def pose_of(odometry):
    """Return the VehicleState of a nav_msgs/Odometry; its theta is NaN if the orientation is not a rotation."""
    q, twist = odometry.pose.pose.orientation, odometry.twist.twist
    is_unit = abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < UNIT_TOLERANCE
    theta = yaw_of(q) if is_unit else math.nan
    position = odometry.pose.pose.position
    return VehicleState(position.x, position.y, theta, math.hypot(twist.linear.x, twist.linear.y), twist.angular.z)
