"""The parameters of move_base, by the names of the original, its planners and its costmaps."""
from __future__ import annotations

import ast
import math
from types import SimpleNamespace
from typing import Any, NamedTuple, Sequence

import rospy

from navigation_core.planning.footprint import Footprint
from navigation_core.planning.local_planner import Settings
from navigation_core.planning.navigator import Patience
from rospy_support.parameters import Boolean, Integer, Number, Parameter, ParameterError, Table, Text

GLOBAL_PLANNERS = 'navfn/NavfnROS', 'global_planner/GlobalPlanner'
TRAJECTORY, DWA = 'base_local_planner/TrajectoryPlannerROS', 'dwa_local_planner/DWAPlannerROS'
LARGEST = 1000.0  # [m]
FASTEST = 10.0  # [m/s], [rad/s] and per s
RECONFIGURABLE = 'acc_lim_x', 'acc_lim_y', 'acc_lim_theta', 'max_vel_x', 'max_vel_theta', 'xy_goal_tolerance', \
    'yaw_goal_tolerance'


class Unchecked(Parameter):
    """A value of any kind, which its reader checks."""

    kind = 'any'

    def __init__(self, name: str, default: Any, description: str) -> None:
        self.name, self.default, self._description = name, default, description

    @property
    def range(self) -> str:
        return self._description

    def convert(self, value: Any) -> Any:
        return value


OWN = Table(
    Text('~base_global_planner', GLOBAL_PLANNERS[0], GLOBAL_PLANNERS),
    Text('~base_local_planner', TRAJECTORY, (TRAJECTORY, DWA)),
    Number('~controller_frequency', 20.0, 1.0, 100.0, 'Hz'), Number('~planner_frequency', 0.0, 0.0, 100.0, 'Hz'),
    Number('~planner_patience', 5.0, 0.0, 3600.0, 's'), Number('~controller_patience', 15.0, 0.0, 3600.0, 's'),
    Integer('~max_planning_retries', -1, -1, 1e9), Number('~conservative_reset_dist', 3.0, 0.0, LARGEST, 'm'),
    Boolean('~recovery_behavior_enabled', True), Boolean('~clearing_rotation_allowed', True),
    Number('~oscillation_timeout', 0.0, 0.0, 3600.0, 's'), Number('~oscillation_distance', 0.5, 0.0, LARGEST, 'm'))


def _planner(name: str, *more: tuple[str, float, float, float, str]) -> list[Parameter]:
    """Return the parameters that both local planners have."""
    numbers = [('acc_lim_x', 2.5, 0.01, 100.0, 'm/s^2'), ('acc_lim_y', 2.5, 0.0, 100.0, 'm/s^2'),
               ('acc_lim_theta', 3.2, 0.01, 100.0, 'rad/s^2'), ('xy_goal_tolerance', 0.1, 0.005, LARGEST, 'm'),
               ('yaw_goal_tolerance', 0.05 if name == 'TrajectoryPlannerROS' else 0.1, 0.005, 7.0, 'rad'),
               ('sim_time', 1.0 if name == 'TrajectoryPlannerROS' else 1.7, 0.1, 10.0, 's'),
               ('path_distance_bias', 0.6, 0.0, LARGEST, ''), ('goal_distance_bias', 0.8, 0.0, LARGEST, ''),
               ('occdist_scale', 0.01, 0.0, LARGEST, ''), *more]
    return [Number(f'~{name}/{key}', default, lowest, highest, unit)
            for key, default, lowest, highest, unit in numbers] + [
        Boolean(f'~{name}/latch_xy_goal_tolerance', False), Text(f'~{name}/odom_topic', 'odom', filled=True)]


PLANNERS = Table(
    Boolean('~NavfnROS/allow_unknown', True), Number('~NavfnROS/default_tolerance', 0.0, 0.0, LARGEST, 'm'),
    *_planner('TrajectoryPlannerROS', ('max_vel_x', 0.5, 0.0, FASTEST, 'm/s'), ('min_vel_x', 0.1, 0.0, FASTEST, 'm/s'),
              ('max_vel_theta', 1.0, 0.01, FASTEST, 'rad/s'), ('min_in_place_vel_theta', 0.4, 0.0, FASTEST, 'rad/s'),
              ('escape_vel', -0.1, -FASTEST, 0.0, 'm/s')),
    Boolean('~TrajectoryPlannerROS/holonomic_robot', True), Integer('~TrajectoryPlannerROS/vx_samples', 3, 0, 100),
    Integer('~TrajectoryPlannerROS/vtheta_samples', 20, 0, 100),
    Unchecked('~TrajectoryPlannerROS/y_vels', [-0.3, -0.1, 0.1, 0.3], 'a list of speeds'),
    *_planner('DWAPlannerROS', ('max_vel_trans', 0.55, 0.0, FASTEST, 'm/s'), ('max_vel_x', 0.55, 0.0, FASTEST, 'm/s'),
              ('min_vel_x', 0.0, -FASTEST, FASTEST, 'm/s'), ('max_vel_y', 0.1, 0.0, FASTEST, 'm/s'),
              ('min_vel_y', -0.1, -FASTEST, FASTEST, 'm/s'), ('max_vel_theta', 1.0, 0.01, FASTEST, 'rad/s'),
              ('min_vel_theta', 0.4, -FASTEST, FASTEST, 'rad/s'),
              ('forward_point_distance', 0.325, 0.0, 10.0, 'm')),
    Integer('~DWAPlannerROS/vx_samples', 3, 0, 100), Integer('~DWAPlannerROS/vy_samples', 10, 0, 100),
    Integer('~DWAPlannerROS/vth_samples', 20, 0, 100))
OLD_NAMES = {  # of older versions: today's
    'max_rotational_vel': 'max_vel_theta', 'min_in_place_rotational_vel': 'min_in_place_vel_theta',
    'acc_lim_th': 'acc_lim_theta', 'pdist_scale': 'path_distance_bias', 'gdist_scale': 'goal_distance_bias',
    'max_trans_vel': 'max_vel_trans', 'max_rot_vel': 'max_vel_theta', 'min_rot_vel': 'min_vel_theta',
    'vth_samples': 'vtheta_samples'}


def _costmap(name: str) -> list[Parameter]:
    prefix = f'~{name}/'
    return [Text(f'{prefix}global_frame', 'map', filled=True),
            Text(f'{prefix}robot_base_frame', 'base_link', filled=True),
            Number(f'{prefix}transform_tolerance', 0.3, 0.0, 3600.0, 's'),
            Number(f'{prefix}update_frequency', 5.0, 0.1, 100.0, 'Hz'),
            Number(f'{prefix}publish_frequency', 0.0, 0.0, 100.0, 'Hz'),
            Boolean(f'{prefix}rolling_window', False), Boolean(f'{prefix}track_unknown_space', True),
            Integer(f'{prefix}lethal_cost_threshold', 100, 1, 100),
            Number(f'{prefix}width', 10.0, 0.1, LARGEST, 'm'), Number(f'{prefix}height', 10.0, 0.1, LARGEST, 'm'),
            Number(f'{prefix}resolution', 0.05, 0.005, 10.0, 'm'),
            Number(f'{prefix}origin_x', 0.0, -LARGEST, LARGEST, 'm'),
            Number(f'{prefix}origin_y', 0.0, -LARGEST, LARGEST, 'm'),
            Unchecked(f'{prefix}footprint', '', 'corners [x, y]'),
            Number(f'{prefix}footprint_padding', 0.01, 0.0, 10.0, 'm'),
            Number(f'{prefix}robot_radius', 0.46, 0.01, 100.0, 'm'),
            Unchecked(f'{prefix}plugins', '', 'a list of {name: NAME, type: TYPE}')]


COSTMAPS = Table(*_costmap('global_costmap'), *_costmap('local_costmap'))
PARAMETERS = Table(OWN, PLANNERS, COSTMAPS)
LAYERS = STATIC, OBSTACLE, VOXEL, INFLATION = tuple(
    f'costmap_2d::{kind}Layer' for kind in ('Static', 'Obstacle', 'Voxel', 'Inflation'))
DATA_TYPES = 'LaserScan', 'PointCloud2'


class Source(NamedTuple):
    """A sensor of an obstacle layer."""

    topic: str
    data_type: str
    sensor_frame: str
    marking: bool
    clearing: bool
    inf_is_valid: bool
    min_obstacle_height: float
    max_obstacle_height: float
    obstacle_range: float
    raytrace_range: float
    expected_update_rate: float | None  # [s]; None: not given; 0: it may never be heard


def error(name: str, value: Any, allowed: str) -> ParameterError:
    return ParameterError(f'parameter {rospy.resolve_name(name)} is {value!r}; it must be {allowed}')


def rename_old() -> None:
    """Copy parameters with names of older versions to today's names, if these are not set."""
    known = {parameter.name for parameter in PLANNERS}
    for planner in ('TrajectoryPlannerROS', 'DWAPlannerROS'):
        given = rospy.get_param(f'~{planner}', {})
        for old, new in OLD_NAMES.items() if isinstance(given, dict) else ():
            if old in given and new not in given and f'~{planner}/{old}' not in known:
                rospy.set_param(f'~{planner}/{new}', given[old])


def patience() -> Patience:
    names = [name for name in Patience.__dataclass_fields__ if name != 'aggressive_reset_dist']
    return Patience(**{name: OWN[f'~{name}'].read() for name in names})


def planner() -> tuple[str, Settings, str]:
    """Return (name of the local planner, its Settings, the topic of odometry)."""
    name = OWN['~base_local_planner'].read().rpartition('/')[2]
    prefix = f'~{name}/'
    given = SimpleNamespace(**{parameter.name[len(prefix):]: parameter.read() for parameter in PLANNERS
                               if parameter.name.startswith(prefix)})
    for key in [key for key in vars(given) if key.endswith('_samples')]:
        setattr(given, key, max(1, getattr(given, key)))  # 0 is 1, as in the original: TurtleBot3 has vy_samples 0
    settings = Settings(**{key: value for key, value in vars(given).items() if key in Settings.__dataclass_fields__})
    if name == 'DWAPlannerROS':
        settings.min_vel_theta = abs(given.min_vel_theta)
    else:
        sideways = _speeds(f'{prefix}y_vels', given.y_vels) if given.holonomic_robot else [0.0]
        settings.max_vel_trans, settings.max_vel_y, settings.min_vel_y = given.max_vel_x, max(sideways), min(sideways)
        settings.min_vel_theta = given.min_in_place_vel_theta
        settings.vy_samples, settings.vth_samples = 2 * len(sideways) + 1, given.vtheta_samples
        if given.holonomic_robot:
            settings.min_vel_x = given.escape_vel
    if settings.max_vel_trans <= 0.0 or settings.max_vel_x <= 0.0:
        raise error(f'{prefix}max_vel_x', settings.max_vel_x, 'more than 0, or the robot cannot drive')
    return name, settings, given.odom_topic


def _speeds(name: str, value: Any) -> list[float]:
    """Return the y_vels, a list or, as in older files, a text of numbers."""
    try:
        speeds = [float(speed) for speed in (value.replace(',', ' ').split() if isinstance(value, str) else value)]
    except (TypeError, ValueError):
        speeds = [math.nan]
    if not all(map(math.isfinite, speeds)) or not speeds:
        raise error(name, value, 'a list of speeds [m/s], such as [-0.3, -0.1, 0.1, 0.3]')
    return speeds


def footprint(name: str) -> Footprint:
    key = f'~{name}/footprint'
    given, padding, radius = COSTMAPS.read(*(f'~{name}/{field}' for field in (
        'footprint', 'footprint_padding', 'robot_radius')))
    if given in ('', [], None):
        return Footprint.disc(radius + padding)
    try:
        return Footprint.polygon(ast.literal_eval(given) if isinstance(given, str) else given, padding)
    except (SyntaxError, TypeError, ValueError):
        raise error(key, given, 'a list of at least three corners around the middle of the robot [m], such as '
                    '[[-0.2, -0.2], [-0.2, 0.2], [0.2, 0.2], [0.2, -0.2]]') from None


def layers(name: str) -> list[tuple[str, str]]:
    """Return [(namespace, type)] of the layers of a costmap: those of ``plugins``, or those of older versions."""
    plugins = COSTMAPS[f'~{name}/plugins'].read()
    if plugins in ('', None, []):
        static = rospy.get_param(f'~{name}/static_map', True)
        if static not in (True, False):
            raise error(f'~{name}/static_map', static, 'true or false')
        return [(name, kind) for kind in (STATIC, OBSTACLE, INFLATION) if static or kind != STATIC]
    listed = []
    for plugin in plugins if isinstance(plugins, list) else [None]:
        if not isinstance(plugin, dict) or not {'name', 'type'} <= plugin.keys():
            raise error(f'~{name}/plugins', plugins,
                        'a list such as [{name: static_layer, type: "costmap_2d::StaticLayer"}]')
        if plugin['type'] not in LAYERS:
            raise error(f'~{name}/plugins', plugin['type'], f'one of {", ".join(LAYERS)}')
        listed.append((f'{name}/{plugin["name"]}', plugin['type']))
    return listed


def number(name: str, default: float, minimum: float = -LARGEST, maximum: float = LARGEST) -> float:
    """Return a number whose name depends on other parameters."""
    value = rospy.get_param(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise error(name, value, f'a number from {minimum:g} to {maximum:g}')
    return float(value)


def _text(name: str, default: str, choices: Sequence[str] = ()) -> str:
    value = rospy.get_param(name, default)
    if not isinstance(value, str) or choices and value not in choices:
        raise error(name, value, f'one of {", ".join(choices)}' if choices else 'a text')
    return value


def _boolean(name: str, default: bool) -> bool:
    value = rospy.get_param(name, default)
    if not isinstance(value, bool):
        raise error(name, value, 'true or false')
    return value


def sources(layer: str) -> list[Source]:
    """Return the Sources of an obstacle layer."""
    listed = []
    for name in _text(f'~{layer}/observation_sources', '').split():
        space = f'~{layer}/{name}/'
        promised = number(f'{space}expected_update_rate', 0.0, 0.0) if rospy.has_param(
            f'{space}expected_update_rate') else None
        listed.append(Source(
            _text(f'{space}topic', name), _text(f'{space}data_type', 'PointCloud2', DATA_TYPES),
            _text(f'{space}sensor_frame', ''), _boolean(f'{space}marking', True), _boolean(f'{space}clearing', False),
            _boolean(f'{space}inf_is_valid', False), number(f'{space}min_obstacle_height', 0.0),
            number(f'{space}max_obstacle_height', number(f'~{layer}/max_obstacle_height', 2.0)),
            number(f'{space}obstacle_range', number(f'~{layer}/obstacle_range', 2.5)),
            number(f'{space}raytrace_range', number(f'~{layer}/raytrace_range', 3.0)),
            promised))
    return listed
