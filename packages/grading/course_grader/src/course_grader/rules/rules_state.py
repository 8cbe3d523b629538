"""The rules about parameters, transforms, sensors and turtles other than turtle1; see judging.py."""
import bisect
import math
import statistics
from dataclasses import dataclass
from typing import Callable, Dict, List, NamedTuple, Optional

from course_grader.rules.judging import ANY, Colour, Result, Rule, Span, counted, key, nearness, period, written
from course_grader.rules.observation import ANGLES, QUANTITIES, Command, Observed, Sensed, Transform

MIN_STAMPED = 0.8  # of the transforms; at the end of a run, some may arrive late
MAX_DELAY = 0.3  # [s] between a transform and its pose
MAX_TURN = 0.15  # [rad] between the headings of transform and vehicle; in MAX_DELAY it turns by less than 0.3
MAX_STEP = 0.5  # [m] between two poses of a driven turtle, even if poses are late
STANDING = 1e-3  # [m/s] below it, a command neither drives forward nor backward
REACTION = 0.5  # [s] after which a command must fit to a marker that was turned
SMALLEST = 0.05  # [m/s or rad/s for each rad] a smaller factor does not steer
ALIKE = 0.98  # correlation of a velocity with another angle, above which it follows that one
COMMANDS: Dict[str, Callable[[Command], float]] = {
    'linear.x': lambda command: command.linear_x, 'linear.y': lambda command: command.linear_y,
    'angular.z': lambda command: command.angular_z}
STAY_TIME = 1.0  # [s] at the end for which a turtle must be beside turtle1


@dataclass(frozen=True)
class HasParameter(Rule):
    """A parameter is set."""

    name: str = key('name', ..., 'full name of the parameter')
    value: object = key('value', None, 'a number, a text, true or false')

    def judge(self, observed: Observed) -> Result:
        asked = f'the parameter {self.name} is ' + ('set' if self.value is None else f'{self.value!r}')
        if self.name not in observed.parameters:
            return Result(0.0, asked, 'it is not set')
        value = observed.parameters[self.name]
        return Result(float(self.value is None or _equal(value, self.value)), asked, f'it is {value!r:.80}')


@dataclass(frozen=True)
class Background(Rule):
    """The background has a colour, which it takes from the parameters when /clear is called."""

    colour: Colour = key('colour', ..., '`[red, green, blue]`, 0 to 255 each')

    def judge(self, observed: Observed) -> Result:
        asked = 'the background in the colour ({}, {}, {}) after /clear'.format(*self.colour)
        cleared = [event.values for event in observed.of_kind('clear', 'reset')]
        if not cleared:
            return Result(0.0, asked, '/clear was not called')
        shown = tuple(int(value) for value in cleared[-1])
        return Result(float(shown == tuple(self.colour)), asked, f'it is {shown}')


def _equal(value: object, expected: object) -> bool:
    """Return whether two values are equal: 1 and 1.0 are, 1 and true are not."""
    if isinstance(value, bool) or isinstance(expected, bool):
        return value is expected
    if isinstance(value, (int, float)) and isinstance(expected, (int, float)):
        return math.isclose(value, expected, rel_tol=1e-6)
    return value == expected


@dataclass(frozen=True)
class HasTransform(Rule):
    """It broadcasts the transform between two frames, with time stamps."""

    parent: str = key('text', ..., 'the frame that it starts from')
    child: str = key('text', ..., 'the frame that it leads to')
    rate: Span = key('span rate', ANY, 'transforms per second')
    at: str = key(('the vehicle', 'any'), 'any', 'the vehicle: its position and heading are asked')
    tolerance: float = key('length', 0.05, 'how far off that position may be')

    def judge(self, observed: Observed) -> Result:
        parent, child = self.parent.lstrip('/'), self.child.lstrip('/')
        asked = f'transforms from {parent} to {child}'
        asked += ' at the position and heading of the turtle or robot' if self.at == 'the vehicle' else ''
        asked += '' if self.rate == ANY else f', {written(self.rate, "Hz")}'
        given = [one for one in observed.transforms if (one.parent, one.child) == (parent, child)]
        if not given:
            others = sorted({f'{one.parent} to {one.child}' for one in observed.transforms})
            return Result(0.0, asked, f'only {", ".join(others[:8])}' if others else 'none')
        share, seen = 1.0, f'{len(given)} transforms'
        if self.at == 'the vehicle':
            times = [sample.t for sample in observed.track]
            right = sum(_was_there(observed, times, one, self.tolerance) for one in given)
            turned = sum(_was_there(observed, times, one, self.tolerance, MAX_TURN) for one in given)
            share, seen = turned / len(given), f'{seen}, {right} at its position, {turned} with its heading'
        stamped = sum(one.stamped for one in given)
        if len(given) > 1 and stamped < MIN_STAMPED * len(given):
            share, seen = 0.0, f'{seen}, {stamped} with the current time as their stamp'
        if self.rate != ANY:
            rate = 1.0 / max(period([one.t for one in given]), 1e-6) if len(given) > 1 else 0.0
            share, seen = share * (nearness(rate, self.rate) if rate else 0.0), f'{seen}, {rate:.1f} Hz'
        return Result(share, asked, seen)


def _was_there(observed: Observed, times: List[float], one: Transform, tolerance: float, turned: float = math.inf
               ) -> bool:
    """Return whether the vehicle was at the position of a transform at about that time, within ``turned`` [rad]."""
    near = slice(bisect.bisect_left(times, one.t - MAX_DELAY), bisect.bisect_right(times, one.t + MAX_DELAY))
    return any(math.hypot(sample.x - one.x, sample.y - one.y) <= tolerance
               and abs(math.remainder(sample.theta - one.theta, math.tau)) <= turned for sample in observed.track[near])


@dataclass(frozen=True)
class Keeps(Rule):
    """It keeps a distance, or a marker at its place, until the end."""

    what: str = key(tuple(QUANTITIES), ...,
                    'ahead: the distance of stimulus distances; marker ahead, marker left: where the marker is')
    value: float = key('coordinate', ..., 'what it should be')
    tolerance: float = key('length', 0.1, 'how far off it may be')
    last: float = key('time', 5.0, 'how long at the end; the share of that time counts')
    swings: Optional[float] = key('number', None, 'how often linear.x may change its sign; no points beyond it')

    def judge(self, observed: Observed) -> Result:
        what = QUANTITIES[self.what]
        asked = f'{what} by {self.value:g} m, within {self.tolerance:g} m, for the last {self.last:g} s'
        values = [(one.t, one.value) for one in observed.sensed if one.what == self.what]
        late = [value for t, value in values if t >= values[-1][0] - self.last]
        if not late:
            return Result(0.0, asked, 'the program subscribes to no sensor')
        swings = _swings(observed)
        if self.swings is not None and swings > self.swings:
            return Result(0.0, f'{asked}, with at most {self.swings:g} changes between forward and backward',
                          f'{swings} changes between forward and backward')
        near = sum(abs(value - self.value) <= self.tolerance for value in late)
        known = [value for value in late if not math.isnan(value)]
        between = f'{min(known):.2f} to {max(known):.2f} m' if known else 'unknown, as it is too near'
        return Result(near / len(late), asked, f'{what} by {between}; {near / len(late):.0%} of the time within')


def _swings(observed: Observed) -> int:
    """Return how often the commands change between forward and backward."""
    speeds = [command.linear_x for command in observed.commands if abs(command.linear_x) > STANDING]
    return sum(a * b < 0.0 for a, b in zip(speeds, speeds[1:]))


@dataclass(frozen=True)
class Spawns(Rule):
    """It spawns a turtle."""

    turtle: str = key('text', ..., 'its name')
    x: float = key('coordinate', ..., 'where it starts')
    y: float = key('coordinate', ..., 'where it starts')
    tolerance: float = key('length', 0.05, 'how far off that it may be')

    def judge(self, observed: Observed) -> Result:
        asked = f'a turtle {self.turtle} at x = {self.x:.2f}, y = {self.y:.2f}'
        track = observed.turtles.get(self.turtle, [])
        if not track:
            return Result(0.0, asked, f'there is no {self.turtle}')
        seen = f'it starts at x = {track[0].x:.2f}, y = {track[0].y:.2f}'
        return Result(float(math.hypot(track[0].x - self.x, track[0].y - self.y) <= self.tolerance), asked, seen)


@dataclass(frozen=True)
class Follows(Rule):
    """A turtle drives to turtle1 and stays there."""

    turtle: str = key('text', ..., 'the name of the turtle that follows turtle1')
    distance: float = key('length', 0.1, 'how near it has to be at the end')

    def judge(self, observed: Observed) -> Result:
        asked = f'{self.turtle} drives to turtle1 and stays within {self.distance:.2f} m of it'
        track = observed.turtles.get(self.turtle, [])
        if not track or not observed.track:
            return Result(0.0, asked, f'there is no {self.turtle}')
        if any(math.hypot(b.x - a.x, b.y - a.y) > MAX_STEP for a, b in zip(track, track[1:])):
            return Result(0.0, asked, 'it jumps')
        times = [sample.t for sample in observed.track]
        late = [sample for sample in track if sample.t >= track[-1].t - STAY_TIME]
        leaders = (observed.track[min(bisect.bisect_left(times, sample.t), len(times) - 1)] for sample in late)
        apart = [math.hypot(one.x - leader.x, one.y - leader.y) for one, leader in zip(late, leaders)]
        share = sum(distance <= self.distance for distance in apart) / len(apart)
        return Result(share, asked, f'at the end it is {apart[-1]:.2f} m away')


class _Held(NamedTuple):
    """A pose in which the grader held the marker: its angles [rad], NaN for no marker, and the velocity then."""

    angles: Dict[str, float]
    velocity: float  # median of the commands, NaN if there are none


@dataclass(frozen=True)
class Steers(Rule):
    """A velocity is proportional to an angle of the marker that the grader turns, to both sides; 0 without a marker."""

    command: str = key(tuple(COMMANDS), ..., 'the velocity')
    by: str = key(ANGLES, ..., 'the angle of the marker that stimulus turns shows')
    tolerance: float = key('share', 0.1, 'how far off a velocity may be, as a share of the largest one')

    def judge(self, observed: Observed) -> Result:
        asked = f'{self.command} proportional to {self.by}, with the same sign, and 0 without a marker'
        held = _held(observed, self.command)
        turned = [one for one in held if not math.isnan(one.angles[self.by])]
        if not turned:
            return Result(0.0, asked, 'the program subscribes to no marker')
        if all(math.isnan(one.velocity) for one in held):
            return Result(0.0, asked, '0 commands')
        commanded = [one for one in turned if not math.isnan(one.velocity)]
        if not commanded:
            return Result(0.0, asked, 'no command while a marker is seen')
        angles = [one.angles[self.by] for one in commanded]
        factor = (sum(angle * one.velocity for angle, one in zip(angles, commanded))
                  / max(1e-9, sum(angle * angle for angle in angles)))
        other = _other_angle(commanded, self.by)
        if other:
            return Result(0.0, asked, f'it follows {other}, not {self.by}')
        one_side = ', and never negative' if min(one.velocity for one in commanded) > -STANDING else ''
        if factor < SMALLEST:
            wrong = f'it has the other sign than {self.by}' if factor < -SMALLEST and not one_side else \
                f'it does not follow {self.by}'
            return Result(0.0, asked, f'{wrong}: it is {factor:.2f} times {self.by}{one_side}')
        slack = self.tolerance * factor * max(map(abs, angles))
        right = sum(abs(one.velocity - factor * one.angles[self.by]) <= slack for one in commanded)
        hidden = [one for one in held if one not in turned]
        still = sum(math.isnan(one.velocity) or abs(one.velocity) < STANDING for one in hidden)
        seen = (f'about {factor:.2f} times {self.by}; it fits in {right} of {len(turned)} poses{one_side}, and it is 0 '
                f'in {still} of {len(hidden)} without a marker')
        return Result(counted(right + still, len(held)), asked, seen)


def _held(observed: Observed, command: str) -> List[_Held]:
    """Return the poses of the marker, with the velocities that the program commanded while it was held so."""
    shown: Dict[str, List[Sensed]] = {what: [one for one in observed.sensed if one.what == what] for what in ANGLES}
    starts = [one.t for one in shown[ANGLES[0]]]
    ends = [*starts[1:], *([starts[-1] + (starts[-1] - starts[-2] if len(starts) > 1 else 2.0)] if starts else ())]
    held = []
    for number, (start, end) in enumerate(zip(starts, ends)):
        given = [COMMANDS[command](one) for one in observed.commands if start + REACTION <= one.t < end]
        held.append(_Held({what: shown[what][number].value for what in ANGLES},
                          statistics.median(given) if given else math.nan))
    return held


def _other_angle(held: List[_Held], by: str) -> Optional[str]:
    """Return the angle other than ``by`` that the velocities are proportional to, or None."""
    def likeness(what: str) -> float:
        angles, velocities = [one.angles[what] for one in held], [one.velocity for one in held]
        size = math.sqrt(sum(a * a for a in angles) * sum(v * v for v in velocities))
        return sum(a * v for a, v in zip(angles, velocities)) / size if size > 0.0 else 0.0
    found = max((what for what in ANGLES if what != by), key=lambda what: abs(likeness(what)))
    return found if abs(likeness(found)) > ALIKE else None
