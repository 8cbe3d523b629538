"""Messages to arrays and poses, and back."""
from __future__ import annotations

import math
from typing import Sequence

import numpy as np
import rospy
from geometry_msgs.msg import Point32, Polygon, PolygonStamped, PoseStamped, Transform
from geometry_msgs.msg import Pose as PoseMessage
from nav_msgs.msg import MapMetaData, OccupancyGrid, Path
from sensor_msgs.msg import LaserScan, PointCloud2
from std_msgs.msg import Header
from tf.transformations import quaternion_matrix

from navigation_core.maps.grid_map import GridMap
from navigation_core.planning.costmap import Costmap, occupancy
from navigation_core.planning.footprint import Footprint
from navigation_core.poses import Array, Pose
from navigation_core.ros import grids
from navigation_core.ros.poses import from_pose
from rospy_support.rotations import yaw_of

FIELDS = ('x', 'y', 'z')
FLOAT32 = 7  # of a PointField


def matrix_of(transform: Transform) -> Array:
    """Return the 4 x 4 matrix of a geometry_msgs/Transform."""
    rotation, translation = transform.rotation, transform.translation
    matrix: Array = quaternion_matrix((rotation.x, rotation.y, rotation.z, rotation.w))
    matrix[:3, 3] = translation.x, translation.y, translation.z
    return matrix


def pose_of(transform: Transform) -> Pose:
    """Return the Pose in the plane of a geometry_msgs/Transform."""
    return Pose(transform.translation.x, transform.translation.y, yaw_of(transform.rotation))


def goal_problem(pose: PoseMessage) -> str:
    """Return what is wrong with a geometry_msgs/Pose as a goal, or ''."""
    quaternion = [getattr(pose.orientation, axis) for axis in ('x', 'y', 'z', 'w')]
    if not all(map(math.isfinite, (*quaternion, pose.position.x, pose.position.y))):
        return 'it contains NaN or an infinite number'
    if math.hypot(*quaternion) < 1e-6:
        return 'its quaternion (0, 0, 0, 0) is no orientation; for the heading 0, set orientation.w = 1.0'
    up = quaternion_matrix(quaternion)[2, 2]
    if up < 0.999:
        return 'its orientation is not upright: a robot on a floor turns about z only, so x and y must be 0'
    return ''


def stamped_pose(pose: Sequence[float] | Array, frame: str, stamp: rospy.Time) -> PoseStamped:
    """Return a Pose, or its three numbers, as a geometry_msgs/PoseStamped."""
    return PoseStamped(Header(stamp=stamp, frame_id=frame), from_pose(Pose(*pose)))


def path_message(points: Array, frame: str, stamp: rospy.Time, heading: float | None = None) -> Path:
    """Return points (n, 2), or poses (n, 3), as a nav_msgs/Path; ``heading`` [rad] is that of the last one."""
    if points.shape[1] == 2:
        yaws = np.zeros(len(points))
        if len(points) > 1:
            sides = np.diff(points, axis=0)
            yaws[:-1] = np.arctan2(sides[:, 1], sides[:, 0])
            yaws[-1] = yaws[-2] if heading is None else heading
        points = np.column_stack([points, yaws])
    return Path(Header(stamp=stamp, frame_id=frame), [stamped_pose(point, frame, stamp) for point in points])


def grid_of(message: OccupancyGrid) -> GridMap:
    """Return the GridMap of a nav_msgs/OccupancyGrid; raise ValueError if it is not valid."""
    grid = grids.from_message(message)
    if abs(grid.origin.yaw) > 1e-3:
        raise ValueError(f'its origin is turned by {math.degrees(grid.origin.yaw):.1f} degrees; costmaps need 0')
    return grid


def costmap_message(costmap: Costmap, frame: str, stamp: rospy.Time) -> OccupancyGrid:
    """Return a Costmap as a nav_msgs/OccupancyGrid."""
    message = OccupancyGrid(header=Header(stamp=stamp, frame_id=frame))
    height, width = costmap.shape
    message.info = MapMetaData(stamp, costmap.resolution, width, height, from_pose(Pose(costmap.x, costmap.y)))
    message.data = occupancy(costmap.costs).ravel().tolist()
    return message


def footprint_message(footprint: Footprint, pose: Pose, frame: str, stamp: rospy.Time) -> PolygonStamped:
    """Return a Footprint at a Pose as a geometry_msgs/PolygonStamped."""
    corners = np.stack(pose.to_outer(*footprint.points.T), axis=1).tolist()
    return PolygonStamped(Header(stamp=stamp, frame_id=frame),
                          Polygon([Point32(x, y, 0.0) for x, y in corners]))


def measures(message: LaserScan | PointCloud2) -> bool:
    """Return whether a LaserScan has a range in its limits, or inf: nothing is near. A PointCloud2 always measures."""
    if not hasattr(message, 'ranges'):
        return True
    ranges = np.asarray(message.ranges, float)
    return bool(np.any(np.isposinf(ranges) | (ranges >= message.range_min) & (ranges <= message.range_max)))


def scan_points(scan: LaserScan, inf_is_valid: bool) -> tuple[Array, Array]:
    """Return (points (n, 3) [m] in the scanner's frame, hits (n,)) of a sensor_msgs/LaserScan."""
    ranges = np.asarray(scan.ranges, float)
    angles = scan.angle_min + scan.angle_increment * np.arange(ranges.size)
    hits = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    open_rays = np.isposinf(ranges) & inf_is_valid
    ranges = np.where(open_rays, scan.range_max, ranges)
    used = hits | open_rays
    points = np.zeros((int(used.sum()), 3))
    points[:, 0], points[:, 1] = ranges[used] * np.cos(angles[used]), ranges[used] * np.sin(angles[used])
    return points, hits[used]


def cloud_points(cloud: PointCloud2) -> tuple[Array, Array]:
    """Return (points (n, 3) [m], hits (n,)) of a sensor_msgs/PointCloud2 with float32 fields x, y, z."""
    offsets = {field.name: field.offset for field in cloud.fields if field.datatype == FLOAT32}
    if not set(FIELDS) <= offsets.keys() or not cloud.point_step:
        return np.empty((0, 3)), np.empty(0, bool)
    kind = np.dtype({'names': FIELDS, 'formats': ['>f4' if cloud.is_bigendian else '<f4'] * 3,
                     'offsets': [offsets[name] for name in FIELDS], 'itemsize': cloud.point_step})
    records = np.frombuffer(cloud.data, kind, len(cloud.data) // cloud.point_step)
    points = np.stack([records[name] for name in FIELDS], axis=1).astype(float)
    points = points[np.isfinite(points).all(axis=1)]
    return points, np.ones(len(points), bool)
