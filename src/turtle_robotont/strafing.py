"""Drives of an omnidirectional vehicle that keeps its heading and moves sideways. ROS-free.

Units, frames and the way a drive goes are those of turtle_robotont.control; nothing here turns but to hold the heading.
"""
import math

from kinematic_core.angles import wrap_angle
from turtle_robotont.control import TOLERANCE, CircleDrive, Leg, State
from turtle_robotont.shapes import distance
from turtle_robotont.vehicle import ROBOT, Command

LOOKAHEAD = 0.1  # [m] so far ahead on the line is the point that is steered for


def body_velocity(speed, direction, theta, angular):
    """Return the Command that moves a vehicle with heading ``theta`` at ``speed`` [m/s] in ``direction`` [rad]."""
    return Command(speed * math.cos(direction - theta), angular, speed * math.sin(direction - theta))


class StrafeTo(Leg):
    """Move along the straight line from a begin to a goal, whose theta is the heading to keep all the way."""

    def __init__(self, begin, goal, limits=ROBOT.limits, tolerance=TOLERANCE, vehicle=ROBOT):
        super().__init__(begin, goal, limits, tolerance, vehicle, distance(begin, goal))
        self.state = State.DRIVING

    def _decide(self, pose):
        self.distance_left = distance(pose, self.goal)
        self.heading_left = wrap_angle(self.goal.theta - pose.theta)
        if self.state is State.SETTLING or self._reached():
            self.state = State.SETTLING
            return self._settle(pose, self.distance_left <= self.tolerance.position
                                and abs(self.heading_left) <= self.tolerance.heading)
        self.state = State.DRIVING
        speed = self._approach_speed(self.limits.speed)
        return body_velocity(speed, self._direction(pose), pose.theta, self.vehicle.turn_gain * self.heading_left)

    def _reached(self):
        """Half the tolerance is aimed at."""
        return (self.distance_left <= self.tolerance.position / 2.0
                and abs(self.heading_left) <= self.tolerance.heading / 2.0)

    def _direction(self, pose):
        """Return the direction [rad] of the point that lies LOOKAHEAD further on the line, or of the goal."""
        length = distance(self._begin, self.goal)
        if length == 0.0:
            return math.atan2(self.goal.y - pose.y, self.goal.x - pose.x)
        dx, dy = (self.goal.x - self._begin.x) / length, (self.goal.y - self._begin.y) / length
        along = (pose.x - self._begin.x) * dx + (pose.y - self._begin.y) * dy
        along = min(length, along + LOOKAHEAD)
        return math.atan2(self._begin.y + along * dy - pose.y, self._begin.x + along * dx - pose.x)


class StrafeCircle(CircleDrive):
    """Move once round a circle to the left and keep the heading."""

    def __init__(self, pose, radius, limits=ROBOT.limits, tolerance=TOLERANCE, vehicle=ROBOT):
        super().__init__(pose, radius, limits, tolerance, vehicle)
        self._heading = pose.theta

    def _follow(self, pose, bearing, too_far_out):
        self.heading_left = wrap_angle(self._heading - pose.theta)
        top_speed = min(self.limits.speed, self.radius * self.limits.turn_speed)  # here the direction turns
        speed = self._approach_speed(top_speed)
        # half a turn further is inwards: the share of the speed that leads there corrects the radius
        direction = bearing + math.pi / 2.0 + math.atan(too_far_out / LOOKAHEAD)
        return body_velocity(speed, direction, pose.theta, self.vehicle.turn_gain * self.heading_left)
