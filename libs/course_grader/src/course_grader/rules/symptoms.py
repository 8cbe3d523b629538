"""From what was observed of a program that lost points to advice: which mistake it may be, and what to do. Without ROS.

Symptoms of every exercise are COMMON and what ``_unknown_names``, ``_no_spin`` and ``_local_variable`` find. An
exercise file lists its own in ``symptoms``, each {hint: TEXT, PREDICATE: VALUE, ...}, where all PREDICATES must hold.
"""
import ast
import difflib
import re
import statistics
from typing import Any, Callable, Dict, Iterator, List, NamedTuple, Optional, Set

from course_grader.rules import scoring
from course_grader.rules.exercise import Exercise
from course_grader.rules.judging import ANY, within
from course_grader.rules.observation import Command, Observed
from course_grader.rules.scoring import Reason, Verdict

MOST = 2  # hints: the first ones are the likeliest causes
LINES = 200  # of the output at either end that are searched
SIMILAR = 0.75  # of two names, as difflib.SequenceMatcher sees it: /turtle1/cmd_vel and /turtle1/cmdvel have 0.97
NAME = re.compile(r'/?[A-Za-z]\w*(/\w+)*')  # of a topic or service
OF_EVERY_NODE = re.compile(r'/rosout|/clock|/tf(_static)?|.*/(get_loggers|set_logger_level)')
WAITING = re.compile(r'\b(Subscriber|Service|Timer)\(')
KEPT_ALIVE = re.compile(r'\bspin\(|^\s*while\b', re.MULTILINE)
DOES = {'publishes': 'publishes {0}, which nobody reads', 'subscribes': 'subscribes to {0}, which nobody publishes',
        'serves': 'offers {0}, which nobody calls', 'uses': 'uses {0}, which does not exist'}
COMMON = (  # pattern in what it printed, or in why it failed: advice, with {0}, ... for the groups of the pattern
    (r"Missing parentheses in call to 'print'|multiple exception types must be parenthesized",
     'this is Python 2: `2to3 -w FILE` makes it Python 3'),
    (r'(?i)handler returned None|service cannot process request',
     'the function of a service must return a response: `return TeleportAbsoluteResponse()`'),
    (r"No module named 'ar_track_alvar\.?\w*'", 'the messages are in ar_track_alvar_msgs.msg'),
    (r"No module named '([\w.]+)'",
     'there is no module {0}: check its spelling; messages are in PACKAGE.msg, services in PACKAGE.srv'),
    (r"cannot import name '([a-z]\w*)' from",
     'names of messages and services start with a capital letter, as in Twist, and not {0}'),
    (r"cannot import name '(\w+)' from '([\w.]+)'", '{1} has no {0}: check the spelling, and whether it is a message '
     '(PACKAGE.msg) or a service (PACKAGE.srv)'),
    (r'missing \d+ required positional argument', 'hand over the function itself, without parentheses: `callback`, not '
     '`callback()`'),
    (r"module 'rospy' has no attribute '(\w+)'", 'rospy has no {0}: check the spelling and the capital letters, as in '
     'rospy.Publisher'),
    (r"'_?(\w+)' object has no attribute '(\w+)'", '{0} has no field {1}: `rosmsg show {0}` lists its fields, such as '
     'pose.x of a turtle or marker.pose.pose.position.x'),
    (r"name '(\w+)' is not defined",
     'the name {0} is used, but nothing has it: check its spelling, and where it gets a value'),
    (r'to have datatype/md5sum \[([\w/]+)/\w+\], but our version has \[([\w/]+)/\w+\]',
     'both ends of a topic need the same type: one has {0}, the other {1}; the type of the turtle\'s pose is in '
     'turtlesim.msg'),
    (r'(?i)init_node', 'call rospy.init_node before everything else of rospy'),
    (r'unindent does not match|expected an indented block|unexpected indent|TabError',
     'indent each block by four blanks, and use no tabs'),
)


class Seen(NamedTuple):
    """What predicates look at: the Observed, the checks that lost points, and the texts of output and failure."""

    observed: Observed
    lost: Dict[str, Reason]
    said: str


Predicate = Callable[[Seen, Any], bool]


def _median(value: Callable[[Command], float]) -> Predicate:
    """Return a predicate on a number of the commands; it does not hold without commands."""
    return lambda seen, wanted: bool(seen.observed.commands) and within(
        statistics.median(map(value, seen.observed.commands)), wanted)


def _names(role: str) -> Predicate:
    return lambda seen, wanted: any(re.search(wanted, name) for name, done in seen.observed.connections if done == role)


PREDICATES: Dict[str, Predicate] = {
    'lost': lambda seen, wanted: wanted in seen.lost,
    'seen': lambda seen, wanted: any(re.search(wanted, reason.seen) for reason in seen.lost.values()),
    'prints': lambda seen, wanted: bool(re.search(wanted, seen.said)),
    'source': lambda seen, wanted: bool(re.search(wanted, seen.observed.source)),
    'publishes': _names('publishes'), 'subscribes': _names('subscribes'), 'serves': _names('serves'),
    'linear': _median(lambda command: command.linear_x), 'sideways': _median(lambda command: command.linear_y),
    'angular': _median(lambda command: command.angular_z),
    'end x': lambda seen, wanted: bool(seen.observed.track) and within(seen.observed.track[-1].x, wanted),
    'end y': lambda seen, wanted: bool(seen.observed.track) and within(seen.observed.track[-1].y, wanted),
}
def advise(exercise: Exercise, observed: Observed, decided: Verdict) -> Verdict:
    """Return a Verdict with its hints: none if nothing is missing, or undecided."""
    if decided.outcome == scoring.UNDECIDED or decided.score >= 100.0:
        return decided
    lost = {reason.check: reason for reason in decided.reasons if reason.points < reason.of}
    texts = [line.text for line in observed.lines]
    said = '\n'.join([*decided.objections, *(call.trouble for call in observed.calls), *texts[:LINES], *texts[-LINES:]])
    seen = Seen(observed, lost, said)
    found = [*_unknown_names(exercise, observed), *_common(said), *_no_spin(observed), *_local_variable(observed)]
    for symptom in exercise.symptoms:
        values = {name: value for name, value in symptom.items() if name != 'hint' and value not in (None, ANY)}
        if all(PREDICATES[name](seen, value) for name, value in values.items()):
            found.append(symptom['hint'])
    return decided._replace(hints=tuple(dict.fromkeys(found))[:MOST])


def _common(said: str) -> Iterator[str]:
    for pattern, hint in COMMON:
        match = re.search(pattern, said)
        if match:
            yield hint.format(*match.groups())
            return


def _unknown_names(exercise: Exercise, observed: Observed) -> Iterator[str]:
    """Names that the program alone uses and that are like one of the simulator, the grader or the task."""
    asked = {value for scored in exercise.rules for key, value in scored.parameters.items()
             if key in ('topic', 'service')}
    known = asked | {name for name, _ in observed.others if not OF_EVERY_NODE.fullmatch(name)}
    likely = {name for name in known if name.lstrip('/') in exercise.asks}
    used = dict(sorted(observed.connections))
    used.update((name, 'uses') for name in _names_in(observed.source) if name not in used)
    for name, role in used.items():
        if name not in known and not OF_EVERY_NODE.fullmatch(name):
            meant = _meant(name, likely) or _meant(name, known)
            if meant:
                yield f'the program {DOES[role].format(name)}: did you mean {meant}?'


def _meant(name: str, known: Set[str]) -> Optional[str]:
    """Return the known name that a wrong one is like: with the same last part, or else similar as a whole."""
    last = name.rsplit('/', 1)[-1].lower()
    same = sorted(one for one in known if one.rsplit('/', 1)[-1].lower() == last)
    similar = difflib.get_close_matches(name, sorted(known), 1, SIMILAR)
    return (*same, *similar, None)[0]


def _names_in(source: str) -> List[str]:
    """Return the names of topics and services that stand in a program as texts; only names with a slash in them."""
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return []
    texts = [node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return ['/' + text.lstrip('/') for text in texts if '/' in text and NAME.fullmatch(text)]


def _no_spin(observed: Observed) -> Iterator[str]:
    if observed.exit_code == 0 and WAITING.search(observed.source) and not KEPT_ALIVE.search(observed.source):
        yield ('the program ended by itself: rospy.spin() in its last line keeps it running, so that its callbacks are '
               'called')


def _local_variable(observed: Observed) -> Iterator[str]:
    """Functions that give a value to a name of the module without ``global``."""
    try:
        tree = ast.parse(observed.source)
    except (SyntaxError, ValueError):
        return

    def stored(nodes: Iterator[ast.AST]) -> Set[str]:
        return {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    outside = stored(node for statement in tree.body if isinstance(statement, ast.Assign)
                     for node in ast.walk(statement))
    for function in functions:
        declared = {name for node in ast.walk(function) if isinstance(node, ast.Global) for name in node.names}
        read = {node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
        for name in sorted(stored(ast.walk(function)) & outside - declared - read):
            yield (f'{name} in {function.name} is another variable than {name} outside: write `global {name}` in the '
                   'first line of the function')
