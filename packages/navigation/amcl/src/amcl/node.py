"""The node amcl: finds where a robot is in a known map, from its laser scans and odometry.

Threading contract: rospy's threads of scan, map, initialpose and the services; each takes the one lock and then uses
the filter.
"""
from __future__ import annotations

import math
import threading

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMap, SetMap, SetMapRequest, SetMapResponse
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse

from navigation_core.localisation import motion, sensor
from navigation_core.localisation.particle_filter import Estimate, ParticleFilter, Settings
from navigation_core.localisation.sensor import MeasuredMap, SensorModel
from navigation_core.poses import Array, Pose
from navigation_core.ros import grids
from navigation_core.ros.poses import from_pose, to_pose, to_transform
from navigation_core.ros.scan_source import ScanSource
from navigation_core.scans import Scan
from rospy_support import nodes, parameters
from rospy_support.parameters import Boolean, Integer, Number, ParameterError, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import Publisher

NAME = 'amcl'
ALPHAS = [Number(f'~odom_alpha{number}', 0.2, 0.0, 10.0) for number in range(1, 6)]
FILTER = Table(
    Integer('~min_particles', 100, 1, 100_000), Integer('~max_particles', 5000, 1, 100_000),
    Number('~kld_err', 0.01, 1e-4, 1.0), Number('~kld_z', 0.99, 0.5, 0.999999), *ALPHAS,
    Text('~odom_model_type', 'diff', motion.MODELS), Number('~recovery_alpha_slow', 0.0, 0.0, 1.0),
    Number('~recovery_alpha_fast', 0.0, 0.0, 1.0), Integer('~resample_interval', 2, 1, 1000))
LASER = Table(
    Text('~laser_model_type', sensor.FIELD, sensor.MODELS), Integer('~laser_max_beams', 30, 2, 10_000),
    Number('~laser_z_hit', 0.95, 0.0, 1.0), Number('~laser_z_short', 0.1, 0.0, 1.0),
    Number('~laser_z_max', 0.05, 0.0, 1.0), Number('~laser_z_rand', 0.05, 0.0, 1.0),
    Number('~laser_sigma_hit', 0.2, 1e-3, 10.0, 'm'), Number('~laser_lambda_short', 0.1, 0.0, 100.0),
    Number('~laser_likelihood_max_dist', 2.0, 0.01, 100.0, 'm'), Number('~laser_min_range', -1.0, -1.0, 1000.0, 'm'),
    Number('~laser_max_range', -1.0, -1.0, 1000.0, 'm'))
INITIAL = Table(
    Number('~initial_pose_x', 0.0, unit='m'), Number('~initial_pose_y', 0.0, unit='m'),
    Number('~initial_pose_a', 0.0, unit='rad'), Number('~initial_cov_xx', 0.25, 0.0, 1e6, 'm^2'),
    Number('~initial_cov_yy', 0.25, 0.0, 1e6, 'm^2'),
    Number('~initial_cov_aa', (math.pi / 12.0) ** 2, 0.0, 1e6, 'rad^2'))
OTHERS = Table(
    Number('~update_min_d', 0.2, 0.0, 100.0, 'm'), Number('~update_min_a', math.pi / 6.0, 0.0, 2.0 * math.pi, 'rad'),
    Number('~transform_tolerance', 0.1, 0.0, 10.0, 's'), Text('~odom_frame_id', 'odom', filled=True),
    Text('~base_frame_id', 'base_link', filled=True), Text('~global_frame_id', 'map', filled=True),
    Boolean('~use_map_topic', False), Boolean('~first_map_only', False), Boolean('~tf_broadcast', True))
ACCEPTED = Table(Number('~gui_publish_rate', -1.0), Number('~save_pose_rate', 0.5), Boolean('~do_beamskip', False),
                 Number('~beam_skip_distance', 0.5), Number('~beam_skip_threshold', 0.3),
                 Boolean('~selective_resampling', False), Boolean('~force_update_after_initialpose', False),
                 Boolean('~force_update_after_set_map', False), Number('~std_warn_level_x', 0.2),
                 Number('~std_warn_level_y', 0.2), Number('~std_warn_level_yaw', 0.1),
                 Number('~bag_scan_period', -1.0), Boolean('~restore_defaults', False))  # without effect
PARAMETERS = Table(FILTER, LASER, INITIAL, OTHERS, ACCEPTED)
MAP_PERIOD = 0.5  # [s] between two requests for the map
REPEAT = 15.0  # [s] between two equal warnings


class LocalisationNode:
    """amcl's interface on a ParticleFilter."""

    def __init__(self) -> None:
        self._value = value = {parameter.name[1:]: parameter.read() for parameter in PARAMETERS}
        if value['min_particles'] > value['max_particles']:
            raise ParameterError(f'parameter {rospy.resolve_name("~min_particles")} is {value["min_particles"]}; it '
                                 f'must be at most max_particles, which is {value["max_particles"]}')
        parameters.log_effective()
        self._settings = Settings(
            value['min_particles'], value['max_particles'], value['kld_err'], value['kld_z'],
            tuple(value[parameter.name[1:]] for parameter in ALPHAS), value['odom_model_type'],
            value['recovery_alpha_slow'], value['recovery_alpha_fast'], value['resample_interval'])
        self._frame = value['global_frame_id'].lstrip('/')
        self._throttle = WallThrottle(REPEAT)
        self._lock = threading.RLock()
        self._filter: ParticleFilter | None = None
        self._last: Pose | None = None  # the odometry's pose of the last scan that was used
        self._forced = True
        # when the particles were placed or spread; ROS does not order a scan of this time and that
        self._begun: rospy.Time | None = None
        self._odometry_in_map: Pose | None = None
        self._start: tuple[Pose, Array] = (
            Pose(value['initial_pose_x'], value['initial_pose_y'], value['initial_pose_a']),
            np.diag([value['initial_cov_xx'], value['initial_cov_yy'], value['initial_cov_aa']]))
        self._poses = Publisher('amcl_pose', PoseWithCovarianceStamped, latch=True, queue_size=2)
        self._cloud = Publisher('particlecloud', PoseArray, latch=True, queue_size=2)
        self._transforms = tf2_ros.TransformBroadcaster()
        rospy.Service('global_localization', Empty, self._spread)
        rospy.Service('request_nomotion_update', Empty, self._force)
        rospy.Service('set_map', SetMap, self._set_map)
        self._source = ScanSource(self._on_scan, value['base_frame_id'].lstrip('/'), value['odom_frame_id'].lstrip('/'),
                                  value['laser_min_range'], value['laser_max_range'])
        rospy.Subscriber('initialpose', PoseWithCovarianceStamped, self._on_initial_pose, queue_size=2)
        if value['use_map_topic']:
            rospy.Subscriber('map', grids.Grid, self._on_map, queue_size=1, buff_size=2 ** 25)
            rospy.loginfo('Subscribed to map topic.')

    def run(self) -> None:
        """Request the map if it does not come as a topic, and spin until shutdown."""
        if not self._value['use_map_topic']:
            self._request_map()
        rospy.spin()

    def _request_map(self) -> None:
        get_map = rospy.ServiceProxy('static_map', GetMap)
        rospy.loginfo('Requesting the map...')
        while not rospy.is_shutdown():
            try:
                return self._use_map(get_map().map)
            except rospy.ServiceException:
                self._throttle.warn('map', 'Request for map failed; trying again... Start rosrun map_server map_server '
                                    'MAP.yaml, which offers %s', get_map.resolved_name)
            except ValueError as error:
                rospy.logerr('The map of %s cannot be used: %s. Waiting for another one on set_map',
                             get_map.resolved_name, error)
                return None
            rospy.sleep(MAP_PERIOD)

    def _on_map(self, message: OccupancyGrid) -> None:
        if self._filter is not None and self._value['first_map_only']:
            return
        try:
            self._use_map(message)
        except ValueError as error:
            self._throttle.warn('bad map', 'Ignored a map: %s', error)

    def _use_map(self, message: OccupancyGrid, start: tuple[Pose, Array] | None = None) -> None:
        """Start again on the map of an OccupancyGrid, at the last pose of the robot; raise ValueError."""
        grid, value = grids.from_message(message), self._value
        rospy.loginfo('Received a %d X %d map @ %.3f m/pix', grid.width, grid.height, grid.resolution)
        farthest = value['laser_max_range'] if value['laser_max_range'] > 0.0 else 30.0
        model = SensorModel(value['laser_model_type'], value['laser_max_beams'], value['laser_z_hit'],
                            value['laser_z_short'], value['laser_z_max'], value['laser_z_rand'],
                            value['laser_sigma_hit'], value['laser_lambda_short'], value['laser_likelihood_max_dist'],
                            farthest)
        measured = MeasuredMap(grid, model.max_distance)
        with self._lock:
            self._start = start or self._start
            self._filter = ParticleFilter(measured, self._settings, model)
            self._place(*self._start)

    def _place(self, pose: Pose, covariance: Array) -> None:
        self._start = pose, covariance
        if self._filter:
            self._filter.place(pose, covariance)
            self._begin()
            self._odometry_in_map = None

    def _begin(self) -> None:
        self._last, self._forced, self._begun = None, True, rospy.Time.now()

    def _set_map(self, request: SetMapRequest) -> SetMapResponse:
        try:
            self._use_map(request.map, self._read_pose(request.initial_pose))
        except ValueError as error:
            rospy.logerr('The map of a call of set_map cannot be used: %s', error)
            return SetMapResponse(False)
        return SetMapResponse(True)

    def _on_initial_pose(self, message: PoseWithCovarianceStamped) -> None:
        frame = message.header.frame_id.lstrip('/')
        try:
            if frame and frame != self._frame:
                raise ValueError(f'its frame is {frame}; it must be {self._frame}. In rviz, set Fixed Frame to it')
            pose, covariance = self._read_pose(message)
        except ValueError as error:
            self._throttle.warn('pose', 'Ignored a pose on initialpose: %s', error)
            return
        rospy.loginfo('Setting pose (%.6f): %.3f %.3f %.3f', rospy.get_time(), pose.x, pose.y, pose.yaw)
        with self._lock:
            self._place(pose, covariance)

    def _read_pose(self, message: PoseWithCovarianceStamped) -> tuple[Pose, Array]:
        covariance = np.array(message.pose.covariance).reshape(6, 6)[np.ix_((0, 1, 5), (0, 1, 5))]
        if not np.isfinite(covariance).all():
            raise ValueError('its covariance has numbers that are not finite')
        return to_pose(message.pose.pose), covariance

    def _spread(self, _: EmptyRequest) -> EmptyResponse:
        with self._lock:
            if self._filter is None:
                raise rospy.ServiceException('there is no map yet')
            rospy.loginfo('Initializing with uniform distribution')
            self._filter.spread()
            self._begin()
        return EmptyResponse()

    def _force(self, _: EmptyRequest) -> EmptyResponse:
        self._forced = True
        return EmptyResponse()

    def _on_scan(self, odometry: Pose, scan: Scan, stamp: rospy.Time) -> None:
        with self._lock:
            if self._filter is None:
                self._throttle.warn('no map', 'No map yet, so scans are ignored')
                return
            step = self._last.step_to(odometry) if self._last else Pose()
            if stamp != self._begun and (self._forced or math.hypot(step.x, step.y) > self._value['update_min_d']
                                         or abs(step.yaw) > self._value['update_min_a']):
                initial = None if self._last else self._filter.estimate()
                self._forced, self._last = False, odometry
                self._filter.update(step, scan)
                # as in the original, the first scan does not move the estimate
                self._publish(initial or self._filter.estimate(), self._filter.particles, odometry, stamp)
            if self._value['tf_broadcast'] and self._odometry_in_map:
                self._transforms.sendTransform(to_transform(
                    self._odometry_in_map, self._frame, self._value['odom_frame_id'],
                    stamp + rospy.Duration(self._value['transform_tolerance'])))

    def _publish(self, estimate: Estimate, particles: Array, odometry: Pose, stamp: rospy.Time) -> None:
        self._odometry_in_map = estimate.pose.then(odometry.inverse())
        self._start = estimate.pose, estimate.covariance  # where the next map starts
        message = PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = stamp, self._frame
        message.pose.pose = from_pose(estimate.pose)
        covariance = np.zeros((6, 6))
        covariance[np.ix_((0, 1, 5), (0, 1, 5))] = estimate.covariance
        message.pose.covariance = covariance.ravel().tolist()
        self._poses.publish(message)
        cloud = PoseArray(poses=[from_pose(Pose(*particle)) for particle in particles.tolist()])
        cloud.header = message.header
        self._cloud.publish(cloud)


def main() -> None:
    nodes.init_node(NAME, PARAMETERS)
    LocalisationNode().run()
