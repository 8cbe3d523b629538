"""The states of move_base: plan a path, follow it, recover if one of them fails, give up.

No clock and no ROS: ``step`` gets the time and runs one period; it asks a World to plan and to follow.
"""
import dataclasses
import enum
import math
from typing import NamedTuple, Optional, Protocol, Tuple

from navigation_core.planning.global_planner import Plan
from navigation_core.planning.local_planner import Choice, Velocity
from navigation_core.poses import Array, Pose

PROGRESS = 0.05  # [m, rad] the robot has to move within controller_patience, or the controller has failed
PUSHED = 0.5  # [m] beside its path from which on the robot plans again


class World(Protocol):
    """The robot and its map, as a Navigator needs them."""

    def plan(self, goal: Pose) -> Plan:
        """Return the Plan from the robot to ``goal``."""

    def is_hopeless(self, goal: Pose) -> bool:
        """Return whether no recovery can help to reach ``goal``: it is outside of the map, or in one of its walls."""

    def follow(self, path: Array, heading: float, new: bool) -> Tuple[Choice, bool]:
        """Return the Choice for the next period on a path, and whether its end was reached; ``new``: a new goal."""

    def turn(self, angle: float) -> Choice:
        """Return the Choice for turning on the spot by ``angle`` [rad]."""

    def clear(self, distance: float) -> None:
        """Forget obstacles that were seen farther away than ``distance`` [m]."""


@dataclasses.dataclass
class Patience:
    """When to plan again and when to recover; fields are named as the parameters of move_base."""

    planner_frequency: float = 0.0  # [Hz] 0: only if following fails
    planner_patience: float = 5.0  # [s]
    controller_patience: float = 15.0  # [s]
    max_planning_retries: int = -1  # negative: no limit
    oscillation_timeout: float = 0.0  # [s] 0: no limit
    oscillation_distance: float = 0.5  # [m]
    recovery_behavior_enabled: bool = True
    clearing_rotation_allowed: bool = True
    conservative_reset_dist: float = 3.0  # [m]
    aggressive_reset_dist: float = 0.5  # [m] beyond which obstacles are forgotten the second time


class State(enum.Enum):
    """Of a goal; those of the first line are on the way."""

    PLANNING, FOLLOWING, RECOVERING = 'planning', 'following', 'recovering'
    REACHED, FAILED = 'reached', 'failed'


class Step(NamedTuple):
    """The velocity for the next period; ``note``: what happened, for the log; ``choice``: of the local planner."""

    velocity: Velocity
    note: str = ''
    choice: Optional[Choice] = None


class Navigator:
    """Drives a robot to one goal after the other. ``state`` and ``path`` may be read; ``problem``: why it failed."""

    def __init__(self, world: World, patience: Patience) -> None:
        """Wait for a goal; ``patience`` may be changed later."""
        self._world, self.patience = world, patience
        self.state = State.REACHED
        self.path: Optional[Array] = None
        self.problem = ''

    def start(self, goal: Pose, pose: Pose, now: float) -> None:
        """Accept a goal, in the frame of paths, at the time ``now`` [s]."""
        self.goal, self.path, self.problem = goal, None, ''
        self.state, self._new, self._retries = State.PLANNING, True, 0
        self._planned = self._followed = self._moved = self._progress = now
        self._moved_at = self._progress_at = pose
        self._recovery = ''
        self._tried = 0
        self._left = 0.0  # [rad] of a rotation of recovery
        self._heading: Optional[float] = None  # during the rotation, in the last step
        self._cause = ''

    def step(self, pose: Pose, now: float) -> Step:
        """Return what to do in this period; zero velocity unless it follows a path or turns to recover."""
        if math.dist(pose[:2], self._moved_at[:2]) >= self.patience.oscillation_distance:
            self._moved, self._moved_at = now, pose
            if self._cause == 'oscillation':
                self._tried = 0
        if self.state == State.PLANNING:
            return self._plan(now)
        if self.state == State.FOLLOWING:
            return self._follow(pose, now)
        if self.state == State.RECOVERING:
            return self._recover(pose, now)
        return Step(Velocity())

    def _plan(self, now: float) -> Step:
        plan = self._world.plan(self.goal)
        if plan.path is not None:
            self.path, self.state = plan.path, State.FOLLOWING
            self._planned = self._followed = now
            self._retries = 0
            if self._cause == 'planning':
                self._tried = 0
            return Step(Velocity(), 'a new path')
        self.problem = plan.problem
        self._retries += 1
        if self._world.is_hopeless(self.goal):
            self.state = State.FAILED
            return Step(Velocity(), plan.problem)
        limit = self.patience.max_planning_retries
        if now > self._planned + self.patience.planner_patience or 0 <= limit < self._retries:
            return self._fail('planning')
        return Step(Velocity(), plan.problem)

    def _follow(self, pose: Pose, now: float) -> Step:
        patience = self.patience
        assert self.path is not None
        due = patience.planner_frequency > 0.0 and now >= self._planned + 1.0 / patience.planner_frequency
        if due or self._beside(pose) > PUSHED:
            plan = self._world.plan(self.goal)
            self._planned = now
            if plan.path is not None:
                self.path = plan.path
            elif not due:
                self.state = State.PLANNING
                return Step(Velocity(), plan.problem)
        if 0.0 < patience.oscillation_timeout < now - self._moved:
            self.problem = f'the robot has not moved {patience.oscillation_distance:g} m from where it was'
            return self._fail('oscillation')
        choice, reached = self._world.follow(self.path, self.goal.yaw, self._new)
        self._new = False
        if reached:
            self.state = State.REACHED
            return Step(Velocity())
        if self._progressed(pose, now) and choice.velocity is not None:
            self._followed = now
            return Step(choice.velocity, '', choice)
        self.problem = choice.problem or f'the robot has not moved for {patience.controller_patience:g} s'
        if now > self._followed + patience.controller_patience or choice.velocity is not None:
            return self._fail('following')
        self.state = State.PLANNING  # another path may be free
        self._planned = now
        return Step(Velocity(), self.problem)

    def _beside(self, pose: Pose) -> float:
        assert self.path is not None
        return float(min(math.hypot(x - pose.x, y - pose.y) for x, y in self.path))

    def _progressed(self, pose: Pose, now: float) -> bool:
        before = self._progress_at
        turned = abs(math.remainder(pose.yaw - before.yaw, math.tau))
        if math.dist(pose[:2], before[:2]) > PROGRESS or turned > PROGRESS:
            self._progress, self._progress_at = now, pose
            if self._cause == 'following':
                self._tried = 0
        return now <= self._progress + self.patience.controller_patience

    def _fail(self, cause: str) -> Step:
        """Start the next recovery, or give up."""
        patience = self.patience
        turns = ['turn'] if patience.clearing_rotation_allowed else []
        every = ['clear', *turns, 'clear more', *turns] if patience.recovery_behavior_enabled else []
        if self._tried == len(every):
            self.state = State.FAILED
            return Step(Velocity(), self.problem)
        self._cause = cause
        self.state, self._recovery = State.RECOVERING, every[self._tried]
        self._tried += 1
        self._left, self._heading = math.tau, None
        return Step(Velocity(), f'{self.problem}: recovery {self._tried} of {len(every)}, {self._recovery}')

    def _recover(self, pose: Pose, now: float) -> Step:
        patience, kind = self.patience, self._recovery
        if kind == 'turn' and self._left > 0.0:
            if self._heading is not None:
                self._left -= max(math.remainder(pose.yaw - self._heading, math.tau), 0.0)
            self._heading = pose.yaw
            choice = self._world.turn(self._left) if self._left > PROGRESS else Choice(None)
            if choice.velocity is not None:
                return Step(choice.velocity, '', choice)
        elif kind != 'turn':
            self._world.clear(patience.conservative_reset_dist if kind == 'clear' else patience.aggressive_reset_dist)
        self.state = State.PLANNING
        self._planned = self._followed = self._moved = self._progress = now
        self._progress_at, self._retries = pose, 0
        return Step(Velocity())
