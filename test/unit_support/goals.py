"""Goals in the minimaze, without ROS: the planners of move_base with a simulated robot, laser scanner and walls.

Map and pose are the true ones, so that only planning and following are measured. Settings are those of
robotont_navigation. Units: m, rad, s.
"""
import math
import time
from typing import NamedTuple

import numpy as np
import yaml

from kinematic_core.worlds import rays
from kinematic_core.worlds.frames import LIDAR_X, LIDAR_Z, ahead
from kinematic_core.worlds.robot_world import RobotWorld
from navigation_core.maps.scores import true_map
from navigation_core.planning import global_planner
from navigation_core.planning.costmap import Costmap, Inflation
from navigation_core.planning.footprint import Footprint
from navigation_core.planning.local_planner import LocalPlanner, Settings, Velocity
from navigation_core.planning.navigator import Navigator, Patience, State
from navigation_core.poses import Pose, wrap
from unit_support import REPOSITORY, maze_drive

CONFIG = REPOSITORY / 'packages' / 'navigation' / 'robotont_navigation' / 'config'
RESOLUTION = 0.05  # [m] a cell of the map
LONGEST = 120.0  # [s] for a goal
CLOSE = 0.1  # [m, rad]
DETOUR = 1.2  # times the shortest path
SHORT = 0.5  # [m] shorter paths are not compared
OBSERVE, CONTROL = 0.2, 0.1  # [s] between two scans, two commands


class Drive(NamedTuple):
    """The result of a drive to a goal."""

    reached: bool
    distance: float  # [m] from the goal at the end
    turn: float  # [rad] likewise
    collisions: int  # steps in which the robot touched a wall
    length: float  # [m]
    shortest: float  # [m]
    seconds: float
    control: list  # [s] of processor time of each command
    plans: list  # [s] the same of each plan

    @property
    def good(self):
        """Whether it meets all targets."""
        return (self.reached and self.distance < CLOSE and self.turn < CLOSE and not self.collisions
                and self.length <= DETOUR * max(self.shortest, SHORT))


def configured():
    """Return (Settings, Patience, Footprint, Inflation) of robotont_navigation."""
    local, common, planner = (yaml.safe_load((CONFIG / name).read_text()) for name in (
        'planner_local_params.yaml', 'costmap_common_params.yaml', 'planner_global_params.yaml'))
    given = local['TrajectoryPlannerROS']
    shared = {key: given[key] for key in given.keys() & Settings.__dataclass_fields__.keys()}
    settings = Settings(**{**shared, 'max_vel_trans': given['max_vel_x'], 'min_vel_x': given['escape_vel'],
                           'min_vel_y': min(given['y_vels']), 'max_vel_y': max(given['y_vels']),
                           'vy_samples': 2 * len(given['y_vels']) + 1, 'vth_samples': given['vtheta_samples'],
                           'min_vel_theta': given['min_in_place_vel_theta']})
    patience = Patience(planner_frequency=planner['planner_frequency'], planner_patience=planner['planner_patience'],
                        controller_patience=local['controller_patience'])
    layer = common['inflation_layer']
    return (settings, patience, Footprint.disc(common['robot_radius'] + common['footprint_padding']),
            Inflation(layer['inflation_radius'], layer['cost_scaling_factor']))


class SimulatedRobot:
    """A robot in the minimaze and the World of its Navigator."""

    def __init__(self, seed, start=maze_drive.START, unmapped=()):
        """``unmapped``: Boxes that are not on the map."""
        mapped = maze_drive.plan()
        plan = mapped._replace(boxes=(*mapped.boxes, *unmapped))
        self.settings, patience, footprint, inflation = configured()
        self.world = RobotWorld(plan, start, watchdog=math.inf)
        self._scanner = rays.LaserScanner(plan, LIDAR_Z, seed=seed)
        grid, radius = true_map(maze_drive.walls(), RESOLUTION), footprint.inscribed
        self.costmap = Costmap.of_map(grid, radius, radius, inflation)
        self.local = Costmap(80, 80, RESOLUTION, inscribed=radius, reach=radius, inflation=inflation,
                             track_unknown=False)
        self._shortest = Costmap.of_map(grid, radius, radius, Inflation(radius, 1.0))
        self._planner = LocalPlanner(self.settings, footprint, CONTROL)
        self._navigator = Navigator(self, patience)
        self.plans = []

    @property
    def pose(self):
        return Pose(*self.world.pose)

    def plan(self, goal):
        begun = time.process_time()
        plan = global_planner.plan(self.costmap, self.pose[:2], goal[:2], 0.1)
        self.plans.append(time.process_time() - begun)
        return plan

    def shortest(self, goal):
        """Return the length [m] of the shortest path to a goal; None if there is none."""
        path = global_planner.plan(self._shortest, self.pose[:2], goal[:2]).path
        return None if path is None or global_planner.plan(self.costmap, self.pose[:2], goal[:2]).path is None \
            else global_planner.length(path)

    def is_hopeless(self, goal):
        return False

    def follow(self, path, heading, new):
        if new:
            self._planner.start()
        choice = self._planner.choose(self.local, self.pose, Velocity(*self.world.twist), path, heading)
        return choice, self._planner.reached

    def turn(self, angle):
        return self._planner.turn(self.local, self.pose, Velocity(*self.world.twist), angle)

    def clear(self, distance):
        for costmap in (self.costmap, self.local):
            costmap.forget_beyond(*self.pose[:2], distance)

    def observe(self):
        """Take a scan into both costmaps."""
        pose = self.pose
        sensor = ahead(self.world.pose, LIDAR_X)
        ranges = self._scanner.scan(*sensor, pose.yaw)
        hits = np.isfinite(ranges)
        ranges = np.where(hits, ranges, rays.FARTHEST)
        angles = np.linspace(rays.FIRST_ANGLE, rays.LAST_ANGLE, rays.RAYS) + pose.yaw
        ends = np.stack([sensor[0] + ranges * np.cos(angles), sensor[1] + ranges * np.sin(angles)], axis=1)
        self.local.move_to(pose.x, pose.y)
        self.costmap.update(self.costmap.observe(sensor, ends, hits, 3.0, 2.5))
        self.local.observe(sensor, ends, hits, 3.0, 2.5)
        self.local.update()

    def drive(self, goal):
        """Drive to a goal Pose; return the Drive."""
        shortest, world, begin = self.shortest(goal), self.world, self.world.time
        self._navigator.start(goal, self.pose, begin)
        control, collisions, length, observed, self.plans = [], 0, 0.0, -math.inf, []
        while world.time < begin + LONGEST and self._navigator.state not in (State.REACHED, State.FAILED):
            begun = time.process_time()
            if world.time >= observed + OBSERVE - 1e-9:
                self.observe()
                observed = world.time
            velocity = self._navigator.step(self.pose, world.time).velocity
            control.append(time.process_time() - begun)
            world.command(*velocity)
            for _ in range(round(CONTROL / world.dt)):
                before = world.pose
                world.step()
                collisions += world.touching
                length += math.dist(before[:2], world.pose[:2])
        pose = self.pose
        return Drive(self._navigator.state == State.REACHED, math.dist(pose[:2], goal[:2]),
                     abs(float(wrap(pose.yaw - goal.yaw))), collisions, length, shortest, world.time - begin, control,
                     self.plans)
