"""Drive a turtle or a robot to a goal: pure logic, one ``step(pose, dt)`` per pose, no clock and no ROS.

======================  ====================================================================================
quantity                unit, range, frame
======================  ====================================================================================
pose.x, pose.y          m, of a turtle 0 .. ARENA_SIZE from the arena's lower left corner, of a robot in odom
pose.theta, headings    rad, [-pi, pi), counter-clockwise from +x
pose.*_velocity         m/s (never negative) and rad/s, as turtlesim/Pose reports them
dt                      s of simulated or measured time since the previous pose
======================  ====================================================================================

A drive turns on the spot towards the goal, drives there while steering, turns to the final heading, then stands still
and checks that the vehicle really is there. The drives of turtle_robotont.driving.strafing keep their heading instead.
"""
import enum
import math
from typing import List, NamedTuple, Optional

from turtle_robotont.driving.shapes import ARENA_SIZE, HasPosition, InvalidInput, distance, wrap_angle
from turtle_robotont.driving.vehicle import LIMITS, STOP, TURTLE, Limits, Twist2D, Vehicle, VehicleState

TURNED_ENOUGH = 0.05  # [rad] from the goal's direction: drive, and steer the rest
TURN_AGAIN = 0.5  # [rad] from the goal's direction: stop and turn
RADIUS_GAIN = 2.0  # [1/m] heading correction per metre off the circle
STEER_FADE = 0.1  # [m] closer than this, the goal's direction is not reliable, and steering fades out

STUCK_AFTER = 2.0  # [s] without any movement although commanded
MOVED = 1e-3  # [m or rad] counts as a movement
JUMP = 0.1  # [m] further than the turtle can have driven: it was teleported
START_DELAY = 1.0  # [s] longest time from planning a drive to its first step, in which the vehicle may still move
JUMPS_FORGIVEN = 3
DEADLINE_FACTOR = 2.0  # a drive may take this many times as long as at its top speeds
DEADLINE_EXTRA = 5.0  # [s] added to that time


class Goal(NamedTuple):
    """A position [m] and, unless None, the final heading [rad]."""

    x: float
    y: float
    theta: Optional[float] = None


class Tolerance(NamedTuple):
    """How far from its goal a turtle may stand: position [m], heading [rad]."""

    position: float = 0.01
    heading: float = 0.01


TOLERANCE = Tolerance()


class State(enum.Enum):
    """The state of a drive; the names are those of the constants in DriveStatus.msg."""

    TURNING = 'turning towards the goal'
    DRIVING = 'driving'
    ALIGNING = 'turning to the final heading'
    SETTLING = 'standing still'
    ARRIVED = 'arrived'
    FAILED = 'failed'
    PREEMPTED = 'preempted'


ENDED = (State.ARRIVED, State.FAILED, State.PREEMPTED)


def require_goal(x: float, y: float, theta: Optional[float] = None) -> Goal:
    """Return the Goal; raise InvalidInput unless it is finite and inside the arena."""
    for name, value, unit in (('x', x, 'm'), ('y', y, 'm'), ('theta', theta, 'rad')):
        if value is not None and not math.isfinite(value):
            raise InvalidInput(f'the goal\'s {name} is {value}; it must be a finite number [{unit}]')
    for name, value in (('x', x), ('y', y)):
        if not 0.0 <= value <= ARENA_SIZE:
            raise InvalidInput(f'the goal\'s {name} is {value:g} m; the arena allows 0 to {ARENA_SIZE:.4f} m')
    return Goal(x, y, None if theta is None else wrap_angle(theta))


def approach_speed(left: float, top_speed: float, deceleration: float, gain: float) -> float:
    """Return the speed (>= 0) at which to approach a goal that is ``left`` (>= 0, m or rad) away.

    Far away, it is the highest speed from which ``deceleration`` still stops in time, which is proportional to the
    square root of the distance. Close to the goal, where that root is too steep for a delayed loop, it is proportional
    to the distance. The two curves meet without a bend.
    """
    bend = deceleration / gain ** 2
    speed = gain * left if left < bend else math.sqrt(2.0 * deceleration * (left - bend / 2.0))
    return min(top_speed, speed)


def turn_speed(heading_error: float, limits: Limits, vehicle: Vehicle = TURTLE) -> float:
    """Return the angular velocity [rad/s] with which a vehicle turns on the spot by ``heading_error`` [rad]."""
    speed = approach_speed(abs(heading_error), limits.turn_speed, vehicle.turn_deceleration, vehicle.turn_gain)
    return math.copysign(speed, heading_error)


class Drive:
    """Base of all drives: call ``step`` with each pose and send the command it returns, until ``finished``.

    goal           the current Goal
    state          a State; the drive has ended when it is one of ENDED
    reason         why it did not arrive, else empty
    distance_left  [m] to the goal, along the path
    heading_left   [rad] to the direction that it is turning to
    """

    def __init__(self, goal: Goal) -> None:
        self.goal = goal
        self.state, self.reason = State.TURNING, ''
        self.distance_left = self.heading_left = 0.0

    @property
    def finished(self) -> bool:
        """Return whether the drive has ended, successfully or not."""
        return self.state in ENDED

    def end(self, state: State, reason: str) -> None:
        """End the drive, also from outside, e.g. with State.PREEMPTED."""
        self.state, self.reason = state, reason

    def step(self, pose: VehicleState, dt: float) -> Twist2D:
        """Take the newest pose and the time [s] since the previous one; return the command to send."""
        raise NotImplementedError


class Leg(Drive):
    """A drive to one goal. It fails if the vehicle does not move, takes too long or is moved by something else."""

    def __init__(self, start: HasPosition, goal: Goal, limits: Limits, tolerance: Tolerance, vehicle: Vehicle,
                 length: float, turns: float = 2.0 * math.pi) -> None:
        """``start`` is the planned start; ``length`` [m] and ``turns`` [rad] are the most that the drive may take."""
        super().__init__(goal)
        self.limits, self.tolerance, self.vehicle = limits, tolerance, vehicle
        self._allowed = DEADLINE_EXTRA + DEADLINE_FACTOR * (length / limits.speed + turns / limits.turn_speed)
        self._time = 0.0
        self._speed = self._top_speed = 0.0
        self._start = start
        self._previous: Optional[VehicleState] = None
        self._anchor: Optional[VehicleState] = None  # the pose since which it counts as not moving
        self._anchored_at = 0.0

    def step(self, pose: VehicleState, dt: float) -> Twist2D:
        if self._jumped(pose, dt):
            self._on_jump(self._previous or self._start, pose)
        self._previous = pose
        self._time += dt
        if not self.finished:
            self._supervise(pose)
        if self.finished:
            return STOP
        self._top_speed = self._speed + self.vehicle.acceleration * dt
        command = self.limits.apply(self._decide(pose))
        self._speed = math.hypot(command.linear_x, command.linear_y)
        return command

    def _decide(self, pose: VehicleState) -> Twist2D:
        """Return the command for this pose; update state, distance_left and heading_left."""
        raise NotImplementedError

    def _approach_speed(self, top_speed: float) -> float:
        """Return the speed [m/s] for the distance left, limited by the acceleration from the last one."""
        return min(self._top_speed, approach_speed(self.distance_left, top_speed, self.vehicle.acceleration,
                                                   self.vehicle.approach_gain))

    def _settle(self, pose: VehicleState, there: bool) -> Twist2D:
        """Stand still; then arrive, or continue if the vehicle is not at the goal."""
        if max(pose.linear_velocity, abs(pose.angular_velocity)) < self.vehicle.standing:
            self.state = State.ARRIVED if there else State.TURNING
        return STOP

    def _jumped(self, pose: VehicleState, dt: float) -> bool:
        if self._previous is None:
            return distance(self._start, pose) > JUMP + self.limits.speed * START_DELAY
        reach = max(self.limits.speed, self._previous.linear_velocity, pose.linear_velocity) * dt
        return distance(self._previous, pose) > JUMP + 2.0 * reach

    def _on_jump(self, previous: HasPosition, pose: VehicleState) -> None:
        self.end(State.FAILED, f'something else moved the {self.vehicle.name} from ({previous.x:.2f}, '
                               f'{previous.y:.2f}) to ({pose.x:.2f}, {pose.y:.2f}) during the drive')

    def _supervise(self, pose: VehicleState) -> None:
        if self._time > self._allowed:
            self.end(State.FAILED, f'not at the goal after {self._allowed:.1f} s, {self.distance_left:.2f} m left; '
                                   f'is another node driving the same {self.vehicle.name}?')
        elif self._moves(pose):
            self._anchor, self._anchored_at = pose, self._time
        elif self._time - self._anchored_at > STUCK_AFTER:
            self.end(State.FAILED, f'the {self.vehicle.name} has not moved for {STUCK_AFTER:.0f} s despite its '
                                   f'commands, {self.distance_left:.2f} m left; does it stand at a wall, or is '
                                   'another node commanding it?')

    def _moves(self, pose: VehicleState) -> bool:
        anchor = self._anchor
        return (anchor is None or self.state is State.SETTLING or distance(anchor, pose) > MOVED
                or abs(wrap_angle(pose.theta - anchor.theta)) > MOVED)


class GoTo(Leg):
    """Drive to a goal, straight and forward. After a jump (teleport), start again from the new position."""

    def __init__(self, pose: HasPosition, goal: Goal, limits: Limits = LIMITS, tolerance: Tolerance = TOLERANCE,
                 jumps_forgiven: int = JUMPS_FORGIVEN, vehicle: Vehicle = TURTLE) -> None:
        super().__init__(pose, goal, limits, tolerance, vehicle, distance(pose, goal))
        self._jumps_left = jumps_forgiven

    def _on_jump(self, previous: HasPosition, pose: VehicleState) -> None:
        if self._jumps_left == 0:
            super()._on_jump(previous, pose)
        else:
            self._jumps_left -= 1
            self.state = State.TURNING
            self._allowed += DEADLINE_FACTOR * distance(pose, self.goal) / self.limits.speed

    def _decide(self, pose: VehicleState) -> Twist2D:
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
                return Twist2D(angular_z=turn_speed(self.heading_left, self.limits, self.vehicle))
            self.state = State.SETTLING
        return self._settle(pose, self.distance_left <= self.tolerance.position
                            and abs(self.heading_left) <= self.tolerance.heading)

    def _reached(self, bearing_error: float) -> bool:
        """Aim at half the tolerance; all of it is good enough once the goal has been passed."""
        passed = abs(bearing_error) > math.pi / 2.0
        return self.distance_left <= self.tolerance.position * (1.0 if passed else 0.5)

    def _approach(self, bearing_error: float) -> Twist2D:
        if abs(bearing_error) > TURN_AGAIN:
            self.state = State.TURNING
        elif abs(bearing_error) < TURNED_ENOUGH:
            self.state = State.DRIVING
        if self.state is State.TURNING:
            return Twist2D(angular_z=turn_speed(bearing_error, self.limits, self.vehicle))
        speed = self._approach_speed(self.limits.speed)
        steering = self.vehicle.steer_gain * bearing_error * min(1.0, self.distance_left / STEER_FADE)
        return Twist2D(linear_x=speed, angular_z=steering)


class CircleDrive(Leg):
    """Drive once round a circle to the left, from where the turtle stands and in the direction it faces."""

    def __init__(self, pose: VehicleState, radius: float, limits: Limits = LIMITS, tolerance: Tolerance = TOLERANCE,
                 vehicle: Vehicle = TURTLE) -> None:
        """``radius`` [m]; the centre lies to the left of the turtle."""
        super().__init__(pose, Goal(pose.x, pose.y, pose.theta), limits, tolerance, vehicle, 2.0 * math.pi * radius)
        self.radius = radius
        self.centre = Goal(pose.x - radius * math.sin(pose.theta), pose.y + radius * math.cos(pose.theta))
        self.state = State.DRIVING
        self._bearing = self._bearing_of(pose)
        self._swept = 0.0

    def _bearing_of(self, pose: VehicleState) -> float:
        return math.atan2(pose.y - self.centre.y, pose.x - self.centre.x)

    def _decide(self, pose: VehicleState) -> Twist2D:
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

    def _follow(self, pose: VehicleState, bearing: float, too_far_out: float) -> Twist2D:
        """Return the command that keeps to the circle."""
        top_speed = min(self.limits.speed, self.radius * self.limits.turn_speed / 2.0)  # leaves room for steering
        speed = self._approach_speed(top_speed)
        fade = min(1.0, self.distance_left / STEER_FADE)
        steering = self.vehicle.steer_gain * self.heading_left * fade
        return Twist2D(linear_x=speed, angular_z=speed / self.radius + steering)


class DriveSequence(Drive):
    """Several drives one after the other, e.g. the sides of a shape. It fails as soon as one of them fails."""

    def __init__(self, legs: List[Leg]) -> None:
        super().__init__(legs[0].goal)
        self._legs = legs
        self._index = 0

    def step(self, pose: VehicleState, dt: float) -> Twist2D:
        """Step the current leg, and continue with the next one as soon as it has arrived."""
        if self.finished:
            return STOP
        leg = self._legs[self._index]
        command = leg.step(pose, dt)
        self.goal, self.distance_left, self.heading_left = leg.goal, leg.distance_left, leg.heading_left
        if leg.state is State.ARRIVED and self._index + 1 < len(self._legs):
            self._index += 1
        elif leg.state is State.FAILED:
            self.end(State.FAILED, f'on the way to corner {self._index + 1} of {len(self._legs)}: {leg.reason}')
        else:
            self.state = leg.state
        return command
