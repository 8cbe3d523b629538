"""The node fake_localization: publishes the true pose of a simulated robot as amcl would estimate it.

Threading contract: one of rospy's threads handles the true poses, another one ``initialpose``; ``_lock`` guards the
offset between them.
"""
from __future__ import annotations

import threading
from typing import Any

import rospy
import tf2_ros
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry

from kinematic_core.worlds.floor_plan import LARGEST
from kinematic_core.worlds.planar import ORIGIN, Pose2D, compose, relative
from rospy_support import nodes, parameters
from rospy_support.parameters import Number, Table, Text
from rospy_support.rotations import to_quaternion, yaw_of
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher
from sim_ros.robotont_messages import base_transform

PARAMETERS = Table(Text('~odom_frame_id', 'odom'), Text('~base_frame_id', 'base_link'), Text('~global_frame_id', 'map'),
                   Number('~transform_tolerance', 0.1, 0.0, 10.0, 's'),
                   Number('~delta_x', 0.0, -LARGEST, LARGEST, 'm'), Number('~delta_y', 0.0, -LARGEST, LARGEST, 'm'),
                   Number('~delta_yaw', 0.0, -10.0, 10.0, 'rad'))
TF_TIMEOUT = 0.2  # [s] for the transform of a pose's stamp to arrive
WARNING_PERIOD = 10.0  # [s] of wall time


class FakeLocalization:
    """Publishes ``amcl_pose``, ``particlecloud`` and the transform from the map to the odometry."""

    def __init__(self) -> None:
        """Read the parameters and register everything."""
        self._odom, self._base, self._map, self._tolerance, *delta = PARAMETERS.read(
            '~odom_frame_id', '~base_frame_id', '~global_frame_id', '~transform_tolerance', '~delta_x', '~delta_y',
            '~delta_yaw')
        self._lock = threading.Lock()
        self._offset = relative(ORIGIN, Pose2D(*delta))  # of the frame of the true poses in the map
        self._truth: Pose2D | None = None
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._pose = Publisher('amcl_pose', PoseWithCovarianceStamped, queue_size=1)
        self._cloud = Publisher('particlecloud', PoseArray, queue_size=1)
        parameters.log_effective()
        rospy.Subscriber('base_pose_ground_truth', Odometry, self._on_truth, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber('initialpose', PoseWithCovarianceStamped, self._on_initial_pose, queue_size=1)

    def _on_truth(self, message: Odometry) -> None:
        with self._lock:
            self._truth = _plane(message.pose.pose.position, message.pose.pose.orientation)
            pose = compose(self._offset, self._truth)
        stamp = message.header.stamp
        try:
            found = self._buffer.lookup_transform(self._odom, self._base, stamp, rospy.Duration(TF_TIMEOUT)).transform
        except tf2_ros.TransformException as error:
            self._throttle.warn('tf', 'No transform from %s to %s yet: %s', self._odom, self._base, error)
            return
        odometry = compose(pose, relative(ORIGIN, _plane(found.translation, found.rotation)))
        self._broadcaster.sendTransform(base_transform(stamp + rospy.Duration(self._tolerance), self._map, self._odom,
                                                       odometry))
        self._publish(pose, stamp)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        """Take over the pose that a user gives: this moves the map, not the robot."""
        given = _plane(message.pose.pose.position, message.pose.pose.orientation)
        with self._lock:
            if self._truth is not None:
                self._offset = compose(given, relative(ORIGIN, self._truth))

    def _publish(self, pose: Pose2D, stamp: rospy.Time) -> None:
        estimate = PoseWithCovarianceStamped()
        estimate.header.stamp, estimate.header.frame_id = stamp, self._map
        message = estimate.pose.pose
        message.position.x, message.position.y = pose.x, pose.y
        message.orientation = to_quaternion(0.0, 0.0, pose.yaw)
        self._pose.publish(estimate)
        self._cloud.publish(PoseArray(header=estimate.header, poses=[message]))


def _plane(position: Any, orientation: Any) -> Pose2D:
    return Pose2D(position.x, position.y, yaw_of(orientation))


def main() -> None:
    """Run fake_localization."""
    nodes.init_node('fake_localization', PARAMETERS)
    FakeLocalization()
    rospy.spin()
