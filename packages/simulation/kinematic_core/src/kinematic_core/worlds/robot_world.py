"""The world of one Robotont in fixed steps: base, walls, odometry, watchdog.

=====================  ================================================================================
quantity               unit, range, frame
=====================  ================================================================================
pose, odometry.pose    x, y [m] in the world's frame; yaw [rad] in [-pi, pi), counter-clockwise
twist, command         linear_x forward, linear_y to the left [m/s], angular_z [rad/s], the robot's frame
wheel angles           rad, in the order of omni.WHEELS
time                   s, steps * dt
=====================  ================================================================================

The same steps with the same commands and seed give the same numbers. This module uses neither a clock nor ROS. The
class is not thread-safe; threads that share a world need a lock.
"""
import math
import random
from typing import Optional, Sequence, Tuple

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.collision import Obstacles
from kinematic_core.worlds.floor_plan import EMPTY, Cylinder, FloorPlan
from kinematic_core.worlds.omni import UNLIMITED, Limits, Odometry, wheel_speeds
from kinematic_core.worlds.planar import ORIGIN, STILL, Pose2D, Twist2D, advance, mean_twist
from plain_support import InvalidInput, require_sane

DT = 1.0 / 120.0  # [s] a step: odometry and camera (30 Hz) are due every fourth, the scanner (40 Hz) every third
GAZEBO_DT = 0.01  # [s] a step of gazebo_ros: 100 Hz is the default of Gazebo's plugins, and divides most rates
WATCHDOG = 0.5  # [s] without a command after which the robot stops
SCAN_NOISE = 0.01  # [m] standard deviation of each range of its laser scanner (rays.py)
ROBOT_RADIUS = 0.18  # [m]
ROBOT_HEIGHT = 0.25  # [m] with the camera
FASTEST_COMMAND = 10.0  # [m/s] far more than any Robotont reaches
FASTEST_TURN = 50.0  # [rad/s]
MAX_TURN = 0.1  # [rad] by which a path beside an obstacle turns and still counts as straight


class RobotWorld:
    """A robot in a FloorPlan.

    ``place``, ``carry`` and ``move_panel`` take effect at once, ``command`` in the next step. Its body is an
    upright cylinder, by default that of the Robotont. Public and read-only: ``plan``, ``pose``, ``twist`` (what the
    robot really does), ``travelled`` (its twists summed up since it was placed [m, m, rad]), ``odometry``, ``steps``,
    ``watchdog`` [s], ``radius``, ``height`` [m], ``touching`` (whether it touched an obstacle in the last step),
    ``timed_out`` (whether the watchdog has stopped it since the last command).
    """

    plan: FloorPlan
    pose: Pose2D
    twist: Twist2D
    travelled: Twist2D
    timed_out: bool
    touching: bool

    def __init__(self, plan: FloorPlan = EMPTY, start: Pose2D = ORIGIN, limits: Limits = UNLIMITED,
                 watchdog: float = WATCHDOG, slip: float = 0.0, noise: float = 0.0, seed: int = 0,
                 dt: float = DT, radius: float = ROBOT_RADIUS, height: float = ROBOT_HEIGHT,
                 others: Sequence[Cylinder] = ()) -> None:
        """Put the robot at ``start``; InvalidInput if an obstacle is there. A ``watchdog`` of inf never stops it.

        ``others``: as for ``set_others``.
        """
        self.dt = dt
        self.radius, self.height = radius, height
        self._others = others
        self.steps = 0
        self.odometry = Odometry(start, slip, noise, random.Random(seed))
        self._limits = limits
        self._unlimited = limits == UNLIMITED
        self.watchdog = watchdog
        self._lasts = watchdog / dt  # [steps]
        self._set_plan(plan)
        self.place(start.x, start.y, start.yaw)

    @property
    def time(self) -> float:
        """Return the simulated time [s]."""
        return self.steps * self.dt

    @property
    def wheel_speeds(self) -> Tuple[float, float, float]:
        """Return the speeds of the wheels [rad/s]."""
        return wheel_speeds(self.twist)

    @property
    def wheel_angles(self) -> Tuple[float, float, float]:
        """Return the angles [rad] by which the wheels have turned since the robot was placed; not wrapped."""
        return wheel_speeds(self.travelled)

    def place(self, x: float, y: float, yaw: float) -> None:
        """Put the robot at a pose, stopped; its odometry restarts there. Raise InvalidInput if an obstacle is there."""
        require_sane('the pose', x=x, y=y, yaw=yaw)
        obstacle = self._obstacles.at(x, y)
        if obstacle is not None:
            raise InvalidInput(f'the robot cannot be at x={x:g}, y={y:g}: {obstacle} is closer than the radius of '
                               f'{self.radius:g} m')
        self.pose = Pose2D(x, y, wrap_angle(yaw))
        self.twist = self._target = self.travelled = STILL
        self._stops_at = math.inf
        self._free = 0.0
        self.timed_out = self.touching = False
        self.odometry.start(self.pose)

    def carry(self, x: float, y: float, yaw: float) -> None:
        """Put the robot at a pose as somebody who carries it: its wheels do not turn, and its odometry stays.

        An exact odometry follows, because it is the true pose. Raise InvalidInput if an obstacle is there.
        """
        believed = self.odometry.pose
        self.place(x, y, yaw)
        self.odometry.start(self.pose if self.odometry.exact else believed)

    def move_panel(self, name: str, x: float, y: float, yaw: float) -> None:
        """Put a panel's face at (x, y) [m], yaw [rad]; InvalidInput if it does not exist or the robot is there."""
        old = self.plan
        self._set_plan(old.with_panel(name, x, y, yaw))
        if self._obstacles.at(self.pose.x, self.pose.y) == name:
            self._set_plan(old)
            raise InvalidInput(f'the panel {name!r} cannot be at x={x:g}, y={y:g}: the robot is there, at '
                               f'x={self.pose.x:.2f}, y={self.pose.y:.2f} with a radius of {self.radius:g} m')

    def set_plan(self, plan: FloorPlan) -> None:
        """Put the robot, where it is, into another plan; InvalidInput if an obstacle is there."""
        old = self.plan
        self._set_plan(plan)
        obstacle = self._obstacles.at(self.pose.x, self.pose.y)
        if obstacle is not None:
            self._set_plan(old)
            raise InvalidInput(f'{obstacle} cannot be there: a robot is at x={self.pose.x:.2f}, y={self.pose.y:.2f}')

    def set_others(self, others: Sequence[Cylinder]) -> None:
        """Set the bodies of the other robots, where they are in the next step."""
        self._others = others
        self._obstacles.set_others(others)
        self._free = 0.0

    def nearest_free(self, x: float, y: float) -> Optional[Tuple[float, float]]:
        """Return the position where the robot can be instead of (x, y) [m], pushed aside by obstacles, or None."""
        return self._obstacles.nearest_free(x, y)

    def command(self, linear_x: float, linear_y: float, angular_z: float) -> None:
        """Command a velocity [m/s, m/s, rad/s] and restart the watchdog.

        InvalidInput if it is not finite or absurd; the robot then stops, as the sender's intention is unknown.
        """
        try:
            speed = math.hypot(linear_x, linear_y)
            if FASTEST_COMMAND < speed < math.inf:
                raise InvalidInput(f'the velocity: linear is {speed:g} m/s; it must be at most {FASTEST_COMMAND:g}')
            if FASTEST_TURN < abs(angular_z) < math.inf:
                raise InvalidInput(f'the velocity: angular.z is {angular_z:g} rad/s; it must be -{FASTEST_TURN:g} to '
                                   f'{FASTEST_TURN:g}')
            require_sane('the velocity', **{'linear.x': linear_x, 'linear.y': linear_y, 'angular.z': angular_z})
        except InvalidInput:
            self.stop()
            raise
        self._target = self._limits.limited(Twist2D(linear_x, linear_y, angular_z))
        self._stops_at = self.steps + self._lasts
        self.timed_out = False

    def stop(self) -> None:
        """Command the robot to stop, which takes a while if the acceleration is limited."""
        self._target = STILL
        self._stops_at = math.inf

    def step(self) -> None:
        """Advance the world by ``dt``."""
        if self.steps >= self._stops_at:
            self.timed_out = self._target != STILL
            self.stop()
        self.steps += 1
        twist = self._target if self._unlimited else self._limits.approached(self.twist, self._target, self.dt)
        if twist == STILL:
            self.twist, self.touching = STILL, False
        else:
            self._move(twist)
        if self.odometry.exact:
            self.odometry.follow(self.pose, self.twist, self.dt)
        else:
            self.odometry.roll(self.twist, self.dt)

    def _move(self, twist: Twist2D) -> None:
        dt, pose = self.dt, self.pose
        length = math.hypot(twist.linear_x, twist.linear_y) * dt
        self.touching = False
        if length > self._free:
            self._free = self._obstacles.clearance(pose.x, pose.y)
        if length <= self._free:
            self._free -= length
            self.pose = advance(pose, twist, dt)
        else:
            self._free = 0.0
            twist = self._move_beside_obstacles(twist)
        self.twist = twist
        travelled = self.travelled
        self.travelled = Twist2D(travelled.linear_x + twist.linear_x * dt, travelled.linear_y + twist.linear_y * dt,
                                  travelled.angular_z + twist.angular_z * dt)

    def _move_beside_obstacles(self, twist: Twist2D) -> Twist2D:
        """Move in short straight pieces; return the resulting mean twist."""
        pieces = math.ceil(abs(twist.angular_z) * self.dt / MAX_TURN) or 1
        dt = self.dt / pieces
        moved_x = moved_y = 0.0
        for _ in range(pieces):
            pose = self.pose
            free = advance(pose, twist, dt)
            end = self._obstacles.move(pose.x, pose.y, free.x - pose.x, free.y - pose.y)
            self.touching = self.touching or end.touched
            self.pose = Pose2D(end.x, end.y, free.yaw)
            real = mean_twist(pose, self.pose, twist.angular_z, dt)
            moved_x, moved_y = moved_x + real.linear_x / pieces, moved_y + real.linear_y / pieces
        return Twist2D(moved_x, moved_y, twist.angular_z)

    def _set_plan(self, plan: FloorPlan) -> None:
        self.plan = plan
        self._obstacles = Obstacles(plan, self.radius, self.height)
        self._obstacles.set_others(self._others)
        self._free = 0.0  # [m] that the robot can move in any direction before it may touch anything
