"""Advice for a program that lost points: which mistake it may have, and what to do. Without ROS.

Every exercise has the symptoms of this module, of failures.py, and of the *_mistakes.py. An exercise file lists its own
in ``symptoms``, each {hint: TEXT, PREDICATE: VALUE, ...}, where all PREDICATES must hold. Certain causes come first: a
program that has crashed gets the reason, and a certain mistake stands alone, because the rest is its effect. Of what is
not certain, a hint says what was seen: several mistakes look the same, and what was seen cannot mislead. Numbers alone
come last.
"""
import re
import statistics
from typing import Any, Callable, Container, Dict, Iterator, List, NamedTuple, Optional, Tuple

from course_grader.rules import failures, output_mistakes, path_mistakes, scoring, source_mistakes, suspicions
from course_grader.rules.exercise import Exercise
from course_grader.rules.judging import ANY, SHORTCUTS, within
from course_grader.rules.observation import Command, Observed
from course_grader.rules.rules_output import Answers, Connects, Runs
from course_grader.rules.scoring import Reason, Verdict
from kinematic_core.worlds import robot_world
from plain_support.doctor import names
from plain_support.doctor.findings import misnamed

OF_A_CHECK = {'lost', 'kept', 'seen'}  # predicates on results of checks alone
MAX_HINTS = 2  # the first are the most likely causes
SEARCHED_LINES = 200  # of the output at either end that are searched
OPPOSITE = {  # the role that program and simulator share for a name: advice
    'publishes': 'the simulator publishes {0}: to receive it, use rospy.Subscriber instead of rospy.Publisher',
    'subscribes': 'the simulator waits for messages on {0}: to send them, use rospy.Publisher instead of '
                  'rospy.Subscriber',
    'serves': 'the simulator offers {0} already: to call it, use rospy.ServiceProxy instead of rospy.Service'}
SHORTCUT_HINTS = {  # kind of a shortcut: advice
    'teleport': 'here the turtle has to drive: publish on its cmd_vel instead of calling a teleport service',
    'teleport_relative': 'here the turtle has to drive: publish on its cmd_vel instead of calling a teleport service',
    'fake_pose': 'the simulator publishes {0}: to receive it, use rospy.Subscriber instead of rospy.Publisher',
    'fake_result': 'leave {0} to the node of the grader that publishes it: use rospy.Subscriber to receive it',
    **dict.fromkeys(('spawn_model', 'delete_model'), 'leave the world as it is: do not call the services of /gazebo'),
    'kill': 'leave turtle1 alive: do not call /kill', 'reset': 'do not call /reset in this task'}
POSITIONS = 'draws', 'stops', 'follows', 'positions'  # checks of where a vehicle is
MOTION = (*POSITIONS, 'commands', 'keeps', 'moves', 'passes', 'repeats', 'same_path')  # and of how it moves
SOUGHT = (*MOTION, 'navigates', 'localises', 'steers')  # checks that suspicions of the source explain
PRINTED = 'prints_poses', 'prints_markers', 'prints_no_marker', 'transform'  # checks of what callbacks do
CRASHED = re.compile(r'exit code [1-9]|SyntaxError|IndentationError|TabError')
EXCEPTION = re.compile(r'\b(\w*(?:Error|Exception))\b')


class Seen(NamedTuple):
    """The input of predicates: the Observed, the checks that lost points, and the texts of output and failure."""

    observed: Observed
    lost: Dict[str, List[Reason]]  # an exercise may have several checks of one name
    said: str


class Listed(NamedTuple):
    """A hint of the exercise file; ``special``: its predicates are about what the program is or did, see OF_A_CHECK."""

    hint: str
    special: bool


Predicate = Callable[[Seen, Any], bool]


def _median(value: Callable[[Command], float]) -> Predicate:
    """Return a predicate on a number of the commands; it does not hold without commands."""
    return lambda seen, wanted: bool(seen.observed.commands) and within(
        statistics.median(map(value, seen.observed.commands)), wanted)


def _names(role: str) -> Predicate:
    return lambda seen, wanted: any(re.search(wanted, name) for name, done in seen.observed.connections if done == role)


PREDICATES: Dict[str, Predicate] = {
    'lost': lambda seen, wanted: wanted in seen.lost,
    'kept': lambda seen, wanted: wanted not in seen.lost,
    'seen': lambda seen, wanted: any(
        re.search(wanted, reason.seen) for reasons in seen.lost.values() for reason in reasons),
    'prints': lambda seen, wanted: bool(re.search(wanted, seen.said)),
    'source': lambda seen, wanted: bool(re.search(wanted, seen.observed.source)),
    'publishes': _names('publishes'), 'subscribes': _names('subscribes'), 'serves': _names('serves'),
    'pen': lambda seen, wanted: any(event.values[:3] == tuple(wanted) for event in seen.observed.of_kind('pen')),
    'linear': _median(lambda command: command.linear_x), 'sideways': _median(lambda command: command.linear_y),
    'angular': _median(lambda command: command.angular_z),
    'end x': lambda seen, wanted: bool(seen.observed.track) and within(seen.observed.track[-1].x, wanted),
    'end y': lambda seen, wanted: bool(seen.observed.track) and within(seen.observed.track[-1].y, wanted),
}


def advise(exercise: Exercise, observed: Observed, decided: Verdict) -> Verdict:
    """Return a Verdict with its hints: none if nothing is missing, or undecided."""
    if decided.outcome == scoring.UNDECIDED or decided.score >= 100.0:
        return decided
    try:
        found, certain = _found(exercise, observed, decided)
    except RecursionError:  # the syntax tree is too deep; the verdict stands
        found, certain = [], False
    return decided._replace(hints=tuple(dict.fromkeys(found))[:MAX_HINTS], certain=certain)


def _found(exercise: Exercise, observed: Observed, decided: Verdict) -> Tuple[List[str], bool]:
    """Return the hints, and whether they are certain."""
    lost: Dict[str, List[Reason]] = {}
    for reason in decided.public().reasons:
        if reason.points < reason.of:
            lost.setdefault(reason.check, []).append(reason)
    texts = [line.text for line in observed.lines]
    said = '\n'.join([*decided.objections, *(call.trouble for call in observed.calls), *texts[:SEARCHED_LINES],
                      *texts[-SEARCHED_LINES:]])
    seen = Seen(observed, lost, said)
    program = source_mistakes.program(observed.source)
    common = list(_common(said, observed))
    late = [hint for hint in common if hint == failures.NO_VALUE_YET]  # what leaves it without a value comes first
    found = [*(() if late else common), *_unknown_names(exercise, observed, program), *_shortcuts(exercise, observed),
             *_no_spin(exercise, observed, program), *(source_mistakes.found(program) if program else ()),
             *_opposite(observed), *late]
    certain = bool(found)
    if observed.problem and CRASHED.search(observed.problem.text):
        found = found or [*_unknown_failure(observed.problem.text)]
    elif not found:  # otherwise the observations are only its effect
        if exercise.robots:  # what one of them does says nothing about the others
            return [*_early_end(seen), *_silent(exercise, observed, lost),
                    *_ordered(exercise, {}, _listed(exercise, seen))], False
        by_check = {**path_mistakes.found(exercise, observed, lost), **output_mistakes.found(exercise, observed, lost)}
        suspected = list(_suspected(exercise, program, seen))
        found = [*suspected, *_early_end(seen), *_silent(exercise, observed, lost),
                 *(() if suspected else _stands(program, observed, lost)),
                 *_waits(exercise, observed, lost), *_ordered(exercise, by_check, _listed(exercise, seen))]
        if program and any(check in lost for check in POSITIONS):  # what was observed explains more
            found += suspicions.unwrapped(program, observed)
        found = found or [*path_mistakes.measured(exercise, observed, lost)]
    return found, certain


def _ordered(exercise: Exercise, by_check: Dict[str, List[str]], listed: Dict[str, List[Listed]]) -> Iterator[str]:
    """Return the hints of both, in the order of the checks: what a program commands explains the path that it drives.

    A special symptom of the exercise knows more of its task than a general hint for the same check; the others say
    something only where no general hint does. Those that belong to no check come last.
    """
    for check in (*dict.fromkeys(scored.name for scored in exercise.rules), ''):
        own, general = listed.get(check, []), by_check.get(check, [])
        explained = check and set(general) - set(path_mistakes.SIGNS.values())
        yield from (hint for hint, special in own if special)
        yield from general
        yield from (hint for hint, special in own if not special and not explained)


def _listed(exercise: Exercise, seen: Seen) -> Dict[str, List[Listed]]:
    """Return {check: hints} of the exercise file, the first one of each check."""
    found: Dict[str, List[Listed]] = {}
    for symptom in exercise.symptoms:
        values = {name: value for name, value in symptom.items() if name != 'hint' and value not in (None, ANY)}
        check = values.get('lost', '')
        if not (check and check in found) and all(PREDICATES[name](seen, value) for name, value in values.items()):
            found.setdefault(check, []).append(Listed(symptom['hint'], bool(set(values) - OF_A_CHECK)))
    return found


def _common(said: str, observed: Observed) -> Iterator[str]:
    hint = failures.advice(said, observed.source)
    if hint:
        yield hint


def _unknown_failure(text: str) -> Iterator[str]:
    match = EXCEPTION.search(text)
    if match:
        yield f'the program ended with a {match[1]}: the last lines of its output say why, and in which line'


def _shortcuts(exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Shortcuts that the program took."""
    for event in observed.events:
        if event.kind in SHORTCUT_HINTS and SHORTCUTS[event.kind][0] not in exercise.allows:
            yield SHORTCUT_HINTS[event.kind].format(*event.values)


def _no_spin(exercise: Exercise, observed: Observed, program: Optional[source_mistakes.Program]) -> Iterator[str]:
    """A program that ends too early; one that sleeps may end on purpose."""
    until = {scored.rule.until for scored in exercise.rules if isinstance(scored.rule, Runs)}
    if (program and observed.exit_code == 0 and source_mistakes.never_spins(program)
            and (until == {'the end'} or not until and 'sleep' not in program.read)):
        yield ('the program ended by itself: rospy.spin() in its last line keeps it running, so that its callbacks are '
               'called')


def _suspected(exercise: Exercise, program: Optional[source_mistakes.Program], seen: Seen) -> Iterator[str]:
    """Possible mistakes in the source, if a vehicle does not move, or callbacks do not print, as required.

    What the solution of the exercise does, too, is no mistake.
    """
    lost, observed = seen.lost, seen.observed
    if program is None:
        return
    if any(check in lost for check in ('navigates', 'localises')):
        yield from suspicions.another_frame(program)
    if any(check in lost for check in SOUGHT):
        positions = any(check in lost for check in (*POSITIONS, 'navigates'))
        solution = source_mistakes.program(exercise.solution)
        usual = {re.sub(r'\d', '', hint) for hint in (suspicions.found(solution, positions) if solution else ())}
        yield from (hint for hint in suspicions.found(program, positions, observed)
                    if re.sub(r'\d', '', hint) not in usual)
    elif any(check in lost for check in PRINTED):
        for suspect in (suspicions.sleeps_in_a_callback, suspicions.in_degrees, suspicions.same_part_twice):
            yield from suspect(program, observed)
    if 'prints' in lost:
        yield from suspicions.only_debugs(program)


def _stands(program: Optional[source_mistakes.Program], observed: Observed, lost: Container[str]) -> Iterator[str]:
    """Commands that are all zero."""
    if any(check in lost for check in MOTION) and observed.commands and all(
            abs(value) < path_mistakes.STANDING for command in observed.commands
            for value in (command.linear_x, command.linear_y, command.angular_z)):
        yield suspicions.publishes_nothing(program) or (
            'all velocities that it sends are 0: only linear.x, linear.y and angular.z move it; print what they are '
            'computed from: // and int() make a whole number, and a condition may never be true')


def _silent(exercise: Exercise, observed: Observed, lost: Container[str]) -> Iterator[str]:
    """A program that could send velocities, and goes on, but sends none."""
    sent = observed.commands or any(driven.commands for driven in observed.robots.values())
    own = {'/turtle1/cmd_vel', '/cmd_vel', *(f'/{name}/cmd_vel' for name in observed.robots)}  # which it sees
    if any(check in lost for check in MOTION) and not sent and observed.exit_code is None and any(
            name in own and role == 'publishes' for name, role in observed.connections):
        yield ('no velocity of it came: the program never gets to its publish, because it waits, or a condition before '
               'it never holds; print what that is computed from' + (
                   f'. Or what it sends is nan, or faster than {robot_world.FASTEST_COMMAND:g} m/s'
                   if exercise.simulator == 'robotont' else ''))


def _waits(exercise: Exercise, observed: Observed, lost: Container[str]) -> Iterator[str]:
    """Velocities that are sent once although the vehicle needs them repeatedly."""
    if any(check in lost for check in MOTION):
        yield from path_mistakes.stops_in_between(exercise, observed)


def _opposite(observed: Observed) -> Iterator[str]:
    """Names for which program and simulator have the same role, such as two publishers of a topic."""
    for name, role in sorted(observed.connections):
        others = {other for known, other in observed.others if known == name}
        alone = {own for known, own in observed.connections if known == name} == {role}
        if others == {role} and alone and not names.OF_EVERY_NODE.fullmatch(name):
            yield OPPOSITE[role].format(name)
        elif others == {'serves'} and role != 'serves':
            yield f'{name} is a service, and no topic: call it by rospy.ServiceProxy({name!r}, TYPE)'


def _early_end(seen: Seen) -> Iterator[str]:
    """A program that sends its commands and ends before they arrive."""
    observed = seen.observed
    if (not observed.commands and observed.exit_code == 0 and 'publish(' in observed.source
            and any((name, 'subscribes') in observed.others for name, role in observed.connections
                    if role == 'publishes')):
        yield ('no command arrived before it ended: a publisher needs a moment to connect, so publish again and again '
               'in a loop, with rate.sleep(); or the program never gets to its publish')


def _unknown_names(exercise: Exercise, observed: Observed, program: Optional[source_mistakes.Program]
                   ) -> Iterator[str]:
    """Names that only the program uses and that resemble one of the simulator, the grader or the task."""
    rules = [scored.rule for scored in exercise.rules]
    asked = {rule.topic for rule in rules if isinstance(rule, Connects)} | {
        rule.service for rule in rules if isinstance(rule, Answers)}
    known = asked | {name for name, _ in observed.others if not names.OF_EVERY_NODE.fullmatch(name)}
    likely = {name for name in known if name.lstrip('/') in exercise.asks}
    used = dict(sorted(observed.connections))
    written = source_mistakes.names(program) if program else ()  # a launch file may put them into a namespace
    used.update((name, 'uses') for name in written if not any(other.endswith(name) for other in used))
    groups = {_space(name) for name in known | set(dict(observed.connections))}  # of an action, for example
    nodes = [name for name in dict(observed.connections) if name.endswith('/get_loggers')]
    for name, role in used.items():
        if name in known or name.lstrip('/') in groups or names.OF_EVERY_NODE.fullmatch(name):
            continue
        if nodes and not _space(name) and all(node.count('/') > 2 for node in nodes):
            yield f'{name} begins with a slash, so that the namespace of its node changes nothing: write {name[1:]!r}'
        else:
            free = {other for other in known if (other, role) not in observed.connections}  # the others are right
            meant = names.meant(name, likely & free) or names.meant(name, free)
            space = _space(name)
            if meant and not (space != _space(meant) and space[-1:].isdigit() and space in exercise.asks):
                yield misnamed('the program', role, name, meant).text


def _space(name: str) -> str:
    """Return the namespace of a name, such as turtle2 of /turtle2/pose, or ''."""
    return name.lstrip('/').rpartition('/')[0]
