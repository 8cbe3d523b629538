"""The node slam_gmapping: publishes a map of what a laser scanner sees, and the pose of the robot in it.

Threading contract: rospy's thread of ``scan`` maps; a timer publishes the transform; both, and the service, use the
state under one lock. A thread of its own publishes maps, because that takes longer than a scan.
"""
from __future__ import annotations

import threading

import rospy
import tf2_ros
from nav_msgs.msg import MapMetaData
from nav_msgs.srv import GetMap, GetMapRequest, GetMapResponse
from std_msgs.msg import Float64

from navigation_core.poses import Pose
from navigation_core.ros import grids
from navigation_core.ros.poses import to_transform
from navigation_core.ros.scan_source import ScanSource
from navigation_core.scans import Scan
from navigation_core.slam.mapper import Mapper, Settings
from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Integer, Number, Table, Text
from rospy_support.topics import Publisher

NAME = 'slam_gmapping'
USED = Table(
    Text('~base_frame', 'base_link', filled=True), Text('~map_frame', 'map', filled=True),
    Text('~odom_frame', 'odom', filled=True), Integer('~throttle_scans', 1, 1, 1000),
    Number('~map_update_interval', 5.0, 0.0, 3600.0, 's'), Number('~transform_publish_period', 0.05, 0.0, 10.0, 's'),
    Number('~tf_delay', 0.05, 0.0, 10.0, 's'), Number('~maxUrange', -1.0, -1.0, 1000.0, 'm'),
    Number('~maxRange', -1.0, -1.0, 1000.0, 'm'), Number('~minimumScore', 0.0, 0.0, 1e6),
    Number('~srr', 0.1, 0.0, 10.0), Number('~srt', 0.2, 0.0, 10.0), Number('~str', 0.1, 0.0, 10.0),
    Number('~stt', 0.2, 0.0, 10.0), Number('~linearUpdate', 1.0, 0.0, 100.0, 'm'),
    Number('~angularUpdate', 0.5, 0.0, 100.0, 'rad'), Number('~temporalUpdate', -1.0, -1.0, 3600.0, 's'),
    Number('~resampleThreshold', 0.5, 0.0, 1.0), Integer('~particles', 30, 1, 200),
    Number('~xmin', -10.0, -100.0, 0.0, 'm'), Number('~ymin', -10.0, -100.0, 0.0, 'm'),
    Number('~xmax', 10.0, 0.0, 100.0, 'm'), Number('~ymax', 10.0, 0.0, 100.0, 'm'),
    Number('~delta', 0.05, 0.01, 1.0, 'm'), Number('~occ_thresh', 0.25, 0.0, 1.0))
ACCEPTED = Table(  # they configure the matcher of the original; ours is different
    Number('~sigma', 0.05), Integer('~kernelSize', 1), Number('~lstep', 0.05), Number('~astep', 0.05),
    Integer('~iterations', 5), Number('~lsigma', 0.075), Number('~ogain', 3.0), Integer('~lskip', 0),
    Number('~llsamplerange', 0.01), Number('~llsamplestep', 0.01), Number('~lasamplerange', 0.005),
    Number('~lasamplestep', 0.005), Boolean('~inverted_laser', False))
PARAMETERS = Table(USED, ACCEPTED)


class MappingNode:
    """gmapping's interface on a Mapper."""

    def __init__(self) -> None:
        value = {parameter.name[1:]: parameter.read() for parameter in PARAMETERS}
        parameters.log_effective()
        self._value = value
        self._mapper = Mapper(Settings(  # as in the original, the map begins as the odometry's frame
            value['delta'], (value['xmin'], value['ymin'], value['xmax'], value['ymax']), value['particles'],
            value['linearUpdate'], value['angularUpdate'], value['temporalUpdate'], value['resampleThreshold'],
            value['minimumScore'], value['srr'], value['srt'], value['str'], value['stt']))
        self._lock, self._changed = threading.Lock(), threading.Event()
        self._odometry_in_map = Pose()
        self._count = 0  # of scans
        self._message: grids.Grid | None = None
        self._published_at: rospy.Time | None = None
        self._grids = Publisher('map', grids.Grid, latch=True, queue_size=1)
        self._infos = Publisher('map_metadata', MapMetaData, latch=True, queue_size=1)
        self._entropy = Publisher('~entropy', Float64, queue_size=1)
        self._transforms = tf2_ros.TransformBroadcaster()
        rospy.Service('dynamic_map', GetMap, self._get)
        self._source = ScanSource(self._on_scan, value['base_frame'], value['odom_frame'],
                                  farthest=value['maxRange'] or -1.0, usable_range=value['maxUrange'] or -1.0)
        if value['transform_publish_period']:
            rospy.Timer(rospy.Duration(value['transform_publish_period']), self._publish_transform, reset=True)
        threading.Thread(target=self._publish_maps, name='maps', daemon=True).start()

    def _on_scan(self, odometry: Pose, scan: Scan, stamp: rospy.Time) -> None:
        self._count += 1
        if self._count % self._value['throttle_scans']:
            return
        with self._lock:
            mapper = self._mapper
            changed = mapper.process(odometry, scan, stamp.to_sec())
            self._odometry_in_map = mapper.pose.then(odometry.inverse())
        if changed:
            self._entropy.publish(mapper.entropy())
            if self._published_at is None or \
                    not 0.0 <= (stamp - self._published_at).to_sec() <= self._value['map_update_interval']:
                self._published_at = stamp
                self._changed.set()

    def _publish_maps(self) -> None:
        while True:
            self._changed.wait()
            self._changed.clear()
            with self._lock:
                grid = self._mapper.to_map(self._value['occ_thresh'])
            message = grids.to_message(grid, self._value['map_frame'])
            self._message = message
            self._grids.publish(message)
            self._infos.publish(message.info)

    def _publish_transform(self, _: rospy.timer.TimerEvent) -> None:
        with self._lock:
            pose = self._odometry_in_map
        stamp = rospy.Time.now() + rospy.Duration(self._value['tf_delay'])
        try:
            self._transforms.sendTransform(to_transform(pose, self._value['map_frame'], self._value['odom_frame'],
                                                        stamp))
        except rospy.ROSException:
            if not rospy.is_shutdown():
                raise

    def _get(self, _: GetMapRequest) -> GetMapResponse:
        if self._message is None:
            raise rospy.ServiceException('there is no map yet: no scan with its transform has arrived')
        return GetMapResponse(grids.as_lists(self._message))


def main() -> None:
    nodes.init_node(NAME, PARAMETERS)
    MappingNode()
    rospy.spin()
