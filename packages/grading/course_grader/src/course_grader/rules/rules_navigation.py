"""The rules about maps, localisation and goals, against the truth; judging.py says what a rule is."""
import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from course_grader.rules.judging import MISSED, Pose, Result, Rule, counted, key
from course_grader.rules.observation import Destination, Observed, Sample
from kinematic_core.worlds.collision import Obstacles
from kinematic_core.worlds.floor_plan import FloorPlan
from kinematic_core.worlds.frames import LIDAR_Z
from kinematic_core.worlds.robot_world import ROBOT_HEIGHT, ROBOT_RADIUS
from navigation_core.maps.grid_map import GridMap
from navigation_core.poses import wrap
from plain_support.arrays import Floats

if TYPE_CHECKING:
    from navigation_core.maps.scores import MapScores

EVERY = 12  # steps of the robot between two samples that are compared: 10 Hz
STANDS = 0.01  # [m, rad] by which a robot that stands moves from one to the next
TOUCHING = 1e-6  # [m]
PLANNED = 0.05  # [m] cells in which the shortest path is searched
SHORT = 0.5  # [m] a shorter path is compared as one of this length
SHOWN = 100  # characters of what move_base says


@dataclass(frozen=True)
class Maps(Rule):
    """The last map on /map, or a map file, shows the walls: it is moved to where it fits best, and compared."""

    of: str = key(('topic', 'file'), 'topic', 'file: the map file that is handed in, and no program runs')
    iou: float = key('share', 0.95, 'of the free area that map and truth have in common, intersection by union')
    found: float = key('share', 0.95, 'how much of the walls has to be found')
    right: float = key('share', 0.95, 'how many of the wall cells have to lie near a wall')

    def judge(self, observed: Observed) -> Result:
        asked = f'a map that agrees with the walls: IoU of the free area at least {self.iou:g}'
        if observed.map is None:
            return Result(0.0, asked, 'there is no map on /map')
        try:
            found = _scores(observed.map, observed.plan, observed.track[0])
        except ValueError as error:
            return Result(0.0, asked, str(error))
        share = min(1.0 if value >= limit else MISSED * value / limit for value, limit in (
            (found.iou, self.iou), (found.found, self.found), (found.right, self.right)))
        return Result(share, f'{asked}, {self.found:.0%} of the walls found, {self.right:.0%} of its wall cells right',
                      f'IoU {found.iou:.2f}, {found.found:.0%} found, {found.right:.0%} right')


@functools.lru_cache(maxsize=2)
def _scores(grid: GridMap, plan: FloorPlan, start: Sample) -> 'MapScores':
    from navigation_core.maps.scores import scores  # scipy takes 0.3 s to import, which other exercises do not need
    return scores(grid, plan.outlines(LIDAR_Z), (start.x, start.y))


@dataclass(frozen=True)
class Localises(Rule):
    """The transforms from map to base_footprint say where the robot is, some time after the start or a carry."""

    median: float = key('length', 0.1, 'half of the time, the error is at most this')
    worst: float = key('length', 0.2, '95 % of the time, the error is at most this')
    within: float = key('time', 15.0, 'the time after the start, and after stimulus carry, that does not count')

    def judge(self, observed: Observed) -> Result:
        asked = (f'from {self.within:g} s on, the pose in the frame map is right: half of the time within '
                 f'{self.median:g} m, 95 % of it within {self.worst:g} m')
        begins = [observed.start, *observed.carried]
        since = [(max(begin for begin in begins if begin <= t), t, error) for t, error in _errors(observed)]
        found = [(begin, error) for begin, t, error in since if t - begin >= self.within]
        errors = np.array([error for _, error in found])
        if {begin for begin, _ in found} != set(begins):  # also if it ended soon after it was carried away
            none = 'the program ended too early for that' if observed.believed else 'no transform from map to odom'
            return Result(0.0, asked, none)
        median, worst = float(np.median(errors)), float(np.percentile(errors, 95))
        share = min(1.0 if value <= limit else MISSED * limit / value
                    for value, limit in ((median, self.median), (worst, self.worst)))
        return Result(share, asked, f'half of the time within {median:.2f} m, 95 % of it within {worst:.2f} m')


def _errors(observed: Observed) -> Iterator[Tuple[float, float]]:
    """Yield (time [s], error of the believed position [m])."""
    times = np.array([sample.t for sample in observed.track])
    for one in observed.believed:
        if one.t >= observed.start:
            truth = observed.track[min(int(np.searchsorted(times, one.t - 1e-6)), len(times) - 1)]
            yield one.t, math.hypot(one.x - truth.x, one.y - truth.y)


@dataclass(frozen=True)
class Navigates(Rule):
    """The robot drives to poses, one after the other, stands at each, and touches nothing on the way."""

    goals: Sequence[Pose] = key('poses', ..., '`[[x, y, heading], ...]`, such as `[-2 m, 0.5 m, 90 deg]`')
    tolerance: float = key('length', 0.1, 'how far from the pose it may be')
    turn: float = key('angle', 0.1, 'how far off the heading may be')
    rest: float = key('time or 0', 0.5, 'how long it has to stand there')
    detour: Optional[float] = key('number', None, 'how many times longer than the shortest path a drive may be')

    def judge(self, observed: Observed) -> Result:
        asked = (f'stands at {len(self.goals)} poses, one after the other, for {self.rest:g} s each, within '
                 f'{self.tolerance:g} m and {math.degrees(self.turn):.0f} degrees, and touches nothing'
                 + (f'; no drive is longer than {self.detour:g} times the shortest one' if self.detour else ''))
        track = np.array([sample for sample in observed.track if sample.t >= observed.start][::EVERY])
        if not len(track):
            return Result(0.0, asked, 'it did not move')
        ends = self._ends(track)
        reached = [end for end in ends if end is not None]
        share = counted(len(reached), len(self.goals))
        seen = [f'{len(reached)} of {len(self.goals)} reached']
        if len(reached) < len(self.goals):
            seen.append(self._missed(observed, track, ends))
        touches = _touches(observed, track)
        if touches:
            share, seen = min(share, MISSED), [*seen, f'it touches something {touches} times']
        detour: float = max(_detours(observed.plan, track, reached), default=1.0)
        if reached:
            seen.append(f'the longest drive is {detour:.2f} times the shortest one')
        if self.detour and detour > self.detour:
            share = min(share, MISSED)
        return Result(share, asked, '; '.join(seen))

    def _ends(self, track: Floats) -> List[Optional[int]]:
        """Return for each goal at which row of the track (t, x, y, theta) it is done, None if it is not."""
        moved = np.hypot(*np.diff(track[:, 1:3], axis=0, append=track[-1:, 1:3]).T)
        stands = (moved < STANDS) & (np.abs(wrap(np.diff(track[:, 3], append=track[-1:, 3]))) < STANDS)
        ends: List[Optional[int]] = []
        begin = 0
        for x, y, theta in self.goals:
            there = np.hypot(track[:, 1] - x, track[:, 2] - y) <= self.tolerance
            there &= stands | (self.rest == 0.0)
            there &= np.abs(wrap(track[:, 3] - theta)) <= self.turn
            there[:begin] = False
            end = _lasting(track[:, 0], there, self.rest)
            ends.append(end)
            begin = begin if end is None else end
        return ends

    def _missed(self, observed: Observed, track: Floats, ends: List[Optional[int]]) -> str:
        """Return what happened to the first goal that was not reached."""
        number = ends.index(None)
        x, y, theta = self.goals[number]
        near = int(np.hypot(track[:, 1] - x, track[:, 2] - y).argmin())
        off = math.degrees(abs(float(wrap(track[near, 3] - theta))))
        text = (f'goal {number + 1} ({x:g}, {y:g}, {math.degrees(theta):.0f} degrees): the robot came as near as '
                f'{math.hypot(track[near, 1] - x, track[near, 2] - y):.2f} m and {off:.0f} degrees')
        return f'{text}; {_answers(observed.destinations)}'


def _lasting(times: Floats, there: Floats, rest: float) -> Optional[int]:
    """Return the first index at which ``there`` has held for ``rest`` [s]."""
    since = None
    for index in range(len(times)):
        if not there[index]:
            since = None
            continue
        since = times[index] if since is None else since
        if times[index] - since >= rest - 1e-6:
            return index
    return None


def _answers(destinations: List[Destination]) -> str:
    """Return what move_base did with the goals that it got."""
    if not destinations:
        return 'move_base got no goal'
    failed = next((one for one in destinations if one.state not in ('SUCCEEDED', 'ACTIVE')), destinations[-1])
    why = f': {failed.text[:SHOWN]}' if failed.text else ''
    return (f'move_base got {len(destinations)} goals, the one at ({failed.x:.2f}, {failed.y:.2f}) in the frame '
            f'{failed.frame!r} is {failed.state}{why}')


def _touches(observed: Observed, track: Floats) -> int:
    """Return how often the robot begins to touch an obstacle, where it is at that time."""
    touching: List[bool] = []
    plans = [(-math.inf, observed.plan), *observed.moved]
    for (begin, plan), end in zip(plans, [*(moved for moved, _ in plans[1:]), math.inf]):
        obstacles = Obstacles(plan, ROBOT_RADIUS, ROBOT_HEIGHT)
        inside = (track[:, 0] >= begin) & (track[:, 0] < end)
        touching += [obstacles.clearance(x, y) < TOUCHING for x, y in track[inside, 1:3].tolist()]
    return sum(now and not before for before, now in zip([False, *touching], touching))


def _detours(plan: FloorPlan, track: Floats, reached: List[int]) -> Iterator[float]:
    """Yield how many times longer than the shortest path each drive was."""
    begin = 0
    for end in reached:
        length = float(np.hypot(*np.diff(track[begin:end + 1, 1:3], axis=0).T).sum())
        shortest = _shortest(plan, tuple(track[begin, 1:3]), tuple(track[end, 1:3]))
        if shortest is not None:
            yield max(length, SHORT) / max(shortest, SHORT)
        begin = end


@functools.lru_cache(maxsize=100)
def _shortest(plan: FloorPlan, start: Tuple[float, float], end: Tuple[float, float]) -> Optional[float]:
    """Return the length [m] of the shortest path of the robot's middle; None if there is none."""
    from navigation_core.maps.scores import true_map  # these import scipy
    from navigation_core.planning import global_planner
    from navigation_core.planning.costmap import Costmap, Inflation
    costmap = Costmap.of_map(true_map(plan.outlines(LIDAR_Z), PLANNED), ROBOT_RADIUS, ROBOT_RADIUS,
                             Inflation(ROBOT_RADIUS, 1.0))
    path = global_planner.plan(costmap, start, end).path
    return None if path is None else global_planner.length(path)
