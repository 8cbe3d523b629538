"""The random values of a seed: the start of the turtle or robot, and the stimuli. Without ROS.

All seeds are equally hard: each has the same number of markers and calls, and no number that a program should print is
close to another one that it could print by mistake.
"""
import dataclasses
import itertools
import math
import random
from typing import Any, Callable, Dict, Iterator, List, Mapping, Optional, Tuple

from course_grader.rules.exercise import Exercise
from course_grader.rules.judging import Rule, Span
from course_grader.rules.rules_driving import Draws, Passes, Stops
from kinematic_core.worlds.angles import wrap_angle

Position = Tuple[float, float, float]
SHIFTED = 'panels', 'boxes', 'cylinders'  # lists of a world

LEG = 2.0  # [s] for which a drawn velocity, or the pose of a marker, lasts
ORDERS = range(3, 8)  # of Fibonacci numbers
IDS = range(20, 200)  # of markers; larger than counters and indices of a program
MARKER_SPACE: Tuple[Span, Span, Span] = ((-0.8, 0.8), (-0.5, 0.5), (0.4, 3.0))  # [m] where markers are shown: x, y, z
MIN_DISTANCE = 0.06  # [m] between x of a marker and y or z of its neighbour, which may be printed with one decimal
MAX_DRAWS = 50  # attempts to find such a number; beside many markers there may be none
TILT: Span = (0.15, 0.5)  # [rad] to either side, of roll and pitch
YAW: Span = (-1.0, 1.0)  # [rad] so large that a part of the quaternion is no measure of roll or pitch
HIDDEN_EVERY = 4  # in this many poses, one without a marker
MIDDLE = 0.6  # share of a section from which its number is drawn, so that two numbers are never close
MIDDLE_OF_ARENA: Span = (4.0, 7.0)  # [m] where turtles start by default


def start(exercise: Exercise, seed: int) -> Dict[str, float]:
    """Return {x, y, theta} of the start [m, m, rad]."""
    numbers = random.Random(seed)
    limits = {**dict.fromkeys('xy', MIDDLE_OF_ARENA if exercise.simulator == 'turtlesim' else (0.0, 0.0)),
              **exercise.start}
    return _drawn(limits, numbers)


def _drawn(limits: Mapping[str, Span], numbers: random.Random) -> Dict[str, float]:
    """Return a pose, with a heading from -pi to pi, whatever the exercise says."""
    x, y, theta = (numbers.uniform(*limits[axis]) for axis in ('x', 'y', 'theta'))
    return {'x': x, 'y': y, 'theta': wrap_angle(theta)}


def robots(exercise: Exercise, seed: int) -> Dict[str, Dict[str, float]]:
    """Return {name: {x, y, theta}} of the starts of several robots [m, m, rad]."""
    numbers = random.Random(seed)
    return {name: _drawn(limits, numbers) for name, limits in exercise.robots.items()}


def shifted(exercise: Exercise, seed: int) -> Exercise:
    """Return an exercise whose world, and the points that its checks ask for, are shifted as the seed says."""
    if not exercise.shift:
        return exercise
    numbers = random.Random(~seed)  # others than those of the start
    by = {axis: round(numbers.uniform(*exercise.shift[axis]), 2) for axis in 'xy'}  # so that a report reads well
    world = {kind: [_moved(thing, by) for thing in things] if kind in SHIFTED else things
             for kind, things in exercise.world.items()}
    rules = [scored._replace(rule=_moved_rule(scored.rule, by)) for scored in exercise.rules]
    return exercise._replace(world=world, rules=rules)


def _moved(thing: Mapping[str, Any], by: Mapping[str, float]) -> Dict[str, Any]:
    """Return a thing of a world, moved; its path [[t, x, y, yaw], ...], too."""
    moved = {**thing, **{axis: round(thing[axis] + by[axis], 6) for axis in 'xy' if axis in thing}}
    if 'path' in moved:
        moved['path'] = [[t, x + by['x'], y + by['y'], *others] for t, x, y, *others in moved['path']]
    return moved


def _moved_rule(rule: Rule, by: Mapping[str, float]) -> Rule:
    """Return a rule whose points are moved."""
    changes: Dict[str, Any] = {}
    if isinstance(rule, (Stops, Passes)):
        changes = {axis: round(value + by[axis], 6) for axis, value in (('x', rule.x), ('y', rule.y))
                   if value is not None}
    if isinstance(rule, (Draws, Passes)):
        changes['through'] = [(round(x + by['x'], 6), round(y + by['y'], 6)) for x, y in rule.through]
    return dataclasses.replace(rule, **changes)


def stimuli(exercise: Exercise, seed: int) -> List[List[Any]]:
    """Draw values for each stimulus of an exercise: velocities, requests, or {id: position} of markers."""
    numbers = random.Random(seed)
    draws: Dict[str, Callable[[Mapping[str, Any], random.Random], List[Any]]] = {
        'drive': _velocities, 'call': _requests, 'markers': _markers, 'goals': _orders, 'turns': _turns,
        'carry': _poses,
        **dict.fromkeys(('move', 'destinations', 'distances', 'tracker'), lambda values, numbers: [])}
    return [draws[what](values, numbers) for what, values in exercise.stimuli]


def _velocities(values: Mapping[str, Any], numbers: random.Random) -> List[Tuple[float, float]]:
    """Return (linear, angular) of each leg: the faster, the less it turns, so that no two legs are equal arcs."""
    count = int(values['for'] / LEG) + 1
    linear = _apart(values['linear'], count, numbers)
    angular = sorted(_apart(values['angular'], count, numbers))
    slowest_last = sorted(range(count), key=lambda leg: -linear[leg])
    return [(linear[leg], angular[slowest_last.index(leg)]) for leg in range(count)]


def _poses(values: Mapping[str, Any], numbers: random.Random) -> List[Position]:
    """Return the pose [m, m, rad] to which the robot is carried."""
    pose = _drawn(values, numbers)
    return [(pose['x'], pose['y'], pose['theta'])]


def _turns(values: Mapping[str, Any], numbers: random.Random) -> List[Optional[Tuple[float, float, float]]]:
    """Return (roll, pitch, yaw) [rad] of each pose, None for no marker; both signs of roll and pitch in all pairs."""
    count = int(values['for'] / LEG)
    signs = [(roll, pitch) for roll in (-1.0, 1.0) for pitch in (-1.0, 1.0)]
    turned: List[Optional[Tuple[float, float, float]]] = []
    pairs: List[Tuple[float, float]] = []
    for number in range(count):
        if number % HIDDEN_EVERY == 1:
            turned.append(None)
            continue
        pairs = pairs or numbers.sample(signs, len(signs))
        roll, pitch = pairs.pop()
        turned.append((roll * numbers.uniform(*TILT), pitch * numbers.uniform(*TILT), numbers.uniform(*YAW)))
    return turned


def _orders(values: Mapping[str, Any], numbers: random.Random) -> List[int]:
    """Return different orders of Fibonacci numbers."""
    return numbers.sample(ORDERS, values['times'])


def _requests(values: Mapping[str, Any], numbers: random.Random) -> List[Tuple[float, ...]]:
    """Return the requests; each number is of another section of its span in each request."""
    fields = [_apart(limits, values['times'], numbers) for limits in values['request']]
    if not fields:  # a request without fields, such as that of std_srvs/Trigger
        return [()] * values['times']
    return [tuple(round(number, 2) for number in request) for request in zip(*fields)]


def _apart(limits: Span, count: int, numbers: random.Random) -> List[float]:
    """Return ``count`` numbers in random order, one from each of as many sections of a span."""
    low, high = limits
    size = (high - low) / max(1, count)
    drawn = [low + size * (section + 0.5 + MIDDLE * (numbers.random() - 0.5)) for section in range(count)]
    numbers.shuffle(drawn)
    return drawn


def _markers(values: Mapping[str, Any], numbers: random.Random) -> List[Dict[int, Position]]:
    """Return the markers of each message; every other one has none, and no two have the same id."""
    messages, most = int(values['for'] * values['rate']), values['most']
    counts = [most - number % most for number in range(math.ceil(messages / 2))]
    numbers.shuffle(counts)
    ids = itertools.cycle(numbers.sample(IDS, len(IDS)))
    across = iter(_apart(MARKER_SPACE[0], sum(counts), numbers))
    shows = [_show([next(across) for _ in range(count)], ids, numbers) for count in counts]
    return [shows[number // 2] if number % 2 == 0 else {} for number in range(messages)]


def _show(across: List[float], ids: Iterator[int], numbers: random.Random) -> Dict[int, Position]:
    def other(limits: Span) -> float:
        drawn = [numbers.uniform(*limits) for _ in range(MAX_DRAWS)]
        return round(next((one for one in drawn if all(abs(one - x) >= MIN_DISTANCE for x in across)), drawn[0]), 3)
    return {marker: (round(x, 3), other(MARKER_SPACE[1]), other(MARKER_SPACE[2])) for x, marker in zip(across, ids)}
