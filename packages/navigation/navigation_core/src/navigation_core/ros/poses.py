"""Poses in the plane as messages, and back."""
import math
from typing import Union

import rospy
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
from geometry_msgs.msg import Pose as PoseMessage

from navigation_core.poses import Pose
from rospy_support.rotations import to_quaternion, yaw_of


def from_pose(pose: Pose) -> PoseMessage:
    return PoseMessage(Point(pose.x, pose.y, 0.0), to_quaternion(0.0, 0.0, pose.yaw))


def to_pose(message: PoseMessage) -> Pose:
    """Return the Pose of a geometry_msgs/Pose, seen from above; ValueError if it is not one."""
    return _pose(message.position, message.orientation)


def of_transform(message: Transform) -> Pose:
    """Return the Pose of a geometry_msgs/Transform, seen from above; ValueError if it is not one."""
    return _pose(message.translation, message.rotation)


def to_transform(pose: Pose, parent: str, child: str, stamp: rospy.Time) -> TransformStamped:
    """Return the TransformStamped of the frame ``child``, which has this Pose in ``parent``."""
    message = TransformStamped()
    message.header.stamp, message.header.frame_id, message.child_frame_id = stamp, parent, child
    message.transform.translation.x, message.transform.translation.y = pose.x, pose.y
    message.transform.rotation = to_quaternion(0.0, 0.0, pose.yaw)
    return message


def _pose(position: Union[Point, Vector3], rotation: Quaternion) -> Pose:
    numbers = position.x, position.y, rotation.x, rotation.y, rotation.z, rotation.w
    if not all(map(math.isfinite, numbers)):
        raise ValueError(f'its numbers are {", ".join(f"{number:g}" for number in numbers)}; all must be finite')
    if abs(sum(number * number for number in numbers[2:]) - 1.0) > 0.1:
        raise ValueError(f'its orientation is ({", ".join(f"{number:g}" for number in numbers[2:])}); the length of a '
                         'quaternion must be 1. For no rotation, set w to 1')
    return Pose(position.x, position.y, yaw_of(rotation))
