"""Convert the state of a RobotWorld to ROS messages."""
from __future__ import annotations

import math
from types import ModuleType
from typing import TYPE_CHECKING, Sequence

import rospy
from geometry_msgs.msg import Pose, PoseArray, TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from tf2_msgs.msg import TFMessage

from kinematic_core.worlds.floor_plan import Panel
from kinematic_core.worlds.frames import AXLE_HEIGHT, Frames
from kinematic_core.worlds.omni import WHEEL_ANGLES, WHEEL_DISTANCE
from kinematic_core.worlds.planar import Pose2D, Twist2D
from rospy_support.rotations import to_quaternion

if TYPE_CHECKING:
    import numpy as np  # loading it would delay the start

POSE_VARIANCE = 1e-5  # [m^2] of x and y if the odometry has no errors, as in Gazebo's plugin
YAW_VARIANCE = 1e-3  # [rad^2]
UNKNOWN = 1e12  # variance of what odometry in the plane does not measure: z, roll, pitch
ODOMETRY_RATE, SCAN_RATE = 30.0, 40.0  # [Hz] of simulated time


def odometry(stamp: rospy.Time, frame: str, child: str, pose: Pose2D, twist: Twist2D,
             variances: tuple[float, float] = (0.0, 0.0)) -> Odometry:
    """Return an Odometry of a Pose2D and a Twist2D with the variances of x and y [m^2] and of yaw [rad^2]."""
    message = Odometry(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, frame
    message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
    message.pose.pose.orientation = to_quaternion(0.0, 0.0, pose.yaw)
    message.twist.twist.linear.x, message.twist.twist.linear.y = twist.linear_x, twist.linear_y
    message.twist.twist.angular.z = twist.angular_z
    position, yaw = variances
    message.pose.covariance = message.twist.covariance = _diagonal(
        position, position, *[UNKNOWN if position else 0.0] * 3, yaw)
    return message


def odometry_variances(distance: float, noise: float) -> tuple[float, float]:
    """Return the variances of position [m^2] and yaw [rad^2] after ``distance`` [m]; ``noise`` as for omni.Odometry."""
    grown = noise * noise * distance
    return POSE_VARIANCE + grown, YAW_VARIANCE + grown / WHEEL_DISTANCE ** 2


def transforms(stamp: rospy.Time, frames: Frames, pose: Pose2D, angles: Sequence[float]) -> TFMessage:
    """Return a TFMessage of a frames.Frames: the base at a Pose2D in odom, the wheels turned by ``angles`` [rad]."""
    base = base_transform(stamp, frames.odom, frames.footprint, pose)
    return TFMessage([base, *(_wheel(stamp, frames.base, name, *wheel)
                              for name, *wheel in zip(frames.wheels, WHEEL_ANGLES, angles))])


def base_transform(stamp: rospy.Time, frame: str, child: str, pose: Pose2D) -> TransformStamped:
    """Return the TransformStamped of the frame ``child`` at a Pose2D in ``frame``."""
    base = TransformStamped(child_frame_id=child)
    base.header.stamp, base.header.frame_id = stamp, frame
    base.transform.translation.x, base.transform.translation.y = pose.x, pose.y
    base.transform.rotation = to_quaternion(0.0, 0.0, pose.yaw)
    return base


def _wheel(stamp: rospy.Time, frame: str, child: str, direction: float, angle: float) -> TransformStamped:
    """Return the transform of a wheel in the ``direction`` [rad] from the base; its own z axis points to the middle.

    The rotation is that of the URDF: by direction - 90 degrees about z, by 90 degrees about the new x, by ``angle``
    about the new z.
    """
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, frame
    translation = message.transform.translation
    translation.x, translation.y = WHEEL_DISTANCE * math.cos(direction), WHEEL_DISTANCE * math.sin(direction)
    translation.z = AXLE_HEIGHT
    message.transform.rotation = to_quaternion(direction - 0.5 * math.pi, 0.5 * math.pi, angle, axes='rzxz')
    return message


def panel_poses(stamp: rospy.Time, panels: Sequence[Panel]) -> PoseArray:
    """Return a PoseArray of floor_plan.Panels: the middles of their faces, in the frame of the world."""
    message = PoseArray(poses=[Pose(orientation=to_quaternion(0.0, 0.0, panel.yaw)) for panel in panels])
    for pose, panel in zip(message.poses, panels):
        pose.position.x, pose.position.y, pose.position.z = panel.x, panel.y, panel.bottom + panel.size / 2.0
    message.header.stamp, message.header.frame_id = stamp, 'world'
    return message


def joint_states(stamp: rospy.Time, names: Sequence[str], angles: Sequence[float],
                 speeds: Sequence[float]) -> JointState:
    """Return a JointState of wheels, angles [rad] and speeds [rad/s]."""
    message = JointState(name=names, position=angles, velocity=speeds)
    message.header.stamp = stamp
    return message


def laser_scan(stamp: rospy.Time, frame: str, scanner: ModuleType, ranges: np.ndarray) -> LaserScan:
    """Return the LaserScan of ``ranges``; ``scanner`` is the module kinematic_core.worlds.rays, with its constants."""
    increment = (scanner.LAST_ANGLE - scanner.FIRST_ANGLE) / (scanner.RAYS - 1)
    message = LaserScan(angle_min=scanner.FIRST_ANGLE, angle_max=scanner.LAST_ANGLE, angle_increment=increment,
                        scan_time=1.0 / SCAN_RATE, range_min=scanner.NEAREST, range_max=scanner.FARTHEST,
                        ranges=ranges.tolist(), intensities=[0.0] * len(ranges))
    message.header.stamp, message.header.frame_id = stamp, frame
    return message


def _diagonal(*variances: float) -> list[float]:
    covariance = [0.0] * 36
    covariance[::7] = variances
    return covariance
