"""Velocities along a path: the dynamic window approach, for holonomic robots and for others.

Velocities that the robot can reach within one period are tried; each is followed as an arc for ``sim_time``. Of those
that touch no obstacle the one is chosen whose end is near to the path, far along it, and away from obstacles. Poses and
paths are in the frame of the local costmap, velocities in the robot's frame.
"""
import dataclasses
import math
from typing import NamedTuple, Optional, Tuple

import numpy as np

from navigation_core.planning.costmap import FREE, LETHAL, UNKNOWN, Costmap
from navigation_core.planning.footprint import Footprint
from navigation_core.poses import Array, Pose, wrap

SAME_CLEARANCE = 2e-3  # [m] errors of the interpolation: cv2.remap divides cells by 32
STILL = 1e-3  # [m/s, rad/s]


class Velocity(NamedTuple):
    """x forward, y to the left [m/s], theta counter-clockwise [rad/s]."""

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    @property
    def is_zero(self) -> bool:
        """Whether it moves nothing."""
        return max(map(abs, self)) < STILL


@dataclasses.dataclass
class Settings:
    """The limits of the robot and the weights of the planner; fields are named as the parameters of DWAPlannerROS."""

    min_vel_x: float = 0.0  # [m/s]; negative: it may drive backwards
    max_vel_x: float = 0.5
    min_vel_y: float = 0.0
    max_vel_y: float = 0.0
    max_vel_trans: float = 0.5
    max_vel_theta: float = 1.0  # [rad/s]
    min_vel_theta: float = 0.0  # [rad/s] of turning on the spot
    acc_lim_x: float = 2.5  # [m/s^2]
    acc_lim_y: float = 2.5
    acc_lim_theta: float = 3.2  # [rad/s^2]
    xy_goal_tolerance: float = 0.1  # [m]
    yaw_goal_tolerance: float = 0.1  # [rad]
    latch_xy_goal_tolerance: bool = False
    sim_time: float = 1.7  # [s]
    vx_samples: int = 3
    vy_samples: int = 10
    vth_samples: int = 20
    path_distance_bias: float = 0.6
    goal_distance_bias: float = 0.8
    occdist_scale: float = 0.01
    forward_point_distance: float = 0.325  # [m]


class Choice(NamedTuple):
    """A velocity, the poses (n, 3) that it leads through, and, if there is none to choose, the reason."""

    velocity: Optional[Velocity]
    poses: Array = np.empty((0, 3))
    problem: str = ''


class LocalPlanner:
    """Follows one path after the other. ``reached`` says whether the end of the path was reached, with its heading."""

    def __init__(self, settings: Settings, footprint: Footprint, period: float) -> None:
        """``period`` [s]: time between two commands. ``settings`` may be changed while it drives."""
        self.settings, self.footprint, self.period = settings, footprint, period
        self.reached = False
        self._on_the_spot = False  # it has reached the goal's position and turns

    def start(self) -> None:
        """Forget what was reached before."""
        self.reached = self._on_the_spot = False

    def choose(self, costmap: Costmap, pose: Pose, velocity: Velocity, path: Array, heading: float) -> Choice:
        """Return the Choice for the next period; zero at the goal.

        ``path`` (n, 2) [m] ends at the goal, ``heading`` [rad] is the one asked for there.
        """
        settings = self.settings
        away = math.dist(path[-1], pose[:2])
        latched = self._on_the_spot and (settings.latch_xy_goal_tolerance or away <= 1.5 * settings.xy_goal_tolerance)
        self._on_the_spot = latched or away <= settings.xy_goal_tolerance
        if self._on_the_spot:
            return self._turn_to(costmap, pose, velocity, heading)
        return self._follow(costmap, pose, velocity, ahead(path, pose, self._lookahead()))

    def turn(self, costmap: Costmap, pose: Pose, velocity: Velocity, angle: float) -> Choice:
        """Return the Choice for turning on the spot by ``angle`` [rad], which may be more than one turn."""
        settings = self.settings
        speed = math.copysign(min(settings.max_vel_theta, math.sqrt(2.0 * settings.acc_lim_theta * abs(angle)),
                                  max(abs(angle) / self.period, STILL)), angle)
        if abs(angle) / self.period > settings.min_vel_theta > abs(speed):
            speed = math.copysign(settings.min_vel_theta, angle)
        change = settings.acc_lim_theta * self.period
        wanted = Velocity(_towards(velocity.x, settings.acc_lim_x * self.period),
                          _towards(velocity.y, settings.acc_lim_y * self.period),
                          float(np.clip(speed, velocity.theta - change, velocity.theta + change)))
        poses = trajectories(np.array([wanted]), pose, self._times(1.0))
        if not self.free(costmap, poses)[0]:
            return Choice(None, poses[0], 'the robot has no room to turn on the spot')
        return Choice(wanted, poses[0])

    def free(self, costmap: Costmap, poses: Array) -> Array:
        """Return whether the robot touches no obstacle on each of several paths, poses (paths, n, 3).

        A robot that touches one at the first pose is free on paths that do not lead closer. Unknown cells are free.
        """
        required = self.footprint.inscribed
        clearance = costmap.clearances(poses[..., 0], poses[..., 1])
        first = float(clearance.flat[0])
        if first < required:
            result: Array = clearance.min(axis=1) >= first - SAME_CLEARANCE
            return result
        result = clearance.min(axis=1) >= required
        if not self.footprint.is_round:
            close = (clearance < self.footprint.circumscribed + costmap.resolution) & result[:, None]
            number, step = np.nonzero(close)
            touching = self._outline_touches(costmap, poses[number, step])
            if touching.any() and touching[step == 0].any():  # rotated into an obstacle: any way out is allowed
                return result & (clearance[:, -1] >= clearance[:, 0])
            result[number[touching]] = False
        return result

    def _outline_touches(self, costmap: Costmap, poses: Array) -> Array:
        outline = self.footprint.outline(costmap.resolution)
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x = poses[:, :1] + cos * outline[:, 0] - sin * outline[:, 1]
        y = poses[:, 1:2] + sin * outline[:, 0] + cos * outline[:, 1]
        touching: Array = (costmap.sample(costmap.costs, x, y, 0) == LETHAL).any(axis=1)
        return touching

    def _lookahead(self) -> float:
        """Return the length [m] of the part of the path that is looked at."""
        settings = self.settings
        return settings.max_vel_trans * settings.sim_time + settings.forward_point_distance + 0.2

    def _times(self, sim_time: float) -> Array:
        """Return the times [s] of the poses of a trajectory."""
        fastest = max(self.settings.max_vel_trans, self.settings.max_vel_theta * self.footprint.circumscribed)
        return np.linspace(0.0, sim_time, max(2, math.ceil(sim_time * fastest / 0.05) + 1))

    def _braking(self, samples: Array, pose: Pose) -> Array:
        """Return the poses of velocities that are held for a period, and then for half the time of braking."""
        settings = self.settings
        limits = np.maximum([settings.acc_lim_x, settings.acc_lim_y, settings.acc_lim_theta], STILL)
        lasting = self.period + 0.5 * (np.abs(samples) / limits).max(axis=1)
        return trajectories(samples, pose, np.linspace(0.0, 1.0, 11) * lasting[:, None])

    def _turn_to(self, costmap: Costmap, pose: Pose, velocity: Velocity, heading: float) -> Choice:
        error = float(wrap(heading - pose.yaw))
        if abs(error) > self.settings.yaw_goal_tolerance:
            return self.turn(costmap, pose, velocity, error)
        self.reached = max(map(abs, velocity)) < 0.1
        return Choice(Velocity()) if self.reached else self.turn(costmap, pose, velocity, 0.0)

    def _follow(self, costmap: Costmap, pose: Pose, velocity: Velocity, path: Array) -> Choice:
        samples = self._samples(velocity, path, pose)
        poses = trajectories(samples, pose, self._times(self.settings.sim_time))
        free = self.free(costmap, poses)
        costs = self._costs(costmap, poses, path)
        if not free.any():  # the slowest that leaves room to stop
            free, costs = self.free(costmap, self._braking(samples, pose)), np.abs(samples).sum(axis=1)
        if not free.any():
            return Choice(None, problem='every velocity that the robot can reach leads into an obstacle')
        best = int(np.argmin(np.where(free, costs, np.inf)))
        chosen = Velocity(*map(float, samples[best]))
        if chosen.is_zero and velocity.is_zero:
            return Choice(None, problem='an obstacle is on the path')
        return Choice(chosen, poses[best])

    def _costs(self, costmap: Costmap, poses: Array, path: Array) -> Array:
        """Return the cost of each trajectory: of its end, of the heading there, and of the worst cell on it."""
        settings = self.settings
        end = poses[:, -1]
        beside, before = along(path, end[:, :2])
        costs: Array = settings.path_distance_bias * beside + settings.goal_distance_bias * before
        to_x, to_y = path[-1, 0] - end[:, 0], path[-1, 1] - end[:, 1]
        turn = np.abs(wrap(np.arctan2(to_y, to_x) - end[:, 2]))
        forward = settings.forward_point_distance
        costs += settings.path_distance_bias * turn * np.minimum(forward, np.hypot(to_x, to_y))
        worst = _known(costmap.sample(costmap.costs, poses[..., 0], poses[..., 1], 0)).max(axis=1)
        needed = _known(costmap.sample(costmap.costs, path[:, 0], path[:, 1], 0)).max()  # or goals at walls repel it
        costs += settings.occdist_scale * np.maximum(worst - needed, 0.0) * costmap.resolution
        return costs

    def _samples(self, velocity: Velocity, path: Array, pose: Pose) -> Array:
        """Return the velocities (n, 3) that the robot can reach within a period, slow enough to stop at the end."""
        settings, period = self.settings, self.period
        x = _reachable(velocity.x, settings.acc_lim_x * period, settings.min_vel_x, settings.max_vel_x,
                       settings.vx_samples)
        y = _reachable(velocity.y, settings.acc_lim_y * period, settings.min_vel_y, settings.max_vel_y,
                       settings.vy_samples)
        theta = _reachable(velocity.theta, settings.acc_lim_theta * period, -settings.max_vel_theta,
                           settings.max_vel_theta, settings.vth_samples)
        samples = np.stack(np.meshgrid(x, y, theta, indexing='ij'), axis=-1).reshape(-1, 3)
        speeds = np.hypot(samples[:, 0], samples[:, 1])
        slowing = max(math.hypot(velocity.x, velocity.y) - min(settings.acc_lim_x, settings.acc_lim_y or math.inf)
                      * period, 0.0)
        allowed = speeds <= max(settings.max_vel_trans, slowing) + 1e-9
        allowed[np.argmin(speeds)] = True
        result: Array = samples[allowed]
        return result


def trajectories(velocities: Array, pose: Pose, times: Array) -> Array:
    """Return the poses (velocities, times, 3) that constant velocities (n, 3) lead to: exact arcs."""
    half = 0.5 * velocities[:, 2:] * times
    chord = times * np.sinc(half / math.pi)
    cos, sin = np.cos(pose.yaw + half), np.sin(pose.yaw + half)
    return np.stack([pose.x + chord * (cos * velocities[:, :1] - sin * velocities[:, 1:2]),
                     pose.y + chord * (sin * velocities[:, :1] + cos * velocities[:, 1:2]), pose.yaw + 2.0 * half],
                    axis=-1)


def ahead(path: Array, pose: Pose, distance: float) -> Array:
    """Return the part of a path that begins beside the robot and is ``distance`` [m] long."""
    nearest = int(np.argmin(np.hypot(path[:, 0] - pose.x, path[:, 1] - pose.y)))
    rest = path[max(nearest - 1, 0):]
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(rest, axis=0).T))])
    return rest[:int(np.searchsorted(travelled, distance)) + 1]


def along(path: Array, points: Array) -> Tuple[Array, Array]:
    """Return the distance [m] of points (n, 2) from a path, and the remaining length [m] of the path from there."""
    if len(path) == 1:
        return np.hypot(*(points - path[0]).T), np.zeros(len(points))
    sides = np.diff(path, axis=0)
    lengths = np.hypot(*sides.T)
    offset_x, offset_y = (points[:, None, axis] - path[None, :-1, axis] for axis in (0, 1))
    part = (offset_x * sides[:, 0] + offset_y * sides[:, 1]) / np.maximum(lengths ** 2, 1e-12)
    np.clip(part, 0.0, 1.0, out=part)
    squares = (offset_x - part * sides[:, 0]) ** 2 + (offset_y - part * sides[:, 1]) ** 2
    nearest = squares.argmin(axis=1)
    every = np.arange(len(points))
    rest = np.cumsum(lengths[::-1])[::-1]
    return np.sqrt(squares[every, nearest]), rest[nearest] - part[every, nearest] * lengths[nearest]


def _reachable(now: float, change: float, minimum: float, maximum: float, number: int) -> Array:
    """Return speeds between both limits that can be reached from ``now`` by a ``change``; 0, if it is one of them.

    A positive ``minimum`` is the lowest speed other than 0.
    """
    low, high = max(now - change, minimum), min(now + change, maximum)
    if minimum > 0.0 and now + change < minimum:
        low = high = minimum  # it cannot get faster step by step
    if low > high:  # faster than allowed, as after a push: back towards the limits
        low = high = now - math.copysign(change, now)
    values = np.linspace(low, high, max(int(number), 3)) if high > low else np.array([low])
    if now - change <= 0.0 <= now + change:
        values = np.append(values, 0.0)
    return np.unique(values)


def _known(costs: Array) -> Array:
    """Return costs as floats; UNKNOWN as FREE."""
    result: Array = np.where(costs == UNKNOWN, FREE, costs).astype(float)
    return result


def _towards(value: float, change: float) -> float:
    """Return the speed after braking."""
    return math.copysign(max(abs(value) - change, 0.0), value)
