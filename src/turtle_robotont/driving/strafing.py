"""Drives for an omnidirectional vehicle that keeps its heading and moves sideways. ROS-free.

Units, frames and states are those of turtle_robotont.driving.control; these drives turn only to hold the heading.
"""
import math

from turtle_robotont.driving.control import TOLERANCE, CircleDrive, Goal, Leg, State, Tolerance
from turtle_robotont.driving.shapes import HasPosition, distance, wrap_angle
from turtle_robotont.driving.vehicle import ROBOT, Limits, Twist2D, Vehicle, VehicleState

LOOKAHEAD = 0.1  # [m] along the line, to the point at which the drive aims


def body_velocity(speed: float, direction: float, theta: float, angular_z: float) -> Twist2D:
    """Return the command that moves a vehicle with heading ``theta`` at ``speed`` [m/s] in ``direction`` [rad].

    ``direction`` and ``theta`` [rad] are in the same frame; ``angular_z`` [rad/s] is passed on.
    """
    return Twist2D(speed * math.cos(direction - theta), speed * math.sin(direction - theta), angular_z)


class StrafeTo(Leg):
    """Move along the straight line from a start to a goal, and keep the heading ``theta`` [rad]."""

    def __init__(self, start: HasPosition, goal: HasPosition, theta: float, limits: Limits = ROBOT.limits,
                 tolerance: Tolerance = TOLERANCE, vehicle: Vehicle = ROBOT) -> None:
        super().__init__(start, Goal(goal.x, goal.y, theta), limits, tolerance, vehicle, distance(start, goal))
        self._theta = theta
        self.state = State.DRIVING

    def _decide(self, pose: VehicleState) -> Twist2D:
        self.distance_left = distance(pose, self.goal)
        self.heading_left = wrap_angle(self._theta - pose.theta)
        if self.state is State.SETTLING or self._reached():
            self.state = State.SETTLING
            return self._settle(pose, self.distance_left <= self.tolerance.position
                                and abs(self.heading_left) <= self.tolerance.heading)
        self.state = State.DRIVING
        speed = self._approach_speed(self.limits.speed)
        return body_velocity(speed, self._direction(pose), pose.theta, self.vehicle.turn_gain * self.heading_left)

    def _reached(self) -> bool:
        """Aim at half the tolerance."""
        return (self.distance_left <= self.tolerance.position / 2.0
                and abs(self.heading_left) <= self.tolerance.heading / 2.0)

    def _direction(self, pose: VehicleState) -> float:
        """Return the direction [rad] of the point that lies LOOKAHEAD further on the line, or of the goal."""
        start, goal = self._start, self.goal
        length = distance(start, goal)
        if length == 0.0:
            return math.atan2(goal.y - pose.y, goal.x - pose.x)
        dx, dy = (goal.x - start.x) / length, (goal.y - start.y) / length
        along = (pose.x - start.x) * dx + (pose.y - start.y) * dy
        along = min(length, along + LOOKAHEAD)
        return math.atan2(start.y + along * dy - pose.y, start.x + along * dx - pose.x)


class StrafeCircle(CircleDrive):
    """Move once round a circle to the left and keep the heading."""

    def __init__(self, pose: VehicleState, radius: float, limits: Limits = ROBOT.limits,
                 tolerance: Tolerance = TOLERANCE, vehicle: Vehicle = ROBOT) -> None:
        super().__init__(pose, radius, limits, tolerance, vehicle)
        self._heading = pose.theta

    def _follow(self, pose: VehicleState, bearing: float, too_far_out: float) -> Twist2D:
        self.heading_left = wrap_angle(self._heading - pose.theta)
        top_speed = min(self.limits.speed, self.radius * self.limits.turn_speed)  # here the direction turns
        speed = self._approach_speed(top_speed)
        # half a turn further is inwards: the share of the speed that leads there corrects the radius
        direction = bearing + math.pi / 2.0 + math.atan(too_far_out / LOOKAHEAD)
        return body_velocity(speed, direction, pose.theta, self.vehicle.turn_gain * self.heading_left)
