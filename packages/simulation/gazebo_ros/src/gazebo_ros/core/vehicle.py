"""A robot in the world: its body, its drive, and the ranges of its lasers. No ROS, no clock."""
import math
from typing import Sequence, Tuple

import numpy as np

from gazebo_ros.core.robots import Laser, Robot
from kinematic_core.worlds.collision import Obstacles
from kinematic_core.worlds.floor_plan import Cylinder, FloorPlan
from kinematic_core.worlds.frames import ahead
from kinematic_core.worlds.omni import UNLIMITED
from kinematic_core.worlds.planar import ORIGIN, STILL, Pose2D, Twist2D, advance, compose
from kinematic_core.worlds.rays import RayCaster
from kinematic_core.worlds.robot_world import GAZEBO_DT, RobotWorld
from plain_support import InvalidInput

DT = GAZEBO_DT


class Vehicle:
    """A Robot somewhere in a FloorPlan. ``name`` is that of its model; ``start`` is the pose where it was spawned."""

    def __init__(self, name: str, robot: Robot, pose: Pose2D, plan: FloorPlan, others: Sequence[Cylinder]) -> None:
        """Put its model at ``pose``, or beside the obstacles there; raise InvalidInput if no place is free."""
        self.name, self.robot = name, robot
        obstacles = Obstacles(plan, robot.radius, robot.height)
        obstacles.set_others(others)
        centre = ahead(pose, robot.ahead)
        free = obstacles.nearest_free(*centre)
        if free is None:
            raise InvalidInput(f'{name} cannot be at x={pose.x:g}, y={pose.y:g}: {obstacles.at(*centre)} is closer '
                               f'than its radius of {robot.radius:.2f} m')
        self.moved_aside = math.dist(free, centre)  # [m]
        timeout = robot.drive.timeout if robot.drive else math.inf
        self._world = RobotWorld(plan, Pose2D(*free, pose.yaw), UNLIMITED, timeout, dt=DT, radius=robot.radius,
                                 height=robot.height, others=others)
        self._command = self._ramped = STILL
        self._encoders = ORIGIN  # the centre in the frame of its start
        self._meets = bool(others)
        self.start = self.pose

    @property
    def centre(self) -> Pose2D:
        """Return the pose of the point about which it turns."""
        return self._world.pose

    @property
    def pose(self) -> Pose2D:
        """Return the pose of its model."""
        return self._of_model(self.centre)

    @property
    def odometry(self) -> Pose2D:
        """Return the pose of its model as its odometry shows it."""
        drive = self.robot.drive
        return self._of_model(self._encoders) if drive and drive.from_encoders else self.pose

    @property
    def twist(self) -> Twist2D:
        """Return its velocity in its own frame, at the centre."""
        return self._world.twist

    @property
    def touching(self) -> bool:
        return self._world.touching

    @property
    def body(self) -> Cylinder:
        """Return the body that other robots and their sensors meet."""
        centre, robot = self.centre, self.robot
        return Cylinder(self.name, centre.x, centre.y, robot.radius, robot.height, 0.0, robot.colour)

    @property
    def wheel_angles(self) -> Tuple[float, float]:
        """Return the angles [rad] by which the left and the right wheels have turned; 0 without wheels."""
        return self._of_wheels(self._world.travelled)

    @property
    def wheel_speeds(self) -> Tuple[float, float]:
        """Return the speeds [rad/s] of the left and the right wheels; 0 without wheels."""
        return self._of_wheels(self.twist)

    def command(self, x: float, y: float, turn: float) -> None:
        """Drive with a velocity [m/s, m/s, rad/s] from now on; stop and raise InvalidInput if it is absurd."""
        drive = self.robot.drive
        self._command = STILL
        y = y if drive and not drive.separation else 0.0
        self._world.command(x, y, turn)
        self._command = Twist2D(x, y, turn)

    def put(self, pose: Pose2D) -> None:
        """Stop, and put its model at a pose or beside the obstacles there; raise InvalidInput if no place is free."""
        x, y = self._world.nearest_free(*ahead(pose, self.robot.ahead)) or ahead(pose, self.robot.ahead)
        self._world.place(x, y, pose.yaw)
        self._command = self._ramped = STILL

    def set_plan(self, plan: FloorPlan) -> None:
        """Set the obstacles; raise InvalidInput if one of them overlaps the robot."""
        self._world.set_plan(plan)

    def step(self, others: Sequence[Cylinder]) -> None:
        """Advance by DT; ``others``: the bodies of the other robots."""
        world = self._world
        if others or self._meets:
            world.set_others(others)
            self._meets = bool(others)
        drive = self.robot.drive
        if drive and drive.acceleration and drive.separation and self._ramped != self._command:
            self._ramped = self._approached(drive.acceleration * DT, drive.separation)
            world.command(*self._ramped)
        world.step()
        self._encoders = advance(self._encoders, world.twist, DT)

    def reset(self) -> None:
        """Stop, and put it where it was spawned, with new odometry."""
        self.put(self.start)
        self._encoders = ORIGIN

    def scan(self, laser: Laser, caster: RayCaster, others: Sequence[Cylinder]) -> np.ndarray:
        """Return the ranges (rays,) [m], without noise, of one of its lasers; ``caster`` sees the plan."""
        mount = laser.mount
        position = compose(self.centre, Pose2D(mount.x, mount.y, mount.yaw))
        ranges = caster.ranges(*position)
        if others:
            moving = RayCaster(FloorPlan(cylinders=tuple(others)), mount.z, angles(laser))
            np.minimum(ranges, moving.ranges(*position), out=ranges)
        return ranges

    def _of_model(self, centre: Pose2D) -> Pose2D:
        return Pose2D(*ahead(centre, -self.robot.ahead), centre.yaw)

    def _of_wheels(self, motion: Twist2D) -> Tuple[float, float]:
        drive = self.robot.drive
        if not drive or not drive.separation:
            return 0.0, 0.0
        half = motion.angular_z * drive.separation / 2.0
        return (motion.linear_x - half) / drive.wheel_radius, (motion.linear_x + half) / drive.wheel_radius

    def _approached(self, change: float, separation: float) -> Twist2D:
        """Return the next velocity towards the commanded one; each wheel's rim changes by at most ``change`` [m/s]."""
        half = separation / 2.0
        rims = []
        for side in (-half, half):
            now, target = (twist.linear_x + side * twist.angular_z for twist in (self._ramped, self._command))
            rims.append(now + min(max(target - now, -change), change))
        return Twist2D((rims[0] + rims[1]) / 2.0, 0.0, (rims[1] - rims[0]) / separation)


def angles(laser: Laser) -> np.ndarray:
    """Return the angles (rays,) [rad] of a laser's rays."""
    return np.linspace(laser.first, laser.last, laser.rays)
