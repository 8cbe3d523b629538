"""What was observed of a student's program: plain data, times in simulated seconds.

Times count from the simulator's first step; the program had started at ``start``.

Positions are in the simulator's frame [m], headings in rad, counter-clockwise; velocities in the robot's frame.
"""
import math
from dataclasses import dataclass, field, replace
from typing import Any, Dict, Iterable, List, NamedTuple, Optional, Set, Tuple

from kinematic_core.worlds.floor_plan import EMPTY, FloorPlan
from navigation_core.maps.grid_map import GridMap

QUANTITIES = {'ahead': 'the distance ahead', 'marker ahead': 'the marker is ahead',
              'marker left': 'the marker is to the left'}  # of Sensed, by the name of each
ANGLES = 'roll', 'pitch', 'yaw'  # of Sensed, of the marker that the grader turns [rad]; NaN: it shows none
DRIVEN = 1e-3  # [m] by which rounding to float32 may lengthen a step


class Sample(NamedTuple):
    """The true pose of the turtle or robot."""

    t: float
    x: float
    y: float
    theta: float


def whole_turn(track: Iterable[Sample]) -> float:
    """Return by how much [rad] a vehicle turns on its way, to either side."""
    headings = [sample.theta for sample in track]
    return sum(abs(math.remainder(b - a, math.tau)) for a, b in zip(headings, headings[1:]))


class Command(NamedTuple):
    """A velocity command that the simulator accepted [m/s, m/s, rad/s], and the node that sent it."""

    t: float
    linear_x: float
    linear_y: float
    angular_z: float
    node: str = ''


class Event(NamedTuple):
    """Another action of a node on the simulator: kind, values, node.

    Kinds: teleport (absolute), teleport_relative, pen, clear, reset, spawn, kill, fake_pose (another node published
    poses), fake_result (what a node of the grader publishes), fake_clock; of several robots
    spawn_model, delete_model.
    """

    t: float
    kind: str
    values: Tuple[Any, ...] = ()
    node: str = ''


class OutputLine(NamedTuple):
    """A line that the node printed or logged, without what rospy puts before it."""

    t: float
    text: str
    level: str = ''  # DEBUG, INFO, WARN, ERROR or FATAL of a line that rospy logged


class Problem(NamedTuple):
    """Why a program gets no points: it could not run, has crashed, or did what no program may do."""

    text: str  # for the student


class Call(NamedTuple):
    """A service call of the grader to the program: its request, whether it was answered, and what went wrong."""

    t: float
    service: str
    request: Tuple[float, ...]
    answered: bool
    trouble: str = ''


class ShownMarkers(NamedTuple):
    """Markers that the grader published: {id: (x, y, z) [m]}, possibly none."""

    t: float
    markers: Dict[int, Tuple[float, float, float]]


class Transform(NamedTuple):
    """A transform that a node of the program broadcast: frames without a leading /, translation [m] and yaw [rad]."""

    t: float
    parent: str
    child: str
    x: float
    y: float
    theta: float
    stamped: bool = True  # with the current time, or static; of transforms with equal times tf uses only the first


class Sensed(NamedTuple):
    """A measurement of a sensor of the robot: one of QUANTITIES [m] or ANGLES [rad], and its value, NaN if unknown."""

    t: float
    what: str
    value: float


class Goal(NamedTuple):
    """A goal of the grader for the Fibonacci action of the program, and its result."""

    t: float
    action: str
    order: int
    cancelled: bool
    state: str  # at the end, as in actionlib_msgs/GoalStatus: SUCCEEDED, PREEMPTED, ACTIVE, ...
    feedback: int  # messages
    result: Tuple[int, ...]


class Destination(NamedTuple):
    """A goal that move_base got: its pose [m, m, rad] in ``frame``, and what became of it."""

    t: float
    frame: str
    x: float
    y: float
    theta: float
    state: str = 'ACTIVE'  # as in actionlib_msgs/GoalStatus
    text: str = ''  # why


class Driven(NamedTuple):
    """Of one of several robots: where it was, and the commands that it got."""

    track: List[Sample]
    commands: List[Command]


def computed(order: int) -> int:
    """Return how many numbers a server computes for a goal of this order, each with a message of feedback."""
    return order - 1


@dataclass
class Observed:
    """All observations that rules may use."""

    track: List[Sample] = field(default_factory=list)  # one per tick
    commands: List[Command] = field(default_factory=list)
    events: List[Event] = field(default_factory=list)
    lines: List[OutputLine] = field(default_factory=list)
    calls: List[Call] = field(default_factory=list)
    shown: List[ShownMarkers] = field(default_factory=list)
    connections: Set[Tuple[str, str]] = field(default_factory=set)  # (name, 'publishes' | 'subscribes' | 'serves')
    types: Dict[str, str] = field(default_factory=dict)  # {topic: type}, as far as a node has told
    parameters: Dict[str, Any] = field(default_factory=dict)  # {name: last value} of those in checks
    transforms: List[Transform] = field(default_factory=list)
    turtles: Dict[str, List[Sample]] = field(default_factory=dict)  # {name: poses} of those in checks
    robots: Dict[str, Driven] = field(default_factory=dict)  # by name; of the first, the lists above, too
    sensed: List[Sensed] = field(default_factory=list)
    goals: List[Goal] = field(default_factory=list)
    plan: FloorPlan = EMPTY  # what truly stands around the robot
    map: Optional[GridMap] = None  # the last one
    believed: List[Sample] = field(default_factory=list)  # where tf puts the robot in the frame map
    carried: List[float] = field(default_factory=list)  # when the grader carried the robot away
    moved: List[Tuple[float, FloorPlan]] = field(default_factory=list)  # when the grader moved a panel, the new plan
    destinations: List[Destination] = field(default_factory=list)
    others: Set[Tuple[str, str]] = field(default_factory=set)  # the same of the simulator and the grader
    solution: List[Tuple[float, float]] = field(default_factory=list)  # the path of the exercise's solution [m]
    source: str = ''  # of the Python programs
    start: float = 0.0
    seconds: float = 0.0  # how long it was observed, since start
    timed_out: bool = False  # whether the time of the exercise was over
    exit_code: Optional[int] = None  # None: it ran until the grader ended it
    ended_at: Optional[float] = None  # since start
    problem: Optional[Problem] = None
    kept_up: bool = True  # whether simulator and program were fast enough

    def add_robots(self, names: Iterable[str]) -> None:
        """Add robots that have done nothing yet, the first of which is the one of ``track`` and ``commands``."""
        for name in names:
            self.robots[name] = Driven([], []) if self.robots else Driven(self.track, self.commands)

    def of_robot(self, name: str) -> 'Observed':
        """Return what was observed with track and commands of one of several robots; '': the first one."""
        return replace(self, **self.robots[name]._asdict()) if name else self

    def all_stand(self) -> float:
        """Return for how long [s] nothing has moved or turned at the end."""
        return min([self.standstill(), *(self.of_robot(name).standstill() for name in self.robots)])

    def of_kind(self, *kinds: str) -> List[Event]:
        """Return the events of these kinds."""
        return [event for event in self.events if event.kind in kinds]

    def reset_at(self) -> float:
        """Return when the simulator was last reset [s]: what was drawn before is gone. -inf: never."""
        return max((event.t for event in self.of_kind('reset')), default=-math.inf)

    def pens(self) -> List[Optional[Tuple[int, ...]]]:
        """Return for each sample of the track the values of the last pen event before it, or None."""
        reset = self.reset_at()
        changes = [change for change in self.of_kind('pen') if change.t >= reset]
        pens: List[Optional[Tuple[int, ...]]] = []
        last = None
        for sample in self.track:
            while changes and changes[0].t <= sample.t:
                last = changes.pop(0).values
            pens.append(last)
        return pens

    def drawn(self, pen_down: bool = False) -> List[Tuple[float, float]]:
        """Return the positions (x, y) [m] of the path since the last reset, without repeats.

        With ``pen_down`` only those that were drawn.
        """
        path: List[Tuple[float, float]] = []
        before, reset = None, self.reset_at()
        for sample, pen in zip(self.track, self.pens()):
            if sample.t < reset:
                continue
            if not (pen_down and pen and pen[-1]):  # r, g, b, width, off
                for point in (before or sample, sample):
                    if not path or math.hypot(point.x - path[-1][0], point.y - path[-1][1]) > DRIVEN:
                        path.append((point.x, point.y))
            before = sample
        return path

    def standstill(self) -> float:
        """Return for how long [s] the turtle has not moved or turned at the end."""
        if not self.track:
            return 0.0
        last = self.track[-1]
        start = last.t
        for sample in reversed(self.track):
            if math.hypot(sample.x - last.x, sample.y - last.y) > DRIVEN or abs(sample.theta - last.theta) > DRIVEN:
                break
            start = sample.t
        return last.t - start
