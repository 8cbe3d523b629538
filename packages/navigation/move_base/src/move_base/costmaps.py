"""A costmap of move_base, with its subscribers and publishers. One thread updates it; callbacks only store messages."""
from __future__ import annotations

import collections
import math

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import PolygonStamped
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud2

from move_base import settings
from move_base.conversions import (
    cloud_points,
    costmap_message,
    footprint_message,
    grid_of,
    matrix_of,
    measures,
    pose_of,
    scan_points,
)
from navigation_core.maps.grid_map import GridMap
from navigation_core.planning.costmap import Costmap, Inflation, static_layer
from navigation_core.poses import Array, Pose
from navigation_core.ros import grids
from rospy_support.throttle import WallThrottle

REMINDER = 5.0  # [s] of wall time between two equal warnings
SILENT = 1.0  # [s] without a message of a sensor after which the robot stops; longer if the sensor is slower
KEPT = 5  # messages of a sensor that are kept until their transform is known


class Sensor:
    """One source of observations."""

    def __init__(self, source: settings.Source, throttle: WallThrottle) -> None:
        self.source, self._throttle = source, throttle
        self._messages: collections.deque[LaserScan | PointCloud2] = collections.deque(maxlen=KEPT)
        self._latest: rospy.Time | None = None  # when the last message came that measures something
        self._blind: rospy.Time | None = None  # when the last one came that does not
        kind = LaserScan if source.data_type == 'LaserScan' else PointCloud2
        self._subscriber = rospy.Subscriber(source.topic, kind, self._store, queue_size=1)

    def _store(self, message: LaserScan | PointCloud2) -> None:
        if measures(message):
            self._messages.append(message)
            self._latest = rospy.Time.now()
        else:
            self._blind = rospy.Time.now()

    def silence(self, now: rospy.Time) -> str:
        """Return why the last message is too old, or ''."""
        promised = self.source.expected_update_rate
        allowed = max(SILENT, 2.0 * (promised or 0.0))
        name = self._subscriber.resolved_name
        if self._blind is not None and (self._latest is None or (now - self._latest).to_sec() > allowed) \
                and (now - self._blind).to_sec() <= allowed:
            return f'no range on {name} is a number from range_min to range_max: is the sensor covered, or at a wall?'
        if self._latest is None and promised == 0.0:  # as in the original: a robot without this sensor may drive
            self._throttle.warn(f'unheard {name}', 'No message on %s yet; with expected_update_rate 0 the robot drives '
                                'without it', name)
            return ''
        if self._latest is None:
            return f'no message on {name} yet: start the sensor, or correct the topic of the observation source'
        past = (now - self._latest).to_sec()
        return f'no message on {name} for {past:.1f} s' if past > allowed else ''

    def take(self, buffer: tf2_ros.Buffer, frame: str) -> tuple[tuple[float, float], Array, Array] | None:
        """Return (origin, ends, hits) of the newest message whose transform is known, in ``frame``; or None."""
        problem = None
        for message in reversed([self._messages.popleft() for _ in range(len(self._messages))]):
            sensor = self.source.sensor_frame or message.header.frame_id
            try:
                stamped = buffer.lookup_transform(frame, sensor.lstrip('/'), message.header.stamp)
            except tf2_ros.TransformException as error:
                problem = error
                continue
            return self._in_frame(message, matrix_of(stamped.transform))
        if problem is not None:
            self._throttle.warn(frame, 'Messages on %s cannot be used in the frame %s: %s',
                                self._subscriber.resolved_name, frame, problem)
        return None

    def _in_frame(self, message: LaserScan | PointCloud2, matrix: Array) -> tuple[tuple[float, float], Array, Array]:
        points, hits = (scan_points(message, self.source.inf_is_valid) if self.source.data_type == 'LaserScan'
                        else cloud_points(message))
        points = points @ matrix[:3, :3].T + matrix[:3, 3]
        fits = (points[:, 2] >= self.source.min_obstacle_height) & (points[:, 2] <= self.source.max_obstacle_height)
        return (float(matrix[0, 3]), float(matrix[1, 3])), points[fits, :2], hits[fits]


class CostmapNode:
    """A costmap with its topics: ``global_costmap`` or ``local_costmap``. ``costmap`` is None until it has its map."""

    def __init__(self, name: str, buffer: tf2_ros.Buffer) -> None:
        prefix = f'~{name}/'
        read = {parameter.name[len(prefix):]: parameter.read() for parameter in settings.COSTMAPS
                if parameter.name.startswith(prefix)}
        self.name, self._buffer, self._read = name, buffer, read
        self.frame, self.base = read['global_frame'].lstrip('/'), read['robot_base_frame'].lstrip('/')
        self.footprint = settings.footprint(name)
        self._throttle = WallThrottle(REMINDER)
        self._layers = settings.layers(name)
        self._inflation = Inflation(0.0)
        self.sensors: list[Sensor] = []
        self.map_topic = self._map_frame = ''
        self._map: GridMap | None = None
        self._new_map: OccupancyGrid | None = None
        for space, kind in self._layers:
            self._add_layer(space, kind)
        self.costmap: Costmap | None = None if self._has_map() and not read['rolling_window'] else self._empty()
        self._updated = self._published = rospy.Time()
        self._grid = rospy.Publisher(f'~{name}/costmap', OccupancyGrid, latch=True, queue_size=1)
        self._outline = rospy.Publisher(f'~{name}/footprint', PolygonStamped, latch=True, queue_size=1)

    def _add_layer(self, space: str, kind: str) -> None:
        if kind == settings.INFLATION:
            self._inflation = Inflation(settings.number(f'~{space}/inflation_radius', 0.55, 0.0),
                                        settings.number(f'~{space}/cost_scaling_factor', 10.0, 0.0))
        elif kind == settings.STATIC:
            topic = rospy.get_param(f'~{space}/map_topic', 'map')
            self.map_topic = rospy.resolve_name(topic)
            rospy.Subscriber(topic, grids.Grid, self._store_map, queue_size=1, buff_size=2 ** 25)
        else:
            self.sensors += [Sensor(source, self._throttle) for source in settings.sources(space)]

    def _has_map(self) -> bool:
        return any(kind == settings.STATIC for _, kind in self._layers)

    def _store_map(self, message: OccupancyGrid) -> None:
        self._new_map = message

    def _empty(self) -> Costmap:
        read, resolution = self._read, self._read['resolution']
        width, height = (max(1, round(read[side] / resolution)) for side in ('width', 'height'))
        return Costmap(width, height, resolution, read['origin_x'], read['origin_y'], self.footprint.inscribed,
                       self.footprint.circumscribed, self._inflation, track_unknown=False)

    def missing(self) -> str:
        """Return what is missing before the robot may drive, or ''."""
        if self._has_map() and self._map is None and self._new_map is None:
            return f'no map on {self.map_topic}: start map_server, or a node that makes a map'
        return ''

    def silence(self, now: rospy.Time) -> str:
        """Return why a sensor's data are too old, or ''."""
        return next(filter(None, (sensor.silence(now) for sensor in self.sensors)), '')

    def pose(self) -> tuple[Pose | None, str]:
        """Return the robot's (Pose, '') in this costmap's frame, or (None, why not)."""
        try:
            stamped = self._buffer.lookup_transform(self.frame, self.base, rospy.Time())
        except tf2_ros.TransformException as error:
            return None, f'the transform from {self.base} to {self.frame} is not known: {error}'
        past = (rospy.Time.now() - stamped.header.stamp).to_sec()
        if stamped.header.stamp and past > max(self._read['transform_tolerance'], 0.3):
            return None, f'the transform from {self.base} to {self.frame} is {past:.1f} s old'
        pose = pose_of(stamped.transform)
        if not all(map(math.isfinite, pose)):
            return None, f'the transform from {self.base} to {self.frame} contains NaN'
        return pose, ''

    def update(self, now: rospy.Time, pose: Pose) -> None:
        """Take in the map and the sensors, if it is time; publish."""
        if _due(now, self._updated, self._read['update_frequency']):
            self._updated = now
            self._observe(pose, self._take_map())
        if self.costmap is not None and _due(now, self._published, self._read['publish_frequency']):
            self._published = now
            if self._grid.get_num_connections():
                self._grid.publish(costmap_message(self.costmap, self.frame, now))
            self._outline.publish(footprint_message(self.footprint, pose, self.frame, now))

    def clear(self, pose: Pose, distance: float) -> None:
        """Forget obstacles that were seen farther away than ``distance`` [m] from the robot."""
        if self.costmap is not None:
            self.costmap.forget_beyond(pose.x, pose.y, distance)

    def _take_map(self) -> bool:
        """Take in a map that has come; return whether it is a new one."""
        message, self._new_map = self._new_map, None
        if message is None:
            return False
        try:
            self._map = grid_of(message)
        except ValueError as error:
            rospy.logerr('A map on %s is refused: %s', self.map_topic, error)
            return False
        if message.header.frame_id.lstrip('/') != self.frame and not self._read['rolling_window']:
            rospy.logwarn_once(f'The map on {self.map_topic} is in the frame {message.header.frame_id}, {self.name} in '
                               f'{self.frame}; set ~{self.name}/global_frame')
        if not self._read['rolling_window']:
            new = Costmap.of_map(self._map, self.footprint.inscribed, self.footprint.circumscribed, self._inflation,
                                 self._read['lethal_cost_threshold'], self._read['track_unknown_space'])
            old, self.costmap = self.costmap, new
            if old is not None and (old.shape, old.x, old.y) == (new.shape, new.x, new.y):
                new.seen = old.seen
        self._map_frame = message.header.frame_id.lstrip('/')
        return True

    def _observe(self, pose: Pose, changed: bool) -> None:
        if self.costmap is None:
            return
        rolling = self._read['rolling_window']
        if rolling:
            self.costmap.move_to(pose.x, pose.y)
            if self._map is not None:
                self._sample_map(self._map, self.costmap)
        windows = []
        for sensor in self.sensors:
            taken = sensor.take(self._buffer, self.frame)
            if taken is not None:
                origin, ends, hits = taken
                source = sensor.source
                windows.append(self.costmap.observe(origin, ends, hits & source.marking,
                                                    source.raytrace_range if source.clearing else 0.0,
                                                    source.obstacle_range))
        for window in [None] if rolling or changed else filter(None, windows):
            self.costmap.update(window)

    def _sample_map(self, grid: GridMap, costmap: Costmap) -> None:
        """Fill the static layer of a rolling costmap with the part of the map that lies under it."""
        height, width = costmap.shape
        x, y = costmap.points(*np.meshgrid(np.arange(width), np.arange(height)))
        try:
            stamped = self._buffer.lookup_transform(self._map_frame, self.frame, rospy.Time())
        except tf2_ros.TransformException:
            return
        cells = grid.values(*grid.to_cell(*pose_of(stamped.transform).to_outer(x, y)))
        costmap.static = static_layer(cells, self._read['lethal_cost_threshold'], False)


def _due(now: rospy.Time, last: rospy.Time, rate: float) -> bool:
    """Return whether something that happens ``rate`` times per second, if not 0, has to happen again."""
    return rate > 0.0 and not 0.0 <= (now - last).to_sec() < 1.0 / rate
