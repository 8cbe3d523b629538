"""Driving a turtle or a robot to where it shall be: pure logic, one ``step(pose, dt)`` a pose, no clock and no ROS.

======================  ====================================================================================
quantity                unit, range, frame
======================  ====================================================================================
pose.x, pose.y          m, of a turtle 0 .. ARENA_SIZE from the arena's lower left corner, of a robot in odom
pose.theta, headings    rad, [-pi, pi), counter-clockwise from +x
pose.*_velocity         m/s (never negative) and rad/s, as turtlesim/Pose reports them
dt                      s of simulated or measured time since the pose before
======================  ====================================================================================

The way a drive goes: turn on the spot towards the goal, drive there while steering, turn to the final heading,
then stand still and look whether the vehicle really is there. The drives of turtle_robotont.strafing keep their
heading instead.
"""
import enum
import math
from typing import NamedTuple

from kinematic_core.angles import wrap_angle
from kinematic_core.checks import InvalidInput
from kinematic_core.turtle_world import ARENA_SIZE
from turtle_robotont.shapes import distance
from turtle_robotont.vehicle import LIMITS, STOP, TURTLE, Command

TURNED_ENOUGH = 0.05  # [rad] off the goal's direction: drive, and steer the rest
TURN_AGAIN = 0.5  # [rad] off the goal's direction: stop and turn
RADIUS_GAIN = 2.0  # [1/m] heading correction for each metre off the circle
STEER_FADE = 0.1  # [m] closer than this the goal's direction says little, and steering fades out

STUCK_AFTER = 2.0  # [s] without any movement although commanded
MOVED = 1e-3  # [m or rad] is a movement
JUMP = 0.1  # [m] more than the turtle can have driven: somebody teleported it
START_DELAY = 1.0  # [s] at most from planning a drive to its first step, in which the vehicle may still have moved
JUMPS_FORGIVEN = 3
DEADLINE_FACTOR = 2.0  # a drive may take this many times as long as at its top speeds
DEADLINE_EXTRA = 5.0  # [s] and this on top


class Goal(NamedTuple):
    """A position [m] and, unless None, the heading [rad] to end with."""

    x: float
    y: float
    theta: float = None


class Tolerance(NamedTuple):
    """How far off its goal a turtle may stand: position [m], heading [rad]."""

    position: float = 0.01
    heading: float = 0.01


TOLERANCE = Tolerance()


class State(enum.Enum):
    """What a drive is doing; the names are those of the constants in DriveStatus.msg."""

    TURNING = 'turning towards the goal'
    DRIVING = 'driving'
    ALIGNING = 'turning to the final heading'
    SETTLING = 'standing still'
    ARRIVED = 'arrived'
    FAILED = 'failed'
    PREEMPTED = 'preempted'


ENDED = (State.ARRIVED, State.FAILED, State.PREEMPTED)


def require_goal(x, y, theta=None):
    """Return the Goal; raise InvalidInput unless it is finite and inside the arena."""
    for name, value, unit in (('x', x, 'm'), ('y', y, 'm'), ('theta', theta, 'rad')):
        if value is not None and not math.isfinite(value):
            raise InvalidInput(f'the goal\'s {name} is {value}; it must be a finite number [{unit}]')
    for name, value in (('x', x), ('y', y)):
        if not 0.0 <= value <= ARENA_SIZE:
            raise InvalidInput(f'the goal\'s {name} is {value:g} m; the arena allows 0 to {ARENA_SIZE:.4f} m')
    return Goal(x, y, None if theta is None else wrap_angle(theta))


def approach_speed(left, top_speed, deceleration, gain):
    """Return the speed (>= 0) at which to approach a goal that is ``left`` (>= 0, m or rad) away.

    Far off the speed from which ``deceleration`` still stops in time, the square root of the way left; close to
    the goal, where that root is too steep for a delayed loop, proportional to it. Both meet without a bend.
    """
    bend = deceleration / gain ** 2
    speed = gain * left if left < bend else math.sqrt(2.0 * deceleration * (left - bend / 2.0))
    return min(top_speed, speed)


def turn_speed(heading_error, limits, vehicle=TURTLE):
    """Return the angular velocity [rad/s] that turns a vehicle on the spot by heading_error [rad]."""
    speed = approach_speed(abs(heading_error), limits.turn_speed, vehicle.turn_deceleration, vehicle.turn_gain)
    return math.copysign(speed, heading_error)


class Drive:
    """What every drive of one turtle shows: call ``step`` with each pose and send what it returns until ``finished``.

    goal           the Goal it is heading for now
    state          a State; the drive has ended when it is one of ENDED
    reason         why it did not arrive, else empty
    distance_left  [m] to the goal, along the way
    heading_left   [rad] to the direction that it is turning to
    """

    def __init__(self, goal):
        self.goal = goal
        self.state, self.reason = State.TURNING, ''
        self.distance_left = self.heading_left = 0.0

    @property
    def finished(self):
        """Return whether the drive has ended, well or not."""
        return self.state in ENDED

    def end(self, state, reason):
        """End the drive, also from outside, e.g. with State.PREEMPTED."""
        self.state, self.reason = state, reason

    def step(self, pose, dt):
        """Take the newest pose and the time [s] since the one before; return the Command to send."""
        raise NotImplementedError


class Leg(Drive):
    """A drive to one goal. It fails when the turtle does not move, takes too long or is moved by somebody else."""

    def __init__(self, begin, goal, limits, tolerance, vehicle, way, turns=2.0 * math.pi):
        """``begin``: where it was planned from; ``way`` [m] and ``turns`` [rad]: the longest it may have to go."""
        super().__init__(goal)
        self.limits, self.tolerance, self.vehicle = limits, tolerance, vehicle
        self._allowed = DEADLINE_EXTRA + DEADLINE_FACTOR * (way / limits.speed + turns / limits.turn_speed)
        self._time = 0.0
        self._speed = self._top_speed = 0.0
        self._begin, self._before = begin, None
        self._anchor, self._anchored_at = None, 0.0

    def step(self, pose, dt):
        if self._jumped(pose, dt):
            self._on_jump(self._before or self._begin, pose)
        self._before = pose
        self._time += dt
        if not self.finished:
            self._supervise(pose)
        if self.finished:
            return STOP
        self._top_speed = self._speed + self.vehicle.acceleration * dt
        command = self.limits.apply(self._decide(pose))
        self._speed = math.hypot(command.linear, command.lateral)
        return command

    def _decide(self, pose):
        """Return the Command for this pose, and keep state, distance_left and heading_left."""
        raise NotImplementedError

    def _approach_speed(self, top_speed):
        """Return the speed [m/s] for the way left, gathered gently from the last one."""
        return min(self._top_speed, approach_speed(self.distance_left, top_speed, self.vehicle.acceleration,
                                                   self.vehicle.approach_gain))

    def _settle(self, pose, there):
        """Stand still; then arrive, or go on when the turtle is not there after all."""
        if max(pose.linear_velocity, abs(pose.angular_velocity)) < self.vehicle.standing:
            self.state = State.ARRIVED if there else State.TURNING
        return STOP

    def _jumped(self, pose, dt):
        if self._before is None:
            return distance(self._begin, pose) > JUMP + self.limits.speed * START_DELAY
        reach = max(self.limits.speed, self._before.linear_velocity, pose.linear_velocity) * dt
        return distance(self._before, pose) > JUMP + 2.0 * reach

    def _on_jump(self, before, pose):
        self.end(State.FAILED, f'somebody moved the {self.vehicle.name} from ({before.x:.2f}, {before.y:.2f}) to '
                               f'({pose.x:.2f}, {pose.y:.2f}) while it drove')

    def _supervise(self, pose):
        if self._time > self._allowed:
            self.end(State.FAILED, f'not there after {self._allowed:.1f} s, {self.distance_left:.2f} m left; '
                                   f'is another node driving the same {self.vehicle.name}?')
        elif self._moves(pose):
            self._anchor, self._anchored_at = pose, self._time
        elif self._time - self._anchored_at > STUCK_AFTER:
            self.end(State.FAILED, f'the {self.vehicle.name} has not moved for {STUCK_AFTER:.0f} s although it was '
                                   f'told to, {self.distance_left:.2f} m left; is another node sending it commands?')

    def _moves(self, pose):
        anchor = self._anchor
        return (anchor is None or self.state is State.SETTLING or distance(anchor, pose) > MOVED
                or abs(wrap_angle(pose.theta - anchor.theta)) > MOVED)


class GoTo(Leg):
    """Drive to a goal, straight and forward. After a jump (teleport) it starts anew from where the turtle is."""

    def __init__(self, pose, goal, limits=LIMITS, tolerance=TOLERANCE, jumps_forgiven=JUMPS_FORGIVEN, vehicle=TURTLE):
        super().__init__(pose, goal, limits, tolerance, vehicle, distance(pose, goal))
        self._jumps_left = jumps_forgiven

    def _on_jump(self, before, pose):
        if self._jumps_left == 0:
            super()._on_jump(before, pose)
        else:
            self._jumps_left -= 1
            self.state = State.TURNING
            self._allowed += DEADLINE_FACTOR * distance(pose, self.goal) / self.limits.speed

    def _decide(self, pose):
        goal = self.goal
        self.distance_left = distance(pose, goal)
        bearing_error = wrap_angle(math.atan2(goal.y - pose.y, goal.x - pose.x) - pose.theta)
        if self.state in (State.TURNING, State.DRIVING) and self._reached(bearing_error):
            self.state = State.SETTLING if goal.theta is None else State.ALIGNING
        if self.state in (State.TURNING, State.DRIVING):
            self.heading_left = bearing_error
            return self._approach(bearing_error)
        self.heading_left = 0.0 if goal.theta is None else wrap_angle(goal.theta - pose.theta)
        if self.state is State.ALIGNING:
            if abs(self.heading_left) > self.tolerance.heading / 2.0:
                return Command(0.0, turn_speed(self.heading_left, self.limits, self.vehicle))
            self.state = State.SETTLING
        return self._settle(pose, self.distance_left <= self.tolerance.position
                            and abs(self.heading_left) <= self.tolerance.heading)

    def _reached(self, bearing_error):
        """Half the tolerance is aimed at; all of it is good enough once the goal has been passed."""
        passed = abs(bearing_error) > math.pi / 2.0
        return self.distance_left <= self.tolerance.position * (1.0 if passed else 0.5)

    def _approach(self, bearing_error):
        if abs(bearing_error) > TURN_AGAIN:
            self.state = State.TURNING
        elif abs(bearing_error) < TURNED_ENOUGH:
            self.state = State.DRIVING
        if self.state is State.TURNING:
            return Command(0.0, turn_speed(bearing_error, self.limits, self.vehicle))
        speed = self._approach_speed(self.limits.speed)
        steering = self.vehicle.steer_gain * bearing_error * min(1.0, self.distance_left / STEER_FADE)
        return Command(speed, steering)


class CircleDrive(Leg):
    """Drive once round a circle to the left, from where the turtle stands and in the direction it faces."""

    def __init__(self, pose, radius, limits=LIMITS, tolerance=TOLERANCE, vehicle=TURTLE):
        """``radius`` [m]; the centre lies to the left of the turtle."""
        super().__init__(pose, Goal(pose.x, pose.y, pose.theta), limits, tolerance, vehicle, 2.0 * math.pi * radius)
        self.radius = radius
        self.centre = Goal(pose.x - radius * math.sin(pose.theta), pose.y + radius * math.cos(pose.theta))
        self.state = State.DRIVING
        self._bearing = self._bearing_of(pose)
        self._swept = 0.0

    def _bearing_of(self, pose):
        return math.atan2(pose.y - self.centre.y, pose.x - self.centre.x)

    def _decide(self, pose):
        bearing = self._bearing_of(pose)
        self._swept += wrap_angle(bearing - self._bearing)
        self._bearing = bearing
        self.distance_left = max(0.0, self.radius * (2.0 * math.pi - self._swept))
        too_far_out = distance(self.centre, pose) - self.radius
        tangent = bearing + math.pi / 2.0
        self.heading_left = wrap_angle(tangent + math.atan(RADIUS_GAIN * too_far_out) - pose.theta)
        if self.distance_left <= self.tolerance.position / 2.0:
            self.state = State.SETTLING
        if self.state is State.SETTLING:
            return self._settle(pose, True)
        return self._follow(pose, bearing, too_far_out)

    def _follow(self, pose, bearing, too_far_out):
        """Return the Command that keeps to the circle."""
        top_speed = min(self.limits.speed, self.radius * self.limits.turn_speed / 2.0)  # leaves room for steering
        speed = self._approach_speed(top_speed)
        fade = min(1.0, self.distance_left / STEER_FADE)
        return Command(speed, speed / self.radius + self.vehicle.steer_gain * self.heading_left * fade)


class Path(Drive):
    """Several drives one after the other, e.g. the sides of a shape. A leg that fails ends it."""

    def __init__(self, legs):
        super().__init__(legs[0].goal)
        self._legs = legs
        self._number = 0

    def step(self, pose, dt):
        """Step the present leg, and go on with the next one as soon as it has arrived."""
        if self.finished:
            return STOP
        leg = self._legs[self._number]
        command = leg.step(pose, dt)
        self.goal, self.distance_left, self.heading_left = leg.goal, leg.distance_left, leg.heading_left
        if leg.state is State.ARRIVED and self._number + 1 < len(self._legs):
            self._number += 1
        elif leg.state is State.FAILED:
            self.end(State.FAILED, f'on the way to corner {self._number + 1} of {len(self._legs)}: {leg.reason}')
        else:
            self.state = leg.state
        return command
