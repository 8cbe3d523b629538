"""Mistakes in the path, the commands and the positions of a vehicle: advice for each. Without ROS."""
import bisect
import functools
import itertools
import math
import re
import statistics
from typing import Any, Callable, Container, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple

import numpy as np

from course_grader.rules import fits, rules_driving
from course_grader.rules.exercise import Exercise
from course_grader.rules.judging import ANY, Rule, period, within, written
from course_grader.rules.observation import Command, Observed, Sample, whole_turn
from course_grader.rules.rules_driving import Commands, Draws, Passes, Positions, Stops
from course_grader.rules.rules_state import Follows, Keeps
from kinematic_core.worlds import robot_world, turtle_world

WALL = 0.01  # [m] from the edge of the arena
SHORT = 0.3  # [m] a part of a path that is too short for a side
STRAIGHT = 0.08  # [m] within which a part of a path is straight
TURNED_WELL = math.radians(3.0)  # a corner within this is right
TURNED_AT_ALL = math.radians(15.0)
EQUAL = 1.08  # times the shortest side, up to which sides are equal
TURNING = 0.05  # [rad/s] and
MOVING = 0.02  # [m/s]: from these values on, a command turns or drives
STANDING = 1e-3  # [m/s] or [rad/s]: below it does nothing
HARDLY = 0.05  # [m/s] or [rad/s]: a follower reacts to an error of 0.3 m or rad by more
TOO_FAST = 5.0  # [m/s] or [rad/s]: no gain that suits an error of 1 m or rad is so large
OF_VELOCITY = {'linear.x': 'linear|speed|forward', 'angular.z': 'angular|turn'}  # in the names of parameters
NUMBER = r'-?\d+(?:\.\d*)?'
WATCHDOG = {'turtlesim': turtle_world.WATCHDOG, 'robotont': robot_world.WATCHDOG}  # [s] without a command
WATCHDOGS = 1.5  # watchdog times until the next command, so that the vehicle has stopped in between
MIN_COMMANDS = 5  # commands that show that the vehicle goes the wrong way
MAX_TOWARDS = 2  # commands towards a goal that is far off, up to which the sign is wrong, and not the goal
MIN_LAW, CORRELATED = 10, 0.95  # commands, and the correlation, that show how a velocity follows a measurement
LIMITED = 0.98  # of the highest velocity; from there on, it may be limited
APPROACH = 4.0  # [s] at the end, in which a follower drives straight to a turtle that stands
GATE = 0.5  # [m]: the largest tolerance of a point that lies ahead; places in a maze, with more, are around corners
UNDISTURBED = 0.5  # [m] from a point: farther off, what stands beside it has not touched the vehicle
FEW = 0.1  # of the commands that may differ, such as a last zero
MIN_ERROR = 0.02  # [m] from the goal; below it, the sign of a velocity means nothing
SIGNS = {  # quantity: advice if the velocity leads away from its goal; an exercise may know the reason
    'marker left': 'it turns or drives away from the marker: angular.z and linear.y are positive to the left, as y of '
                   'the marker is; check the sign, and that they are computed from y',
    **dict.fromkeys(('ahead', 'marker ahead'),
                    'it drives the wrong way: linear.x has to be positive, forward, while the distance is larger than '
                    'its goal; check the sign, > and <, the unit (metres), and the field of the message')}
ONE_WAY = ('it only turns or drives to one side, wherever the marker is: let the velocity be proportional to y of the '
           'marker, which is negative when the marker is to the right')
AXES = {'marker left': ('y', 'to the left'), 'marker ahead': ('x', 'ahead')}  # of a marker's position
SWINGS = 4  # changes of direction; one or two are an overshoot


def found(exercise: Exercise, observed: Observed, lost: Container[str]) -> Dict[str, List[str]]:
    """Return {check: advice} for checks of an exercise that lost points: those of KINDS."""
    hints: Dict[str, List[str]] = {}
    for scored in exercise.rules:
        if scored.name in lost and scored.name in KINDS:
            hints.setdefault(scored.name, []).extend(KINDS[scored.name](scored.rule, exercise, observed))
    if hints.get('commands'):  # other velocities than those of the task explain the path, too
        hints.pop('draws', None)
    return hints


def stops_in_between(exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Advice if the vehicle stops by itself after half of the velocities, because no command follows in time."""
    times = [*(command.t for command in observed.commands), observed.start + observed.seconds]
    pauses = [after - command.t for command, after in zip(observed.commands, times[1:])
              if max(map(abs, command[1:4])) > STANDING]
    watchdog = WATCHDOG[exercise.simulator]
    if any(isinstance(scored.rule, Commands) and scored.rule.rate != ANY and scored.rule.rate[1] * watchdog < 1.0
           for scored in exercise.rules):
        return  # that is what the task asks for
    if pauses and 2 * sum(pause > WATCHDOGS * watchdog for pause in pauses) >= len(pauses):
        yield (f'it sends a velocity and waits, but after {watchdog:g} s without a command the vehicle stops: publish '
               'again and again in a loop, with rate.sleep(), ten times per second')


def _first(*causes: Iterable[str]) -> List[str]:
    """Return the advice of the first cause that gives any."""
    for cause in causes:
        found = list(cause)
        if found:
            return found
    return []


def _commanded(wanted: Commands, _exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Velocities that are swapped, in degrees, or of the wrong sign."""
    called = [call.t for call in observed.calls if call.service == wanted.after]
    if not observed.commands or called and observed.commands[0].t < min(called):
        return
    linear = statistics.median(command.linear_x for command in observed.commands)
    angular = statistics.median(command.angular_z for command in observed.commands)
    defaults = [*_default('linear.x', linear, wanted.linear, observed.source),
                *_default('angular.z', angular, wanted.angular, observed.source)]
    if defaults:
        yield from defaults
    elif ANY not in (wanted.linear, wanted.angular) and not within(linear, wanted.linear) and within(
            linear, wanted.angular) and within(angular, wanted.linear):
        yield 'the two velocities are swapped: linear.x is the speed forward, and angular.z the turn speed'
    elif wanted.angular != ANY and not within(angular, wanted.angular) and not within(0.0, wanted.angular) and within(
            math.radians(angular), wanted.angular):
        yield 'angular.z is in rad/s, and not in degrees: write the number of the task as it is'
    elif within(linear, wanted.linear) and within(angular, wanted.angular):
        yield from _first(_paced(wanted, observed), _rated(wanted.rate, observed))
    else:
        forward = _other_velocity('linear.x', linear, wanted.linear, 'the speed, positive forward, negative backward')
        turning = _other_velocity('angular.z', angular, wanted.angular, 'the turn speed, positive to the left')
        yield from _first(itertools.chain(forward, turning), _outside(wanted, observed))


def _paced(wanted: Commands, observed: Observed) -> Iterator[str]:
    """A speed, forward or backward, that is not that of the task."""
    paces = [abs(command.linear_x) for command in observed.commands if abs(command.linear_x) > STANDING]
    if paces and not within(statistics.median(paces), wanted.pace):
        yield (f'linear.x is {statistics.median(paces):.3g} m/s forward or backward, and not '
               f'{written(wanted.pace, "m/s")}')


def _default(name: str, value: float, limits: Tuple[float, float], source: str) -> Iterator[str]:
    """A velocity that is the default of a parameter, which is not set where the program looks for it."""
    for parameter, default in re.findall(
            rf"get_param\(\s*['\"](~?\w*?(?:{OF_VELOCITY[name]})\w*)['\"]\s*,\s*({NUMBER})\s*\)", source):
        if limits != ANY and not within(value, limits) and abs(value - float(default)) < STANDING:
            yield (f'{name} is {default}, the default of {parameter}: ' + (
                'the parameter is not set for this node; '
                f'<param name="{parameter[1:]}" value="..."/> stands inside of its <node>' if parameter[0] == '~' else
                f'a parameter inside of a <node> is private: rospy.get_param(\'~{parameter}\')'))


def _other_velocity(name: str, value: float, limits: Tuple[float, float], meaning: str) -> Iterator[str]:
    """A velocity that is 0 or has the wrong sign."""
    other = {'linear.x': 'y and z of linear', 'angular.z': 'x and y of angular'}[name]
    if within(value, limits):
        return
    if abs(value) < STANDING:
        yield f'{name} is 0: it is {meaning}; {other} do not do that'
    elif within(-value, limits):
        yield f'{name} is {value:.2g}, which has the wrong sign: it is {meaning}'


def _rated(wanted: Tuple[float, float], observed: Observed) -> Iterator[str]:
    """Commands that are sent too often or too rarely."""
    if wanted == ANY or len(observed.commands) < 2:
        return
    rate = 1.0 / max(period([command.t for command in observed.commands]), 1e-6)
    low, high = wanted
    good = 2.0 * low if math.isinf(high) else (max(low, 0.0) + high) / 2.0
    if not within(rate, wanted):
        yield (f'it publishes {rate:.1f} times per second: rospy.Rate({good:g}) and rate.sleep() in the loop make it '
               f'{good:g} times, if nothing else waits there, as does a rospy.Timer of {1.0 / good:.2g} s')


def _teleported(wanted: Positions, _exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Positions to which the turtle drives, or never goes."""
    kinds = rules_driving.TELEPORTS.get(wanted.by)
    if kinds and not observed.of_kind(*rules_driving.TELEPORTS['teleports']):
        if observed.commands:
            yield f'the turtle drives: call /turtle1/{wanted.by} for each position instead of publishing velocities'
        else:
            yield f'no call of /turtle1/{wanted.by} arrived: call it once for each position'


def _drawn(wanted: Draws, exercise: Exercise, observed: Observed) -> Iterator[str]:
    path, sides = observed.drawn(pen_down=True), fits.SIDES[wanted.shape]
    found = _first(_lifted(wanted, exercise, observed), _only_turns(observed))
    if found:
        yield from found
    elif observed.commands and all(abs(command.angular_z) < TURNING / 10.0 for command in observed.commands) and any(
            abs(command.linear_x) >= MOVING for command in observed.commands):
        yield ('it never turns: angular.z, the turn speed, is 0 in all its commands; x and y of angular do nothing '
               'here. Does the program get to the part that turns?')
    elif sides and exercise.simulator == 'turtlesim' and _at_wall(observed):
        free = list(itertools.takewhile(lambda place: not _touches_wall(*place), path))
        yield from _first(_wrong_turn(wanted.shape, sides, _parts(sides, free)), _drives_into_wall(observed))
    else:
        yield from _first(_polygon(wanted.shape, sides, path, observed), _sized(wanted, observed))


def _drives_into_wall(observed: Observed) -> Iterator[str]:
    if _stays_at_wall(observed) and ('/turtle1/pose', 'subscribes') in observed.connections:
        yield ('the turtle drives into a wall of its window, and stays there: are all corners in the window, from 0 to '
               '11 m? The way to a corner is the corner minus the position; check the sign')
    else:
        yield (f'the turtle drives into a wall of its window, at {_place_at_wall(observed)}: the way there is too '
               'long, or it turns too little or to the wrong side before')


def _only_turns(observed: Observed) -> Iterator[str]:
    degrees = rules_driving.turned_on_the_spot(observed)
    if degrees:
        yield (f'it only turns, by {degrees:.0f} degrees in all, and never drives: linear.x is the speed forward; if a '
               'turn has to end before, check the sign of angular.z, the comparison, and that it looks often enough')


def _lifted(_wanted: Rule, _exercise: Exercise, observed: Observed) -> Iterator[str]:
    """A pen that is off, so that nothing is drawn."""
    pens = observed.pens()
    if pens and pens[-1] and pens[-1][-1] and (
            fits.path_length(observed.drawn(pen_down=True)) < SHORT < fits.path_length(observed.drawn())):
        yield 'the pen is off while the turtle moves: the last argument of set_pen, off, has to be 0'


def _sized(wanted: Draws, observed: Observed) -> Iterator[str]:
    """A shape that is too large, too small, or not finished."""
    shape, least = wanted.fit(observed), max(wanted.size[0], SHORT)
    length = fits.path_length(observed.drawn())
    if shape.covered >= rules_driving.CLOSED and not within(shape.size, wanted.size):
        is_round = wanted.shape in ('circle', 'eight')
        how = ('a diameter of {0:.1f} m, and not of {1}: it is 2 * linear.x / angular.z' if is_round else
               'sides of {0:.1f} m, and not of {1}: they are as long as linear.x times its time')
        yield f'the {wanted.shape} has ' + how.format(shape.size, written(wanted.size, 'm'))
    elif (observed.timed_out and observed.exit_code is None and observed.standstill() < rules_driving.MOVING
          and not _at_wall(observed)
          and 0.0 < length < 2.0 * (fits.SIDES[wanted.shape] or 3) * least):
        yield (f'it is too slow, or turns or waits too long: in {observed.seconds:.0f} s it has driven {length:.1f} m, '
               f'and the {wanted.shape} is not complete')


def _kept(wanted: Keeps, exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Another axis of the marker, a velocity of the wrong sign, or a gain that does not fit."""
    used = set(re.findall(r'\bposition\.([xyz])\b', observed.source))
    axis, where = AXES.get(wanted.what, ('', ''))
    if used and axis and axis not in used:
        yield f'it uses position.{min(used)}, but how far the marker is {where}, is position.{axis}'
        return
    if wanted.what == 'marker left' and observed.commands and all(
            max(map(abs, command[2:4])) < STANDING for command in observed.commands):
        yield 'it never turns or drives sideways: angular.z turns it, and linear.y drives it to the left'
        return
    yield from _first(_law(wanted, observed), _leaves(wanted, observed), _regulated(wanted, exercise, observed))


def _leaves(wanted: Keeps, observed: Observed) -> Iterator[str]:
    """Velocities to one side alone, or away from the goal."""
    if wanted.what == 'marker left' and _goes_one_way(wanted, observed):
        yield ONE_WAY
    elif _goes_away(wanted, observed):
        yield SIGNS[wanted.what]


def _regulated(wanted: Keeps, exercise: Exercise, observed: Observed) -> Iterator[str]:
    """A gain that is too small or too large, and a goal that is not reached."""
    errors = [one.value - wanted.value for one in observed.sensed if one.what == wanted.what]
    speeds = [command.angular_z if wanted.what == 'marker left' else command.linear_x for command in observed.commands]
    if not errors or not speeds:
        return
    late = errors[len(errors) // 2:]
    nearer = sum(error < -wanted.tolerance or wanted.what == 'ahead' and math.isnan(error) for error in late)
    only_forward = wanted.what != 'marker left' and min(speeds) > -STANDING and 2 * nearer > len(late)
    late, errors = ([error for error in some if not math.isnan(error)] for some in (late, errors))
    two_speeds = any(isinstance(scored.rule, Commands) and scored.rule.pace != ANY for scored in exercise.rules)
    if not two_speeds and STANDING < max(map(abs, speeds)) < HARDLY:
        yield (f'it hardly reacts: its velocity is at most {max(map(abs, speeds)):.2g}; choose a larger gain, by which '
               'the error is multiplied')
    elif not two_speeds and max(map(abs, speeds)) > TOO_FAST:
        yield (f'its velocity is up to {max(map(abs, speeds)):.2g}: choose a smaller gain, by which the error is '
               'multiplied; distances are in metres')
    elif only_forward:
        yield ('it never drives backward, although it is too near: linear.x has to be negative then; check the goal '
               f'of the program, too, which is {wanted.value:g} m')
    elif not late:
        return
    elif two_speeds:
        yield from _threshold(wanted, observed)
    elif _changes(speeds) >= SWINGS and min(errors) < -wanted.tolerance and max(errors) > wanted.tolerance:
        yield 'it swings around its goal: choose a smaller gain, by which the error is multiplied'
    else:
        last = max(len(speeds) // 4, 1)
        yield from _first(_stays_off(wanted, late[len(late) // 2:], speeds[-last:]), _dead_zone(wanted, observed))


def _threshold(wanted: Keeps, observed: Observed) -> Iterator[str]:
    """Two velocities, forward and backward, that change at another value."""
    values = {sign: [wanted.value + error for error, speed in _reactions(wanted, observed) if sign * speed > 0.0]
              for sign in (1, -1)}
    if min(map(len, values.values())) < MIN_COMMANDS:
        return
    change = (min(values[1]) + max(values[-1])) / 2.0
    if abs(change - wanted.value) > wanted.tolerance:
        yield f'it changes between forward and backward at {change:.2f} m, and not at {wanted.value:g} m'


def _dead_zone(wanted: Keeps, observed: Observed) -> Iterator[str]:
    """Errors that are too large, and that it does not react to, as it does to larger ones."""
    every = list(_reactions(wanted, observed, least=-1.0))
    ignored = [abs(error) for error, speed in every if abs(speed) < STANDING and abs(error) > wanted.tolerance]
    answered = [abs(error) for error, speed in every if abs(speed) >= STANDING]
    if len(ignored) >= MIN_COMMANDS and len(answered) >= MIN_COMMANDS and max(ignored) <= np.percentile(answered, 20):
        yield (f'its velocity is 0 up to an error of {max(ignored):.2f} m, but only {wanted.tolerance:g} m are '
               'allowed: let it react to smaller errors')


def _changes(speeds: Sequence[float]) -> int:
    """Return how often the direction changes, apart from slow motion, which the noise of a sensor turns around."""
    fast = [speed for speed in speeds if abs(speed) >= HARDLY]
    return sum(a * b < 0.0 for a, b in zip(fast, fast[1:]))


def _stays_off(wanted: Keeps, errors: Sequence[float], speeds: Sequence[float]) -> Iterator[str]:
    """A goal that is not reached until the end, because the vehicle stands, or is too slow."""
    nearest = min(errors, key=abs)
    if abs(nearest) <= wanted.tolerance or min(errors) * max(errors) < 0.0:
        return
    if max(map(abs, speeds)) < STANDING:
        yield (f'it stands {abs(nearest):.2f} m off its goal, {wanted.value:g} m: check the goal of the program, and '
               'where else it sends zero')
    elif all(speed * nearest > 0.0 for speed in speeds) and abs(errors[-1]) < abs(errors[0]):
        yield (f'it is too slow, {abs(nearest):.2f} m off its goal at the end, with {max(map(abs, speeds)):.2g}: '
               'choose a larger gain, by which the error is multiplied, or a higher limit')
    elif any(speed * nearest < 0.0 for speed in speeds) and max(errors) - min(errors) < wanted.tolerance:
        yield (f'it keeps {wanted.value + statistics.median(errors):.2f} m, and not {wanted.value:g} m: check the goal '
               'of the program')


def _passed(wanted: Passes, exercise: Exercise, observed: Observed) -> Iterator[str]:
    """A vehicle that hardly steers, or is too slow to get there."""
    goal = wanted.points()[0]
    most = max((max(abs(command.linear_y), abs(command.angular_z)) for command in observed.commands), default=0.0)
    speed = statistics.median([math.hypot(*command[1:3]) for command in observed.commands] or [0.0])
    if STANDING < most < 2.0 * HARDLY and speed > most:
        yield (f'it hardly steers: linear.y and angular.z are at most {most:.2g}; choose a larger gain, by which the '
               'difference is multiplied')
    elif wanted.tolerance <= GATE and len(observed.commands) >= MIN_LAW and speed > MOVING and len(
            steered := {command[2:4] for command in observed.commands} - {(0.0, 0.0)}) == 1:
        sideways, turn = steered.pop()
        yield (f'linear.y is {sideways:.2g} and angular.z {turn:.2g} in all its commands: compute them from each '
               'message of the sensor, in its callback')
    elif not wanted.through and wanted.tolerance <= GATE and _steers_away(goal, observed):
        yield (f'it steers away from x = {goal[0]:g}, y = {goal[1]:g}: positive linear.y and angular.z lead to the '
               'left; check the sign, and the order of the subtraction')
    elif (not wanted.through and observed.track and speed > MOVING and speed * exercise.time < math.dist(
            observed.track[0][1:3], goal) - wanted.tolerance):
        yield f'it is too slow: with {speed:.2g} m/s it does not get there in {exercise.time:.0f} s; drive faster'


def _steers_away(goal: Tuple[float, float], observed: Observed) -> bool:
    """Return whether commands on the way to a point ahead steer to the other side."""
    times, away = [sample.t for sample in observed.track], []
    for command in observed.commands:
        at = observed.track[min(bisect.bisect_left(times, command.t), len(times) - 1)] if times else None
        steer = command.linear_y + command.angular_z
        if at and command.linear_x > MOVING and abs(steer) > MOVING:
            bearing = math.remainder(math.atan2(goal[1] - at.y, goal[0] - at.x) - at.theta, math.tau)
            if TURNED_WELL < abs(bearing) < math.pi / 3.0 and math.dist(at[1:3], goal) > UNDISTURBED:
                away.append(math.copysign(steer, -bearing * steer))
    return len(away) >= MIN_COMMANDS and sum(away) > 0.6 * sum(map(abs, away))


def _law(wanted: Keeps, observed: Observed) -> Iterator[str]:
    """Velocities that follow the measurement as they should, but by a wrong sign, or around another value."""
    name, what = ('angular.z or linear.y', 'y') if wanted.what == 'marker left' else ('linear.x', 'the distance')
    every = [(error + wanted.value, speed) for error, speed in _reactions(wanted, observed)]
    most = max((abs(speed) for _, speed in every), default=0.0)
    free = [(value, speed) for value, speed in every if abs(speed) < LIMITED * most]
    if len(free) < MIN_LAW or np.ptp([value for value, _ in free]) < wanted.tolerance:
        return
    values, speeds = np.array(free).T
    gain, offset = np.polyfit(values, speeds, 1)
    if abs(np.corrcoef(values, speeds)[0, 1]) < CORRELATED:
        return
    goal = -offset / gain
    if gain < 0.0:
        yield (f'{name} has the wrong sign: it is about {gain:.2g} * ({what} - {goal:.2f}), so that it drives away; '
               'subtract in the other order, or multiply by a positive factor')
    elif abs(goal - wanted.value) > wanted.tolerance:
        yield (f'{name} is about {gain:.2g} * ({what} - {goal:.2f}), which is 0 at {goal:.2f} m, and not at '
               f'{wanted.value:g} m: subtract {wanted.value:g}' if wanted.value else
               f'{name} is about {gain:.2g} * ({what} - {goal:.2f}), which is not 0 straight ahead')


def _goes_away(wanted: Keeps, observed: Observed) -> bool:
    """Return whether most velocities increase the error of a quantity."""
    reactions = list(_reactions(wanted, observed))
    towards = sum(error * speed > 0.0 and abs(error) > wanted.tolerance for error, speed in reactions)
    away = sum(error * speed < 0.0 for error, speed in reactions)
    return len(reactions) >= MIN_COMMANDS and away > 0.8 * len(reactions) and towards <= MAX_TOWARDS


def _goes_one_way(wanted: Keeps, observed: Observed) -> bool:
    """Return whether velocities have one sign although the errors have both."""
    reactions = list(_reactions(wanted, observed))
    left = sum(error > 0.0 for error, _ in reactions)
    return min(left, len(reactions) - left) >= MIN_COMMANDS and len({speed > 0.0 for _, speed in reactions}) == 1


def _reactions(wanted: Keeps, observed: Observed, least: float = STANDING) -> Iterator[Tuple[float, float]]:
    """Yield the error of a quantity and the velocity of each command, if both are large enough to have a sign.

    ``least``: the velocity from which on it counts.
    """
    sensed = [one for one in observed.sensed if one.what == wanted.what]
    times = [one.t for one in sensed]
    for command in observed.commands:
        place = bisect.bisect_right(times, command.t)
        error = sensed[place - 1].value - wanted.value if place else math.nan
        speed = command.angular_z + command.linear_y if wanted.what == 'marker left' else command.linear_x
        if abs(error) > MIN_ERROR and abs(speed) > least:
            yield error, speed


def _stopped(wanted: Stops, _exercise: Exercise, observed: Observed) -> Iterator[str]:
    """A position that is checked too rarely, or commands that go on behind a zero, or when the program has ended."""
    times = [command.t for command in observed.commands]
    if len(times) < 2:
        return
    late = [max(map(abs, command[1:4])) > STANDING for command in observed.commands[-4 * MIN_LAW:]]
    if min(sum(late), len(late) - sum(late)) >= MIN_COMMANDS and sum(a != b for a, b in zip(late, late[1:])) >= SWINGS:
        yield (f'of its last {len(late)} commands {len(late) - sum(late)} are 0, and the others drive on: let one '
               'place of the program decide, as a loop that stops when a callback has set a flag')
        return
    if max(map(abs, observed.commands[-1][1:4])) > STANDING:
        at = next((sample.x for sample in observed.track if sample.t >= times[-1]), math.inf)
        if observed.exit_code == 0 and wanted.x is not None and abs(at - wanted.x) < 2.0 * wanted.tolerance:
            yield ('its last command is not zero, so that the vehicle drives on when the program has ended: publish '
                   'Twist() before that, and wait a moment, as by rospy.sleep(0.5), so that it arrives')
        return
    pause, speed = period(times), max(math.hypot(*command[1:3]) for command in observed.commands)
    if pause * speed > 2.0 * wanted.tolerance:
        yield (f'it looks and sends a command every {pause:.1f} s, and drives {pause * speed:.1f} m in between, too '
               'far to stop in time: do both more often, such as 20 times per second, or drive slower')


def _followed(wanted: Follows, _exercise: Exercise, observed: Observed) -> Iterator[str]:
    """The wrong turtle drives, or the right one stands, drives backward, or never turns."""
    driven = sorted(name for name, role in observed.connections if role == 'publishes' and name.endswith('/cmd_vel'))
    if driven and f'/{wanted.turtle}/cmd_vel' not in driven:
        yield (f'it publishes {driven[0]}, but it is {wanted.turtle} that has to drive: publish on '
               f'/{wanted.turtle}/cmd_vel')
        return
    reads = {name for name, role in observed.connections if role == 'subscribes'}
    if '/turtle1/pose' in reads and not reads & {f'/{wanted.turtle}/pose', '/tf', '/tf_static'}:
        yield (f'it receives no pose of {wanted.turtle}: subscribe to /{wanted.turtle}/pose, too, because the way '
               'to turtle1 depends on where both are')
        return
    track = observed.turtles.get(wanted.turtle, [])
    if _leads_away(track, observed.track):
        yield (f'{wanted.turtle} drives away from turtle1: the way there is the position of turtle1 minus that of '
               f'{wanted.turtle}; check the sign, and that its direction is atan2(y, x) minus its own heading')
        return
    steps = [(b.x - a.x) * math.cos(a.theta) + (b.y - a.y) * math.sin(a.theta) for a, b in zip(track, track[1:])]
    forward, backward = (sum(sign * step for step in steps if sign * step > 0.0) for sign in (1.0, -1.0))
    if track and forward + backward < SHORT:
        yield (f'{wanted.turtle} hardly moves: linear.x of /{wanted.turtle}/cmd_vel is its speed forward; print what '
               'it is computed from, and whether the subscribers get poses or transforms')
    elif backward > forward:
        yield f'{wanted.turtle} drives backward: linear.x has to be positive, such as the distance'
    elif track and whole_turn(track) < TURNED_WELL:
        yield f'{wanted.turtle} never turns: angular.z is its turn speed, by the direction to turtle1'
    elif len(track) > 1 and observed.track:
        apart = math.dist(track[-1][1:3], observed.track[-1][1:3])
        late, approach = ([sample for sample in track if sample.t >= track[-1].t - time] for time in (1.0, APPROACH))
        approached = math.dist(approach[0][1:3], observed.track[-1][1:3]) - apart
        moves = len(late) > 1 and math.dist(late[0][1:3], late[-1][1:3]) >= WALL
        if (moves and observed.standstill() >= APPROACH and apart > wanted.distance
                and approached > 0.95 * fits.path_length([sample[1:3] for sample in approach])):
            yield (f'{wanted.turtle} is on its way to turtle1, but {apart:.1f} m away at the end: a larger gain, by '
                   'which the distance is multiplied, drives faster')
        elif apart > wanted.distance and len(late) > 1 and not moves and not _touches_wall(*track[-1][1:3]):
            yield (f'{wanted.turtle} stops {apart:.1f} m away from turtle1: let it drive on until that is less than '
                   f'{wanted.distance:g} m')


def _leads_away(track: Sequence[Sample], leader: Sequence[Sample]) -> bool:
    """Return whether nearly all steps of a turtle lead forward, and away from another one."""
    times = [sample.t for sample in leader]
    forward, away = 0.0, 0.0
    for a, b in zip(track, track[1:]):
        at = leader[min(bisect.bisect_left(times, a.t), len(leader) - 1)] if leader else a
        dx, dy = b.x - a.x, b.y - a.y
        if dx * math.cos(a.theta) + dy * math.sin(a.theta) > 0.0:
            forward += math.hypot(dx, dy)
            away += math.hypot(dx, dy) * (dx * (at.x - a.x) + dy * (at.y - a.y) < 0.0)
    return forward > SHORT and away > 0.8 * forward


def _at_wall(observed: Observed) -> bool:
    """Return whether it was driven against a wall."""
    return bool(observed.commands) and any(
        _touches_wall(sample.x, sample.y) for sample in observed.track if sample.t >= observed.reset_at())


def _place_at_wall(observed: Observed) -> str:
    at = next(sample for sample in observed.track if sample.t >= observed.reset_at()
              and _touches_wall(sample.x, sample.y))
    return f'x = {at.x:.1f}, y = {at.y:.1f}'


def _stays_at_wall(observed: Observed) -> bool:
    """Return whether it is at a wall in the whole second half of its track."""
    return all(_touches_wall(sample.x, sample.y) for sample in observed.track[len(observed.track) // 2:])


def _touches_wall(x: float, y: float) -> bool:
    return min(x, y, turtle_world.ARENA_SIZE - x, turtle_world.ARENA_SIZE - y) <= WALL


def _polygon(shape: str, sides: int, path: Sequence[Tuple[float, float]], observed: Observed) -> Iterator[str]:
    if not sides:
        return
    if _turns_while_driving(observed.commands):
        yield ('it drives while it turns, so that the corners are round: publish linear.x = 0 together with angular.z')
        return
    corners, parts = fits.corners(path, STRAIGHT), _parts(sides, path)
    if len(corners) == sides + 1 and _is_regular(corners[1:]) and math.dist(corners[0], corners[-1]) > STRAIGHT:
        (x, y), (first_x, first_y) = corners[:2]
        yield (f'the last side is missing: it started at ({x:.1f}, {y:.1f}), which is no corner, so that its way to '
               f'the first corner is no side; let it go back to the first corner, ({first_x:.1f}, {first_y:.1f}), at '
               'the end')
    elif len(corners) > sides and _crosses(corners[-sides - 1:-1]):
        yield ('the corners are visited in the wrong order, so that the sides cross: go around, from neighbour to '
               'neighbour')
    elif len(parts) >= sides and _turned(parts) is not None:
        lengths = [math.hypot(*part) for part in parts[-sides:]]
        wrong = list(_wrong_turn(shape, sides, parts))
        yield from wrong
        if not wrong and _two_lengths(lengths):
            yield (f'its sides are {min(lengths):.1f} m and {max(lengths):.1f} m long: those of a {shape} have the '
                   'same length')


def _parts(sides: int, path: Sequence[Tuple[float, float]]) -> List[Tuple[float, float]]:
    """Return the straight parts of a path, as vectors, the last of them."""
    corners = fits.corners(path, STRAIGHT)
    return [(b[0] - a[0], b[1] - a[1]) for a, b in zip(corners, corners[1:]) if math.dist(a, b) >= SHORT][-2 * sides:]


def _turned(parts: Sequence[Tuple[float, float]]) -> Optional[float]:
    """Return the usual turn between two parts of a path, or None."""
    turns = [abs(math.remainder(math.atan2(b[1], b[0]) - math.atan2(a[1], a[0]), math.tau))
             for a, b in zip(parts, parts[1:])]
    return _usual([turn for turn in turns if turn > TURNED_AT_ALL], 2 * TURNED_WELL)


def _wrong_turn(shape: str, sides: int, parts: Sequence[Tuple[float, float]]) -> Iterator[str]:
    turned, right = _turned(parts), math.tau / sides
    if turned is not None and abs(turned - right) > TURNED_WELL:
        yield (f'at its corners it turns by {math.degrees(turned):.0f} degrees; a {shape} needs '
               f'{math.degrees(right):.0f} degrees, {right:.2f} rad')


def _two_lengths(lengths: Sequence[float]) -> bool:
    """Return whether the sides are equal in pairs, as those of a rectangle."""
    low, high = min(lengths), max(lengths)
    return high > EQUAL * low and all(min(length - low, high - length) < 0.1 * (high - low) for length in lengths)


def _usual(values: Sequence[float], apart: float) -> Optional[float]:
    """Return the median of values that are nearly equal, or None."""
    if len(values) < 2:
        return None
    median = statistics.median(values)
    near = sum(abs(value - median) <= apart for value in values)
    return median if near >= 0.7 * len(values) else None


def _turns_while_driving(commands: Sequence[Command]) -> bool:
    """Return whether it turns, and never on the spot."""
    turning = [command for command in commands if abs(command.angular_z) >= TURNING]
    driving = [command for command in commands if abs(command.linear_x) >= MOVING]
    return bool(turning) and len(driving) > len(turning) and all(
        abs(command.linear_x) >= MOVING for command in turning)


def _is_regular(corners: Sequence[Tuple[float, float]]) -> bool:
    """Return whether corners are those of a regular polygon, one after the other, as the first one is of the last."""
    turned = [*corners[1:], corners[0]]
    steps = [(b[0] - a[0], b[1] - a[1]) for a, b in zip(corners, turned)]
    lengths = [math.hypot(*step) for step in steps]
    headings = [math.atan2(y, x) for x, y in steps]
    turns = [math.remainder(b - a, math.tau) for a, b in zip(headings, [*headings[1:], headings[0]])]
    right = math.copysign(math.tau / len(corners), turns[0])
    return min(lengths) >= SHORT and max(lengths) <= EQUAL * min(lengths) and all(
        abs(turn - right) <= 2.0 * TURNED_WELL for turn in turns)


def _crosses(corners: Sequence[Tuple[float, float]]) -> bool:
    """Return whether four corners are those of a square, visited across it."""
    if len(corners) != 4:
        return False
    every = sorted(math.dist(a, b) for a, b in itertools.combinations(corners, 2))
    side, diagonal = every[0], every[-1]
    square = every[3] <= EQUAL * side and every[4] * EQUAL >= diagonal and abs(diagonal / side - math.sqrt(2)) < 0.15
    return square and max(math.dist(a, b) for a, b in zip(corners, corners[1:])) > 1.2 * side


def measured(exercise: Exercise, observed: Observed, lost: Container[str]) -> Iterator[str]:
    """What a vehicle did, in numbers, where no cause is sure: they are compared with the task."""
    yield from _only_turns(observed)
    for scored in exercise.rules:
        if scored.name in lost and scored.name in MEASURED and (observed.commands or scored.name == 'draws'):
            yield from MEASURED[scored.name](scored.rule, observed)


def _outside(wanted: Commands, observed: Observed, spans: int = 2) -> Iterator[str]:
    """Velocities that are not as asked, and in how many commands; of the first ``spans`` that may be asked."""
    _, linear, sideways, angular, _ = zip(*observed.commands)
    for name, span, unit, values in (
            ('linear.x', wanted.linear, 'm/s', linear), ('angular.z', wanted.angular, 'rad/s', angular),
            ('linear.y', wanted.sideways, 'm/s', sideways),
            ('linear.x', wanted.pace, 'm/s forward or backward', list(map(abs, linear))),
            ('angular.z', wanted.turning, 'rad/s to either side', list(map(abs, angular))))[:spans]:
        outside = [value for value in values if not within(value, span)]
        if len(outside) > FEW * len(values):
            yield (f'{name} is {_spread(outside)} in {len(outside)} of {len(values)} commands, and not '
                   f'{written(span, unit)}')


def _driven_shape(wanted: Draws, observed: Observed) -> Iterator[str]:
    """Sides and corners of a path, or how far it turns."""
    sides, corners = fits.SIDES[wanted.shape], fits.corners(observed.drawn(), STRAIGHT)
    parts = _parts(len(corners), observed.drawn())
    headings = [math.atan2(y, x) for x, y in parts]
    turns = [math.degrees(abs(math.remainder(b - a, math.tau))) for a, b in zip(headings, headings[1:])]
    if len(parts) < sides and observed.timed_out and not observed.all_stand():
        yield (f'the time was over when it was in part {len(parts)} of {sides}: drive and turn faster, or wait less '
               'between')
    elif sides and len(parts) == 1 and observed.commands:
        last = observed.commands[-1]
        yield (f'its path is one straight part of {math.hypot(*parts[0]):.2f} m, and then it '
               + ('only turns' if abs(last.linear_x) < MOVING <= abs(last.angular_z) else 'ends')
               + f'; a {wanted.shape} has {sides} equal sides')
    elif sides and turns:
        lengths = [math.hypot(*part) for part in parts]
        yield (f'its path has {len(parts)} straight parts, of {_spread(lengths)} m, and turns by {_spread(turns)} '
               f'degrees between them; a {wanted.shape} has {sides} equal sides, and turns by {360 / sides:g} degrees')
    elif wanted.shape == 'circle' and len({command[1:4] for command in observed.commands} - {(0.0, 0.0, 0.0)}) > 1:
        yield 'linear.x or angular.z changes on the way: a circle needs the same of both all the time'
    elif wanted.shape == 'circle' and observed.commands:
        yield f'it turns by {abs(_extent(observed.track)[1]):.0f} degrees in all; a whole circle needs 360'


def _sent(_wanted: Rule, observed: Observed) -> Iterator[str]:
    """Number, time and velocities of commands."""
    sent = [command for command in observed.commands if max(map(abs, command[1:4])) > STANDING]
    if sent:
        linear, angular = _spread([one.linear_x for one in sent]), _spread([one.angular_z for one in sent])
        linear += ' m/s, backward,' if max(one.linear_x for one in sent) < 0.0 else ' m/s'
        yield (f'it sent {len(sent)} velocities in {sent[-1].t - sent[0].t:.1f} s, with linear.x {linear} and '
               f'angular.z {angular} rad/s: compare these numbers with the task')


def _repeated(_wanted: Rule, observed: Observed) -> Iterator[str]:
    """Length and turn of the path that was shown, and of the one that was driven."""
    moment = observed.commands[0].t
    (length, turn, time), (own_length, own_turn, own_time) = (
        _extent([sample for sample in observed.track if (sample.t <= moment) == shown]) for shown in (True, False))
    paused = abs(own_time - time) < 0.1 * time or abs(own_length - length) < 0.02 * length
    advice = ''
    if abs(own_turn + turn) < 0.1 * abs(turn):
        advice = ': it turns to the other side, so check the sign of angular.z'
    elif not paused:
        advice = ': sleep between two poses for the difference of their times'
    yield (f'the path to repeat is {length:.2f} m long, turns by {turn:.0f} degrees and takes {time:.1f} s; its own is '
           f'{own_length:.2f} m long, turns by {own_turn:.0f} degrees and takes {own_time:.1f} s'
           + advice)


def _extent(track: Sequence[Sample]) -> Tuple[float, float, float]:
    """Return length [m], turn [degrees], and time in motion [s]."""
    steps = [(math.dist(a[1:3], b[1:3]), math.remainder(b.theta - a.theta, math.tau), b.t - a.t)
             for a, b in zip(track, track[1:])]
    return (sum(step[0] for step in steps), math.degrees(sum(step[1] for step in steps)),
            sum(step[2] for step in steps if max(step[0], abs(step[1])) > 1e-4))


def _spread(values: Sequence[float]) -> str:
    low, high = f'{min(values):.3g}', f'{max(values):.3g}'
    return low if low == high else f'{low} to {high}'


MEASURED: Dict[str, Callable[[Any, Observed], Iterator[str]]] = {
    'commands': functools.partial(_outside, spans=5), 'draws': _driven_shape, 'same_path': _sent, 'repeats': _repeated}
KINDS: Dict[str, Callable[[Any, Exercise, Observed], Iterator[str]]] = {
    'draws': _drawn, 'commands': _commanded, 'positions': _teleported, 'keeps': _kept, 'stops': _stopped,
    'follows': _followed, 'passes': _passed, 'pen': _lifted}
