"""The rules about driving and drawing; see judging.py for their form."""
import itertools
import math
import statistics
from types import SimpleNamespace
from typing import Any, Callable, Dict, List, Protocol, Sequence, Tuple

import numpy as np

from alvar_core.arrays import ArrayLike, Floats
from course_grader.rules import fits
from course_grader.rules.judging import ANY, MISSED, Result, counted, nearness, period, within, written
from course_grader.rules.observation import Command, Observed, Sample, whole_turn
from kinematic_core.worlds.turtle_world import PEN_COLOUR, PEN_WIDTH

OPEN, CLOSED = 0.5, 0.95  # covered shares of an outline: not yet a shape, and closed; three of four sides lie between
MOVING = 0.5  # [s] of standstill at most
WAYS = {'teleports': ('teleport', 'teleport_relative'), 'teleport_absolute': ('teleport',),
        'teleport_relative': ('teleport_relative',)}  # parameter ``by``: kinds of events


class ScoredRule(Protocol):
    """The attributes of an exercise's rule that are used here."""

    @property
    def name(self) -> str: ...  # noqa: D102

    @property
    def parameters(self) -> Dict[str, Any]: ...  # noqa: D102

    @property
    def robot(self) -> str: ...  # noqa: D102


def draws(observed: Observed, wanted: SimpleNamespace) -> Result:
    """The path, or its end, is a closed shape, wherever it lies, or a line through points."""
    shape = f'line through {_listed(wanted.through)}' if wanted.shape == fits.LINE else wanted.shape
    asked = f'{_article(shape)} {shape}, within {wanted.tolerance:g} m'
    asked += '' if wanted.size == ANY else f', size {written(wanted.size, "m")}'
    found = drawn_shape(observed, wanted)
    if not found.quality:
        return Result(0.0, asked, _path_text(observed, f'that matches no {wanted.shape}') + _unfinished(observed))
    seen = (f'{found.on_outline:.0%} of the path lies on {_article(wanted.shape)} {wanted.shape} of size '
            f'{found.size:.2f} m, of which '
            f'{found.covered:.0%} was drawn{_unfinished(observed) if found.covered < CLOSED else ""}')
    return Result(found.on_outline * _closed(found) * (1.0 if within(found.size, wanted.size) else MISSED), asked, seen)


def drawn_shape(observed: Observed, wanted: SimpleNamespace) -> fits.Fit:
    """Return the Fit of the path to the shape that is ``wanted``, by the parameters of ``draws``."""
    return fits.fit(observed.drawn(pen_down=True), wanted.shape, wanted.tolerance, wanted.through)


def _article(noun: str) -> str:
    return 'an' if noun.startswith('eight') else 'a'


def _listed(points: Sequence[Tuple[float, float]]) -> str:
    return ', '.join(f'({x:g}, {y:g})' for x, y in points)


def traces(observed: Observed, wanted: SimpleNamespace) -> Sequence[Floats]:
    """Return the parts of the path that count for ``draws``; empty if they do not form a shape."""
    found = drawn_shape(observed, wanted)
    return found.traces if _closed(found) > 0.0 else ()


def _closed(found: fits.Fit) -> float:
    return min(1.0, max(0.0, (found.covered - OPEN) / (CLOSED - OPEN)))


def _unfinished(observed: Observed) -> str:
    """Return a clause about a path that was not finished in time, or ''."""
    going_on = observed.timed_out and observed.exit_code is None and observed.standstill() < MOVING
    return f'; it was still moving when the time was over, after {observed.seconds:.0f} s' if going_on else ''


def commands(observed: Observed, wanted: SimpleNamespace) -> Result:
    """Velocity commands come at a rate with these velocities; the share of such commands counts."""
    every = (('linear.x', wanted.linear, 'm/s'), ('linear.y', wanted.sideways, 'm/s'),
             ('angular.z', wanted.angular, 'rad/s'), ('|angular.z|', wanted.turning, 'rad/s'),
             ('|linear.x|', wanted.pace, 'm/s'))
    parts = [part for part in every if part[1] != ANY]
    asked = ', '.join([f'{name} {written(span, unit)}' for name, span, unit in parts]
                      + ([written(wanted.rate, 'Hz')] if wanted.rate != ANY else []))
    given = observed.commands
    if wanted.after:
        called = min((call.t for call in observed.calls if call.service == wanted.after), default=math.inf)
        early = sum(command.t < called for command in given)
        asked += f', after {wanted.after} was called'
        if early:
            return Result(0.0, f'velocity commands: {asked}', f'{early} of {len(given)} commands before the call')
    if len(given) < 2:
        return Result(0.0, f'velocity commands: {asked}', f'{len(given)} commands')
    values: Dict[str, Callable[[Command], float]] = {
        'linear.x': lambda command: command.linear_x, 'linear.y': lambda command: command.linear_y,
        'angular.z': lambda command: command.angular_z, '|angular.z|': lambda command: abs(command.angular_z),
        '|linear.x|': lambda command: abs(command.linear_x)}
    right = [all(within(values[name](command), span) for name, span, _ in parts) for command in given]
    rate = 1.0 / max(period([command.t for command in given]), 1e-6)
    share = sum(right) / len(right) * nearness(rate, wanted.rate)
    seen = ', '.join([f'{name} {statistics.median(map(values[name], given)):.2f} {unit}' for name, _, unit in parts]
                     + [f'{rate:.1f} Hz', f'{sum(right)} of {len(right)} commands match'])
    return Result(share, f'velocity commands: {asked}', seen)


def moves(observed: Observed, wanted: SimpleNamespace) -> Result:
    """The turtle or robot covers some distance."""
    length = fits.path_length(observed.drawn())
    return Result(min(1.0, length / wanted.length), f'a path of at least {wanted.length:g} m', f'{length:.2f} m')


def stops(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It comes to rest at x, at y, or at both."""
    goals = {axis: value for axis, value in (('x', wanted.x), ('y', wanted.y)) if value is not None}
    goal = ' and '.join(f'{axis} = {value:g}' for axis, value in goals.items())
    asked = f'a stop at {goal}, within {wanted.tolerance:g} m'
    length = fits.path_length(observed.drawn())
    if length < 10.0 * wanted.tolerance:
        return Result(0.0, asked, _path_text(observed, 'is too short'))
    last = observed.track[-1]
    if observed.standstill() < wanted.rest:
        return Result(0.0, asked, f'still moving when the time was over, at x = {last.x:.2f}, y = {last.y:.2f}')
    miss = max((abs(getattr(last, axis) - value) for axis, value in goals.items()), default=0.0)
    share = 1.0 if miss <= wanted.tolerance else MISSED * max(0.0, 1.0 - miss / wanted.size)
    return Result(share, asked, f'it stopped at x = {last.x:.3f}, y = {last.y:.3f}')


def passes(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It drives past a point, or past several in this order."""
    points = wanted.through or [(wanted.x, wanted.y)]
    places = _listed(points) + ' in this order' if wanted.through else f'x = {wanted.x:g}, y = {wanted.y:g}'
    asked = f'the path leads past {places}, within {wanted.tolerance:g} m'
    path = observed.drawn()
    if not fits.path_length(path):
        return Result(0.0, asked, 'it did not move')
    passed, rest = _passed(path, points, wanted.tolerance)
    x, y = points[min(passed, len(points) - 1)]
    apart = min(math.dist(position, (x, y)) for position in path[rest:])
    seen = _path_text(observed, f'that comes as near as {apart:.2f} m')
    if wanted.through:
        seen = f'it passes {passed} of {len(points)} in this order' + (
            '' if passed == len(points) else f', and comes as near as {apart:.2f} m to ({x:g}, {y:g}) after that')
    return Result(counted(passed, len(points)), asked, seen)


def same_path(observed: Observed, wanted: SimpleNamespace) -> Result:
    """The path is that of the exercise's solution, from the same start, in the same direction."""
    points = fits.resample(observed.solution)
    asked = f'the path of the solution, {fits.path_length(observed.solution):.2f} m, within {wanted.tolerance:g} m'
    path = observed.drawn()
    if not (fits.path_length(path) and len(points)):  # the solution itself is graded without one
        return Result(0.0, asked, _path_text(observed, 'is compared with nothing'))
    passed, _ = _passed(path, points, wanted.tolerance)
    share = fits.compared(fits.resample(path), points, wanted.tolerance).on_outline
    seen = _path_text(observed, f'of which {share:.0%} lies there')
    if passed < len(points):
        x, y = points[passed]
        seen += (f'; it follows the solution for {passed / len(points):.0%} of its way, and does not reach '
                 f'({x:.2f}, {y:.2f})')
    return Result(counted(passed, len(points)) * share, asked, seen)


def _passed(path: ArrayLike, points: ArrayLike, tolerance: float) -> Tuple[int, int]:
    """Return how many points a path passes in their order, and the index in the path where it passes the last one."""
    line, passed, rest = np.asarray(path, float), 0, 0
    for point in np.asarray(points, float):
        near = np.flatnonzero(np.hypot(*(line[rest:] - point).T) <= tolerance)
        if not len(near):
            break
        passed, rest = passed + 1, rest + int(near[0])
    return passed, rest


def apart(observed: Observed, wanted: SimpleNamespace) -> Result:
    """No two of several robots come closer to each other than a distance."""
    asked = f'{" and ".join(observed.robots)} stay at least {wanted.distance:g} m apart'
    places = {name: {sample.t: (sample.x, sample.y) for sample in driven.track}
              for name, driven in observed.robots.items()}
    nearest = min(((math.dist(places[one][t], places[other][t]), t, one, other)
                   for one, other in itertools.combinations(places, 2) for t in places[one] if t in places[other]),
                  default=None)
    if nearest is None:
        return Result(0.0, asked, 'they were not observed at the same time')
    distance, t, one, other = nearest
    return Result(1.0 if distance >= wanted.distance else 0.0, asked,
                  f'{one} and {other} come as near as {distance:.2f} m, after {t - observed.start:.1f} s')


def repeats(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It drives again what the grader drove before its first command, from where that ended."""
    asked = f'the path that the grader drove, once more, within {wanted.tolerance:g} m'
    if not observed.commands:
        return Result(0.0, asked, 'it sent no command')
    moment = observed.commands[0].t
    paths = [_from_its_start([sample for sample in observed.track if (sample.t <= moment) == first])
             for first in (True, False)]
    if not all(map(len, paths)):
        return Result(0.0, asked, 'it did not move')
    length = fits.path_length([(x, y) for x, y in paths[1]])
    apart = float(np.hypot(*(paths[0] - paths[1]).T).max())
    share = 1.0 if apart <= wanted.tolerance else MISSED * max(0.0, 1.0 - apart)
    return Result(share, asked, f'a path of {length:.2f} m that is up to {apart:.2f} m off')


def _from_its_start(track: Sequence[Sample]) -> Floats:
    """Return points at equal distances along a path, relative to its first pose; empty for a path without length."""
    even = fits.resample([(sample.x, sample.y) for sample in track])
    if not len(even):
        return even
    start = track[0]
    cos, sin = math.cos(start.theta), math.sin(start.theta)
    turned: Floats = (even - (start.x, start.y)) @ np.array([[cos, -sin], [sin, cos]])
    return turned


def positions(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It visits a number of different positions, by teleports or by driving there and resting or turning."""
    reset = observed.reset_at()
    visited, different = _visited(observed, wanted)
    others = len([event for event in observed.of_kind(*WAYS['teleports']) if event.t >= reset]) - len(visited)
    listed = ', '.join(f'({x:.1f}, {y:.1f})' for x, y in different[:8]) or 'none'
    listed += f'; {others} teleports by another service' if wanted.by in WAYS and others else ''
    return Result(counted(len(different), wanted.count),
                  f'{wanted.count} positions at least {wanted.apart:g} m apart, by {wanted.by}',
                  f'{len(different)}: {listed}')


def _visited(observed: Observed, wanted: SimpleNamespace
             ) -> Tuple[Sequence[Tuple[float, ...]], List[Tuple[float, ...]]]:
    """Return (all positions that it visited, those that are different), by the parameters of ``positions``."""
    visited: Sequence[Tuple[float, ...]] = fits.corners(observed.drawn())
    if wanted.by in WAYS:
        visited = [event.values[:2] for event in observed.of_kind(*WAYS[wanted.by]) if event.t >= observed.reset_at()]
    different: List[Tuple[float, ...]] = []
    for position in visited:
        if all(math.dist(position, other) >= wanted.apart for other in different):
            different.append(position)
    return visited, different


def counted_parts(rules: Sequence[ScoredRule], observed: Observed) -> List[Floats]:
    """Return the parts of the path, or points, that counted, each of shape (n, 2) [m]."""
    parts: List[Floats] = []
    for rule in rules:
        wanted, seen = SimpleNamespace(**rule.parameters), observed.of_robot(rule.robot)
        if rule.name == 'draws':
            parts += traces(seen, wanted)
        elif rule.name == 'positions':
            parts += [np.array([position[:2]]) for position in _visited(seen, wanted)[1]]
        elif rule.name == 'stops' and stops(seen, wanted).share > MISSED:
            parts.append(np.array([seen.track[-1][1:3]]))
    return parts


def pen(observed: Observed, wanted: SimpleNamespace) -> Result:
    """The path is drawn in a colour; the share of its length with the pen down counts."""
    red, green, blue = wanted.colour
    asked = f'the path in the colour ({red}, {green}, {blue})'
    asked += '' if wanted.width == ANY else f', width {written(wanted.width, "px")}'
    drawn = right = 0.0
    reset = observed.reset_at()
    for before, after, pen in zip(observed.track, observed.track[1:], observed.pens()[1:]):
        if before.t < reset:
            continue
        r, g, b, width, off = pen or (*PEN_COLOUR, PEN_WIDTH, 0)
        step = 0.0 if off else math.hypot(after.x - before.x, after.y - before.y)
        drawn += step
        right += step * ((r, g, b) == tuple(wanted.colour) and within(max(1, width), wanted.width))
    changes = observed.of_kind('pen')
    used = ', '.join(sorted({f'({r}, {g}, {b}) width {width}' for r, g, b, width, off in
                             (change.values for change in changes) if not off})) or 'the pen was not set'
    return Result(right / drawn if drawn else 0.0, asked,
                  f'{right / drawn:.0%} of the path; pens: {used}' if drawn else f'no path; pens: {used}')


def _path_text(observed: Observed, judgement: str) -> str:
    length, turned = fits.path_length(observed.drawn()), turned_on_the_spot(observed)
    return (f'it only turned, by {turned:.0f} degrees in all' if turned else 'it did not move' if length < 0.01 else
            f'a path of {length:.2f} m {judgement}')


def turned_on_the_spot(observed: Observed) -> float:
    """Return by how many degrees a vehicle has turned that never drove, otherwise 0."""
    angle = whole_turn(observed.track)
    return math.degrees(angle) if fits.path_length(observed.drawn()) < 0.01 and angle > 0.01 else 0.0
