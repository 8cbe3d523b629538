"""What an exercise asks for must be accepted by the simulators, stimuli and nodes that play it. Without ROS.

Where a value is drawn from a span, its ends count. The same holds for what only a program could do: no turtle gets out
of its window.
"""
import itertools
import math
import re
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Mapping, Optional, Sequence, Tuple

from course_grader.rules.judging import ANY, Rule, Span, written
from course_grader.rules.rules_driving import Commands, Draws, Passes, Stops
from course_grader.rules.rules_state import Follows, HasTransform, Spawns
from kinematic_core.worlds import robot_world, turtle_world, world_format
from kinematic_core.worlds.floor_plan import LARGEST
from kinematic_core.worlds.planar import Pose2D
from plain_support import ABSURD, InvalidInput, shown

if TYPE_CHECKING:
    from course_grader.rules.exercise import Exercise

ARENA: Span = (0.0, round(turtle_world.ARENA_SIZE, 4))  # [m]
FLOOR: Span = (-LARGEST, LARGEST)  # [m]
NOISE: Span = (0.0, 1.0)  # [m] of the odometry of robotont_gazebo
SLIP: Span = (0.0, 0.9)
NUMBERS = {  # (stimulus, parameter): limits, unit
    ('call', 'times'): ((1, 50), ''), ('markers', 'most'): ((1, 20), ''),
    ('markers', 'rate'): ((0.0, 8.0), 'Hz'),  # that of the messages
    ('turns', 'for'): ((2.0, math.inf), 's')}  # a pose of the marker lasts 2 s
SPANS = {('drive', 'linear'): ((-ABSURD, ABSURD), 'm/s'), ('drive', 'angular'): ((-ABSURD, ABSURD), 'rad/s'),
         ('carry', 'x'): (FLOOR, 'm'), ('carry', 'y'): (FLOOR, 'm')}
START_POINTS = 9  # in each direction, of a start that is drawn, that are compared with the obstacles
STEPS = {'turtlesim': 1.0 / turtle_world.DT, 'robotont': 1.0 / robot_world.DT}  # [Hz]: at most one command in each
TAKEN = '/clock', '/rosout', '/tf', '/odom', '/scan', '/cmd_vel', '/turtle1/cmd_vel', '/turtle1/pose'  # topics
FIRST = 'turtle1'
TURTLE = re.compile(r'[A-Za-z]\w*', re.ASCII)  # a name that turtlesim accepts
GROUND = 'ground_plane'  # a model in each world of gazebo_ros


def problems(made: 'Exercise') -> Iterator[str]:
    """Yield texts about what nothing can play, or no program can do."""
    yield from _start(made)
    yield from _outside('odometry: noise', made.odometry.get('noise', 0.0), NOISE, 'm')
    yield from _outside('odometry: slip', made.odometry.get('slip', 0.0), SLIP)
    for number, (what, values) in enumerate(made.stimuli, 1):
        yield from (f'stimulus {number} ({what}): {text}' for text in _stimulus(what, values, made))
    for number, scored in enumerate(made.rules, 1):
        yield from (f'check {number} ({scored.name}): {text}' for text in _check(scored.rule, made))


def _outside(what: str, value: float, limits: Span, unit: str = '') -> Iterator[str]:
    if not limits[0] <= value <= limits[1]:
        yield f'{what} is {f"{value:g} {unit}".strip()}; it must be {written(limits, unit).strip()}'


def _spans(values: Mapping[str, Any], names: Sequence[str], limits: Span, unit: str, prefix: str = '') -> Iterator[str]:
    """Yield a text for each span that goes beyond the limits; None: it is not given."""
    for name in names:
        span = values.get(name) or (0.0, 0.0)
        if not limits[0] <= span[0] <= span[1] <= limits[1]:
            yield f'{prefix}{name} is {written(span, unit)}; it must be in {written(limits, unit)}'


def _start(made: 'Exercise') -> Iterator[str]:
    """Yield texts about where a robot cannot start; that of a turtle is checked when it is read."""
    if made.simulator != 'robotont':
        return
    starts: Dict[str, Mapping[str, Span]] = dict(made.robots) or {'': made.start}
    things = {thing.get('name') for kind in world_format.KINDS for thing in made.world.get(kind, ())} | {GROUND}
    far = [*_spans(made.shift, 'xy', FLOOR, 'm', 'shift: ')]
    for name, start in starts.items():
        far += _spans(start, 'xy', FLOOR, 'm', f'robots: {name}: ' if name else 'start: ')
    yield from far
    yield from (f'robots has the name {shown(name)}, which something in the world has already; choose another'
                for name in made.robots if name in things)
    if not far and made.world and not made.robots:  # gazebo_ros puts robots beside an obstacle
        yield from _obstructed(made)


def _obstructed(made: 'Exercise') -> Iterator[str]:
    """Yield a text if the robot may start in an obstacle; a shift moves the world, and not the robot."""
    world = robot_world.RobotWorld(world_format.parse(made.world), Pose2D(3.0 * LARGEST, 0.0, 0.0))
    for x, y in itertools.product(*(_start_points(made, axis) for axis in 'xy')):
        try:
            world.place(x, y, 0.0)
        except InvalidInput as error:
            shifted = ', counted from the world without its shift' if made.shift else ''
            yield f'start: {error}{shifted}'
            return


def _start_points(made: 'Exercise', axis: str) -> Sequence[float]:
    """Return coordinates [m] of starts in the world without its shift."""
    (low, high), shift = made.start.get(axis, (0.0, 0.0)), made.shift.get(axis, (0.0, 0.0))
    size = high - low + shift[1] - shift[0]
    return [low - shift[1] + size * step / (START_POINTS - 1) for step in range(START_POINTS if size else 1)]


def _stimulus(what: str, values: Mapping[str, Any], made: 'Exercise') -> Iterator[str]:
    for (kind, name), (limits, unit) in NUMBERS.items():
        if kind == what:
            yield from _outside(name, values[name], limits, unit)
    for (kind, name), (limits, unit) in SPANS.items():
        if kind == what:
            yield from _spans(values, (name,), limits, unit)
    for number, span in enumerate(values.get('request', ()), 1):
        if math.inf in map(abs, span):
            yield f'request: number {number} has no end, and a value is drawn from it; write it like "2 to 9 m"'
    yield from _goals(values)
    if what == 'move' and any(panel['name'] == values['panel'] and panel.get('path')
                              for panel in made.world.get('panels', ())):
        yield f'the panel {values["panel"]} moves by itself, along its path'
    if values.get('topic') in TAKEN:
        yield f'topic is {values["topic"]}, which the simulator uses itself; choose another'


def _goals(values: Mapping[str, Any]) -> Iterator[str]:
    """Yield texts about the poses to which a panel is moved, or a robot is sent."""
    for number, goal in enumerate([values['to']] if 'to' in values else values.get('goals', ()), 1):
        yield from _spans({axis: (value, value) for axis, value in zip('xy', goal)}, 'xy', FLOOR, 'm',
                          'to: ' if 'to' in values else f'goal {number}: ')
    if 'goals' in values and not values['goals']:
        yield 'goals is empty; it must have one goal or more'


def _check(rule: Rule, made: 'Exercise') -> Iterator[str]:
    if isinstance(rule, (Commands, HasTransform)) and rule.rate[0] > STEPS[made.simulator]:
        yield (f'rate is {written(rule.rate, "Hz")}; the simulator counts one in each of its steps, at most '
               f'{STEPS[made.simulator]:g} Hz')
    if isinstance(rule, Commands) and made.simulator == 'robotont':
        yield from _unreachable('linear', rule.linear, robot_world.FASTEST_COMMAND, 'm/s')
        yield from _unreachable('sideways', rule.sideways, robot_world.FASTEST_COMMAND, 'm/s')
        yield from _unreachable('angular', rule.angular, robot_world.FASTEST_TURN, 'rad/s')
    if made.simulator == 'turtlesim':
        yield from _out_of_the_window(rule)
    if isinstance(rule, (Spawns, Follows)):
        if not TURTLE.fullmatch(rule.turtle):
            yield (f'turtle is {shown(rule.turtle)}; a name starts with a letter and has letters, digits and _, '
                   'such as turtle2')
        elif rule.turtle == FIRST:
            yield f'turtle is {FIRST}, which is there from the beginning; it must be another one, such as turtle2'


def _unreachable(name: str, span: Span, most: float, unit: str) -> Iterator[str]:
    if span != ANY and (span[0] > most or span[1] < -most):
        yield f'{name} is {written(span, unit)}; the simulator takes {-most:g} to {most:g} {unit}'


def _out_of_the_window(rule: Rule) -> Iterator[str]:
    """Yield a text for each point to which no turtle can get, up to the tolerance of the check."""
    points: List[Tuple[Optional[float], Optional[float]]] = []
    if isinstance(rule, (Draws, Passes)):
        points += rule.through
    if isinstance(rule, (Stops, Passes, Spawns)):
        points.append((rule.x, rule.y))
    slack = rule.tolerance if isinstance(rule, (Draws, Stops, Passes, Spawns)) else 0.0
    limits = ARENA[0] - slack, ARENA[1] + slack
    for point in points:
        for axis, value in zip('xy', point):
            if value is not None and not limits[0] <= value <= limits[1]:
                yield f'{axis} is {value:g} m; the window of turtlesim has {written(ARENA, "m")}'
    if isinstance(rule, Draws) and rule.size[0] > ARENA[1]:
        yield f'size is {written(rule.size, "m")}; the window of turtlesim has {written(ARENA, "m")}'
