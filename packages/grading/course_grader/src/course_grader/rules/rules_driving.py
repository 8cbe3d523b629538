"""The rules about driving and drawing; judging.py says what a rule is."""
import itertools
import math
import statistics
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np

from course_grader.rules import fits, judging
from course_grader.rules.judging import ANY, MISSED, Colour, Point, Result, Rule, Span, counted, key, within, written
from course_grader.rules.observation import Command, Observed, Sample, whole_turn
from kinematic_core.worlds.turtle_world import PEN_COLOUR, PEN_WIDTH
from plain_support.arrays import ArrayLike, Floats

OPEN, CLOSED = 0.5, 0.95  # covered shares of an outline: not yet a shape, and closed; three of four sides lie between
MOVING = 0.5  # [s] of standstill at most
TELEPORTS = {'teleports': ('teleport', 'teleport_relative'), 'teleport_absolute': ('teleport',),
        'teleport_relative': ('teleport_relative',)}  # parameter ``by``: kinds of events


@dataclass(frozen=True)
class Draws(Rule):
    """The path, or its end, is a closed shape, wherever it lies, or a line through points."""

    shape: str = key((*fits.SHAPES, fits.LINE), ..., 'the shape; an eight is two circles that touch')
    tolerance: float = key('length', 0.1, 'how far from the outline the path may be')
    size: Span = key('span length', ANY, 'the side; of a circle, and of those of an eight, the diameter')
    through: Sequence[Point] = key('points', (), 'of a line, which is asked for at this place: '
                                   '`[[2 m, 3 m], [5 m, 3 m]]`')

    def judge(self, observed: Observed) -> Result:
        shape = f'line through {_listed(self.through)}' if self.shape == fits.LINE else self.shape
        asked = f'{_article(shape)} {shape}, within {self.tolerance:g} m'
        asked += '' if self.size == ANY else f', size {written(self.size, "m")}'
        fit = self.fit(observed)
        if not fit.quality:
            return Result(0.0, asked, _path_text(observed, f'that matches no {self.shape}') + _unfinished(observed))
        seen = (f'{fit.on_outline:.0%} of the path lies on {_article(self.shape)} {self.shape} of size '
                f'{fit.size:.2f} m, of which '
                f'{fit.covered:.0%} was drawn{_unfinished(observed) if fit.covered < CLOSED else ""}')
        share = fit.on_outline * _closed(fit)
        return Result(share if within(fit.size, self.size) else MISSED * share, asked, seen)

    def fit(self, observed: Observed) -> fits.Fit:
        """Return the Fit of the path to the shape."""
        return fits.fit(observed.drawn(pen_down=True), self.shape, self.tolerance, self.through)

    def counted_parts(self, observed: Observed) -> Sequence[Floats]:
        fit = self.fit(observed)
        return fit.traces if _closed(fit) > 0.0 else ()


def _article(noun: str) -> str:
    return 'an' if noun.startswith('eight') else 'a'


def _listed(points: Sequence[Tuple[float, float]]) -> str:
    return ', '.join(f'({x:g}, {y:g})' for x, y in points)


def _closed(fit: fits.Fit) -> float:
    """Return 0 for an open outline to 1 for a closed one."""
    return min(1.0, max(0.0, (fit.covered - OPEN) / (CLOSED - OPEN)))


def _unfinished(observed: Observed) -> str:
    """Return a clause about a path that was not finished in time, or ''."""
    if observed.timed_out and observed.exit_code is None and observed.standstill() < MOVING:
        return f'; it was still moving when the time was over, after {observed.seconds:.0f} s'
    return ''


@dataclass(frozen=True)
class Commands(Rule):
    """Velocity commands come at a rate with these velocities; the share of such commands counts."""

    rate: Span = key('span rate', ANY, 'commands per second')
    linear: Span = key('span speed', ANY, 'linear.x')
    sideways: Span = key('span speed', ANY, 'linear.y')
    angular: Span = key('span turn speed', ANY, 'angular.z, positive to the left')
    turning: Span = key('span turn speed', ANY, 'angular.z to either side, without its sign')
    pace: Span = key('span speed', ANY, 'linear.x forward or backward, without its sign')
    after: str = key('name', '', 'the service that the grader calls, before which there may be no command')

    def judge(self, observed: Observed) -> Result:
        every = (('linear.x', self.linear, 'm/s'), ('linear.y', self.sideways, 'm/s'),
                 ('angular.z', self.angular, 'rad/s'), ('|angular.z|', self.turning, 'rad/s'),
                 ('|linear.x|', self.pace, 'm/s'))
        parts = [part for part in every if part[1] != ANY]
        asked = ', '.join([f'{name} {written(span, unit)}' for name, span, unit in parts]
                          + ([written(self.rate, 'Hz')] if self.rate != ANY else []))
        given = observed.commands
        if self.after:
            called = min((call.t for call in observed.calls if call.service == self.after), default=math.inf)
            early = sum(command.t < called for command in given)
            asked += f', after {self.after} was called'
            if early:
                return Result(0.0, f'velocity commands: {asked}', f'{early} of {len(given)} commands before the call')
        if len(given) < 2:
            return Result(0.0, f'velocity commands: {asked}', f'{len(given)} commands')
        values: Dict[str, Callable[[Command], float]] = {
            'linear.x': lambda command: command.linear_x, 'linear.y': lambda command: command.linear_y,
            'angular.z': lambda command: command.angular_z, '|angular.z|': lambda command: abs(command.angular_z),
            '|linear.x|': lambda command: abs(command.linear_x)}
        right = [all(within(values[name](command), span) for name, span, _ in parts) for command in given]
        rate = 1.0 / max(judging.period([command.t for command in given]), 1e-6)
        share = sum(right) / len(right) * judging.nearness(rate, self.rate)
        seen = ', '.join([f'{name} {statistics.median(map(values[name], given)):.2f} {unit}' for name, _, unit in parts]
                         + [f'{rate:.1f} Hz', f'{sum(right)} of {len(right)} commands match'])
        return Result(share, f'velocity commands: {asked}', seen)


@dataclass(frozen=True)
class Moves(Rule):
    """The turtle or robot covers some distance."""

    length: float = key('length', ..., 'the distance')

    def judge(self, observed: Observed) -> Result:
        length = fits.path_length(observed.drawn())
        return Result(min(1.0, length / self.length), f'a path of at least {self.length:g} m', f'{length:.2f} m')


@dataclass(frozen=True)
class Stops(Rule):
    """It comes to rest at x, at y, or at both."""

    x: Optional[float] = key('coordinate', None, 'where to stop')
    y: Optional[float] = key('coordinate', None, 'where to stop')
    tolerance: float = key('length', 0.05, 'full points within this distance')
    rest: float = key('time or 0', 1.0, 'how long it has to stand still')
    size: float = key('length', 1.0, 'no points beyond this distance; less than half outside of the tolerance')

    def judge(self, observed: Observed) -> Result:
        goals = {axis: value for axis, value in (('x', self.x), ('y', self.y)) if value is not None}
        goal = ' and '.join(f'{axis} = {value:g}' for axis, value in goals.items())
        asked = f'a stop at {goal}, within {self.tolerance:g} m'
        length = fits.path_length(observed.drawn())
        if length < 10.0 * self.tolerance:
            return Result(0.0, asked, _path_text(observed, 'is too short'))
        last = observed.track[-1]
        if observed.standstill() < self.rest:
            return Result(0.0, asked, f'still moving when the time was over, at x = {last.x:.2f}, y = {last.y:.2f}')
        miss = max((abs(getattr(last, axis) - value) for axis, value in goals.items()), default=0.0)
        share = 1.0 if miss <= self.tolerance else MISSED * max(0.0, 1.0 - miss / self.size)
        return Result(share, asked, f'it stopped at x = {last.x:.3f}, y = {last.y:.3f}')

    def counted_parts(self, observed: Observed) -> Sequence[Floats]:
        if self.judge(observed).share <= MISSED:
            return ()
        last = observed.track[-1]
        return (np.array([(last.x, last.y)]),)


@dataclass(frozen=True)
class Passes(Rule):
    """It drives past a point, or past several in this order."""

    x: Optional[float] = key('coordinate', None, 'the point')
    y: Optional[float] = key('coordinate', None, 'the point')
    through: Sequence[Point] = key('points', (), 'instead of x and y, several points in this order: `[[2 m, 3 m], '
                                   '[5 m, 3 m]]`')
    tolerance: float = key('length', 0.1, 'how far from it the path may be')

    def judge(self, observed: Observed) -> Result:
        points = self.points()
        listed = _listed(points) + ' in this order' if self.through else 'x = {:g}, y = {:g}'.format(*points[0])
        asked = f'the path leads past {listed}, within {self.tolerance:g} m'
        path = observed.drawn()
        if not fits.path_length(path):
            return Result(0.0, asked, 'it did not move')
        passed, rest = _passed(path, points, self.tolerance)
        x, y = points[min(passed, len(points) - 1)]
        apart = min(math.dist(position, (x, y)) for position in path[rest:])
        seen = _path_text(observed, f'that comes as near as {apart:.2f} m')
        if self.through:
            seen = f'it passes {passed} of {len(points)} in this order'
            if passed < len(points):
                seen += f', and comes as near as {apart:.2f} m to ({x:g}, {y:g}) after that'
        return Result(counted(passed, len(points)), asked, seen)

    def points(self) -> Sequence[Point]:
        """Return the points to pass, in this order."""
        return self.through if self.x is None or self.y is None else [(self.x, self.y)]


@dataclass(frozen=True)
class SamePath(Rule):
    """The path is that of the exercise's solution, from the same start, in the same direction."""

    tolerance: float = key('length', 0.1, 'how far from it the path may be')

    def judge(self, observed: Observed) -> Result:
        points = fits.resample(observed.solution)
        asked = f'the path of the solution, {fits.path_length(observed.solution):.2f} m, within {self.tolerance:g} m'
        path = observed.drawn()
        if not (fits.path_length(path) and len(points)):  # the solution itself is graded without one
            return Result(0.0, asked, _path_text(observed, 'is compared with nothing'))
        passed, _ = _passed(path, points, self.tolerance)
        share = fits.compared(fits.resample(path), points, self.tolerance).on_outline
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


@dataclass(frozen=True)
class Apart(Rule):
    """No two of several robots come closer to each other than a distance."""

    distance: float = key('length', 0.38, 'between their middles; two Robotonts that touch are 0.36 m apart')

    def judge(self, observed: Observed) -> Result:
        asked = f'{" and ".join(observed.robots)} stay at least {self.distance:g} m apart'
        tracks = {name: {sample.t: (sample.x, sample.y) for sample in driven.track}
                  for name, driven in observed.robots.items()}
        nearest = min(((math.dist(tracks[one][t], tracks[other][t]), t, one, other)
                       for one, other in itertools.combinations(tracks, 2) for t in tracks[one] if t in tracks[other]),
                      default=None)
        if nearest is None:
            return Result(0.0, asked, 'they were not observed at the same time')
        distance, t, one, other = nearest
        return Result(1.0 if distance >= self.distance else 0.0, asked,
                      f'{one} and {other} come as near as {distance:.2f} m, after {t - observed.start:.1f} s')


@dataclass(frozen=True)
class Repeats(Rule):
    """It drives again what the grader drove before its first command, from where that ended."""

    tolerance: float = key('length', 0.1, 'how far the second path may be from the first')

    def judge(self, observed: Observed) -> Result:
        asked = f'the path that the grader drove, once more, within {self.tolerance:g} m'
        if not observed.commands:
            return Result(0.0, asked, 'it sent no command')
        moment = observed.commands[0].t
        paths = [_from_its_start([sample for sample in observed.track if (sample.t <= moment) == first])
                 for first in (True, False)]
        if not all(map(len, paths)):
            return Result(0.0, asked, 'it did not move')
        length = fits.path_length([(x, y) for x, y in paths[1]])
        apart = float(np.hypot(*(paths[0] - paths[1]).T).max())
        share = 1.0 if apart <= self.tolerance else MISSED * max(0.0, 1.0 - apart)
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


@dataclass(frozen=True)
class Positions(Rule):
    """It visits a number of different positions, by teleports or by driving there and resting or turning."""

    count: int = key('integer', ..., 'how many')
    apart: float = key('length', 0.5, 'positions closer than this count as one')
    by: str = key((*TELEPORTS, 'driving'), 'teleports', 'how it gets there; teleports: by either service')

    def judge(self, observed: Observed) -> Result:
        reset = observed.reset_at()
        visited, different = self._visited(observed)
        others = len([event for event in observed.of_kind(*TELEPORTS['teleports']) if event.t >= reset]) - len(visited)
        listed = ', '.join(f'({x:.1f}, {y:.1f})' for x, y in different[:8]) or 'none'
        if self.by in TELEPORTS and others:
            listed += f'; {others} teleports by another service'
        return Result(counted(len(different), self.count),
                      f'{self.count} positions at least {self.apart:g} m apart, by {self.by}',
                      f'{len(different)}: {listed}')

    def counted_parts(self, observed: Observed) -> Sequence[Floats]:
        return [np.array([position]) for position in self._visited(observed)[1]]

    def _visited(self, observed: Observed) -> Tuple[Sequence[Point], List[Point]]:
        """Return (all positions that it visited, those that are different)."""
        visited: Sequence[Point] = fits.corners(observed.drawn())
        if self.by in TELEPORTS:
            reset, events = observed.reset_at(), observed.of_kind(*TELEPORTS[self.by])
            visited = [(event.values[0], event.values[1]) for event in events if event.t >= reset]
        different: List[Point] = []
        for position in visited:
            if all(math.dist(position, other) >= self.apart for other in different):
                different.append(position)
        return visited, different


@dataclass(frozen=True)
class Pen(Rule):
    """The path is drawn in a colour; the share of its length with the pen down counts."""

    colour: Colour = key('colour', ..., '`[red, green, blue]`, 0 to 255 each')
    width: Span = key('span pixels', ANY, 'width of the pen')

    def judge(self, observed: Observed) -> Result:
        red, green, blue = self.colour
        asked = f'the path in the colour ({red}, {green}, {blue})'
        asked += '' if self.width == ANY else f', width {written(self.width, "px")}'
        drawn = right = 0.0
        reset = observed.reset_at()
        for before, after, pen in zip(observed.track, observed.track[1:], observed.pens()[1:]):
            if before.t < reset:
                continue
            r, g, b, width, off = pen or (*PEN_COLOUR, PEN_WIDTH, 0)
            step = 0.0 if off else math.hypot(after.x - before.x, after.y - before.y)
            drawn += step
            right += step * ((r, g, b) == tuple(self.colour) and within(max(1, width), self.width))
        changes = observed.of_kind('pen')
        used = ', '.join(sorted({f'({r}, {g}, {b}) width {width}' for r, g, b, width, off in
                                 (change.values for change in changes) if not off})) or 'the pen was not set'
        return Result(right / drawn if drawn else 0.0, asked,
                      f'{right / drawn:.0%} of the path; pens: {used}' if drawn else f'no path; pens: {used}')


def _path_text(observed: Observed, judgement: str) -> str:
    length, turned = fits.path_length(observed.drawn()), turned_on_the_spot(observed)
    if turned:
        return f'it only turned, by {turned:.0f} degrees in all'
    return 'it did not move' if length < 0.01 else f'a path of {length:.2f} m {judgement}'


def turned_on_the_spot(observed: Observed) -> float:
    """Return by how many degrees a vehicle has turned that never drove, otherwise 0."""
    angle = whole_turn(observed.track)
    return math.degrees(angle) if fits.path_length(observed.drawn()) < 0.01 and angle > 0.01 else 0.0
