"""Laser scans with the pose of the robot's odometry at their time, and warnings that say which of them is missing.

Threading contract: rospy's thread of ``scan`` calls ``on_scan``, one scan after the other; a timer warns.
"""
from __future__ import annotations

from typing import Callable

import rospy
import tf2_ros
from sensor_msgs.msg import LaserScan

from navigation_core.poses import Pose
from navigation_core.ros.poses import of_transform
from navigation_core.scans import Scan, usable
from rospy_support.throttle import WallThrottle

REPEAT = 15.0  # [s] between two warnings of a kind
CHECK = 5.0  # [s] between two looks at whether scans come
PATIENCE = 0.2  # [s] that a scan waits for its transform
STARTING = 2.0  # [s] in which scans without a transform are normal: nodes start one after the other


class ScanSource:
    """Calls ``on_scan(odometry, scan, stamp)``: a Pose of the base in the odometry's frame, and a Scan."""

    def __init__(self, on_scan: Callable[[Pose, Scan, rospy.Time], object], base_frame: str, odom_frame: str,
                 nearest: float = -1.0, farthest: float = -1.0, usable_range: float = -1.0) -> None:
        """Subscribe to ``scan``; the ranges [m] are the scan's own if they are negative.

        ``usable_range`` is that of gmapping's maxUrange: longer beams are cut there.
        """
        self._on_scan, self._base, self._odom = on_scan, base_frame, odom_frame
        self._limits = nearest, farthest, usable_range
        self._throttle = WallThrottle(REPEAT)
        self._mounts: dict[str, Pose] = {}  # frame of a scan: pose of the scanner on the robot
        self._last: float | None = None  # [s] when the last scan came
        self._failing_since: float | None = None  # [s]
        self.buffer = tf2_ros.Buffer(rospy.Duration(30.0))
        self._listener = tf2_ros.TransformListener(self.buffer)
        self._scans = rospy.Subscriber('scan', LaserScan, self._on_message, queue_size=1, buff_size=2 ** 20,
                                       tcp_nodelay=True)
        rospy.Timer(rospy.Duration(CHECK), self._check)

    def pose(self, stamp: rospy.Time) -> Pose:
        """Return the Pose of the base in the odometry's frame; raise tf2_ros.TransformException."""
        return self._lookup(self._odom, self._base, stamp)

    def _lookup(self, target: str, source: str, stamp: rospy.Time) -> Pose:
        return of_transform(self.buffer.lookup_transform(target, source, stamp, rospy.Duration(PATIENCE)).transform)

    def _on_message(self, message: LaserScan) -> None:
        self._last = now = rospy.get_time()
        stamp, frame = message.header.stamp, message.header.frame_id.lstrip('/')
        try:
            if frame not in self._mounts:
                self._mounts[frame] = self._lookup(self._base, frame, stamp)
            odometry = self.pose(stamp)
        except (tf2_ros.TransformException, ValueError) as error:
            self._failing_since = self._failing_since or now
            if now - self._failing_since < STARTING:
                return
            self._throttle.warn('tf', 'Ignored a scan on %s: there is no transform of %s at its time, %.3f: %s. Does '
                                'the node that publishes odometry run, and are ~base_frame and ~odom_frame its frames?',
                                self._scans.resolved_name,
                                f'{self._odom} -> {self._base} -> {frame}', stamp.to_sec(), error)
            return
        self._failing_since = None
        scan = self._usable(message, self._mounts[frame])
        if scan is not None:
            self._on_scan(odometry, scan, stamp)

    def _usable(self, message: LaserScan, mount: Pose) -> Scan | None:
        nearest, farthest, usable_range = self._limits
        farthest = message.range_max if farthest < 0.0 else min(farthest, message.range_max)
        usable_range = farthest if usable_range < 0.0 else min(usable_range, farthest)
        try:
            scan = usable(message.ranges, message.angle_min, message.angle_increment,
                          message.range_min if nearest < 0.0 else max(nearest, message.range_min), farthest,
                          usable_range, mount)
        except ValueError as error:
            self._throttle.warn('fields', 'Ignored a scan on %s: %s', self._scans.resolved_name, error)
            return None
        if not len(scan.points):
            self._throttle.warn('empty', 'Ignored a scan on %s: none of its %d ranges is a finite number from %g to '
                                '%g m. Is the sensor covered, or is nothing near enough?', self._scans.resolved_name,
                                len(message.ranges), message.range_min, farthest)
            return None
        return scan

    def _check(self, _: rospy.timer.TimerEvent) -> None:
        if self._last is None or rospy.get_time() - self._last > CHECK:
            since = 'yet' if self._last is None else f'for {rospy.get_time() - self._last:.0f} s'
            self._throttle.warn('none', 'No message on %s %s. Start the laser scanner, or remap: scan:=/your/topic. '
                                'rostopic list shows the topics.', self._scans.resolved_name, since)
