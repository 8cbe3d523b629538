"""Possible mistakes in the source of a Python program whose vehicle does not move as required. Without ROS.

The same code may be right elsewhere, so it counts only if a check of the motion has lost points, and if what was
observed does not speak against it.
"""
import ast
import math
import re
from typing import Callable, Container, Dict, Iterator, List, Optional, Set, Tuple

from course_grader.rules.observation import Observed, whole_turn
from course_grader.rules.source_mistakes import Program, callbacks, calls, dotted, functions, last, names, number, text

POSITIONS = 'x', 'y', 'theta'
ANGLES = 30, 45, 60, 90, 120, 135, 180, 225, 270, 360
CONVERTS = re.compile(r'radians|deg2rad|/\s*180|180(\.0*)?\s*/|0\.0?17')  # degrees to radians
NO_ANGLES = 'range', 'sleep', 'Rate', 'Duration', 'SetPen', 'set_pen', 'pen'
SHOWS = re.compile(r'print|log(info|warn|err|debug|fatal)\w*|format|str|write')  # functions that show a number
AXIS = re.compile(r'(?:.*_)?(?:d|delta|diff|error)?_?([xyz])(?:\d|_.*)?', re.IGNORECASE)  # x, dx, goal_x, x_error
ANGLE = re.compile(r'(?:.*_)?(?:theta|yaw|heading|angle)\d?', re.IGNORECASE)
ROTATES = re.compile(r'(?:.*_)?(?:sin|cos)|.*(?:theta|yaw|heading|angle|angular|(?<!re)turn|rotat|corner|degree|euler|'
                     r'teleport).*', re.IGNORECASE)  # names of what has to do with an angle
FLOOD = 0.025  # [s] between two commands, if the program did not wait: one in each tick of the simulator
NEAR_PI = 3.0  # [rad]: a heading beside its jump
SPINS = 6.0 * math.pi  # [rad] that a vehicle turns, three times what a closed shape needs
NOTHING = Observed()
LONG_SLEEP = 0.1  # [s]: longer than the messages of any sensor are apart
PAUSES = re.compile(r'sleep|wait|connections|spin|input|init_node|Subscriber|Service')  # time for a connection
FIELDS = {'TeleportAbsolute': ('x', 'y', 'theta'), 'Spawn': ('x', 'y', 'theta', 'name'),
          'SetPen': ('r', 'g', 'b', 'width', 'off')}
WRAPS = re.compile(r'remainder|fmod|normali|wrap|shortest|sin$', re.IGNORECASE)  # functions that wrap it to -pi to pi


def _grows(one: Program, observed: Observed) -> Iterator[str]:
    """A velocity that is added to, and changes."""
    constant = len({command[1:4] for command in observed.commands}) in (1, 2)  # perhaps with a last zero
    for node in one.nodes:
        if not constant and isinstance(node, ast.AugAssign) and isinstance(node.op, (ast.Add, ast.Sub, ast.Mult)) and (
                re.search(r'\b(linear|angular)\.[xyz]$', dotted(node.target))):
            yield f'line {node.lineno} changes the velocity each time, so that it grows: set it by = instead of +='


def _rounds_down(one: Program, _observed: Observed) -> Iterator[str]:
    """A division whose result is a whole number, and no index of a list."""
    indices = {part for node in one.nodes if isinstance(node, ast.Subscript) or isinstance(node, ast.Call)
              and last(node.func) in ('range', 'len') for part in ast.walk(node)}
    for node in one.nodes:
        if isinstance(node, (ast.BinOp, ast.AugAssign)) and isinstance(node.op, ast.FloorDiv) and (
                node not in indices and not any(calls(list(ast.walk(node)), 'len'))):
            yield f'// in line {node.lineno} rounds down to a whole number: / divides'


def _no_pause(one: Program, observed: Observed) -> Iterator[str]:
    """A loop that publishes as fast as it can."""
    line, times = _without_a_pause(one), [command.t for command in observed.commands]
    if line is not None and (len(times) < 3 or any(b - a < FLOOD for a, b in zip(times, times[1:]))):
        yield (f'the loop in line {line} sends its commands without a pause, and each one replaces the one before: '
               'call rate.sleep() in it, or rospy.sleep for as long as a command should last')


def publishes_nothing(one: Optional[Program]) -> Optional[str]:
    """Return advice on a program that publishes nothing but ``Twist()``, or None."""
    sent = list(calls(one.nodes, 'publish')) if one else []
    empty = [call for call in sent if call.args and isinstance(call.args[0], ast.Call)
             and last(call.args[0].func) == 'Twist' and not call.args[0].args and not call.args[0].keywords]
    if not empty or len(empty) < len(sent):
        return None
    return f'line {empty[0].lineno} publishes Twist(), a new message of zeros: publish the one that was filled'


def _without_a_pause(one: Program) -> Optional[int]:
    """Return the line of a loop that publishes and never waits, or None."""
    own = {function.name: function for function in functions(one)}

    def called(node: ast.AST, seen: Set[str]) -> Set[str]:
        found = {last(call.func) for call in ast.walk(node) if isinstance(call, ast.Call)}
        for name in found & set(own) - seen:
            found |= called(own[name], seen | found)
        return found
    in_callbacks = {part for function in callbacks(one) for part in ast.walk(function)}  # over what a message has
    for node in one.nodes:
        if isinstance(node, ast.While) or isinstance(node, ast.For) and node not in in_callbacks:
            names = called(node, set())
            if 'publish' in names and not any(re.search('sleep|wait|spin|join|pause', name) for name in names):
                return node.lineno
    return None


def in_degrees(one: Program, _observed: Observed = NOTHING) -> Iterator[str]:
    """An angle that is converted to degrees, and used as a turn speed, for a quaternion, or in sin and cos."""
    converted = list(calls(one.nodes, 'degrees', 'rad2deg'))
    if not converted or CONVERTS.search(one.source):
        return
    made: Set[str] = set()

    def in_it(node: ast.AST) -> bool:
        return any(part in converted or last(part) in made for part in ast.walk(node))
    for _ in range(2):  # names that get it, and names that get those
        made |= {last(node.targets[0]) for node in one.nodes if isinstance(node, ast.Assign) and in_it(node.value)} - {
            ''}
    used: List[ast.AST] = [node.value for node in one.nodes if isinstance(node, ast.Assign) and re.search(
        r'\bangular\.[xyz]$', dotted(node.targets[0]))]
    used += calls(one.nodes, 'sin', 'cos', 'tan', 'quaternion_from_euler', 'sendTransform')
    if any(map(in_it, used)):
        yield (f'{last(converted[0].func)} in line {converted[0].lineno} makes degrees of an angle: those of ROS are '
               'in radians, and turn speeds in rad/s')


def _swapped_atan2(one: Program, _observed: Observed) -> Iterator[str]:
    """``atan2(dx, dy)``."""
    for call in calls(one.nodes, 'atan2', 'arctan2'):
        if [_axis(argument) for argument in call.args] == ['x', 'y']:
            yield f'atan2 in line {call.lineno} takes y first: math.atan2(dy, dx) is the direction to a point'


def _axis(node: ast.AST) -> str:
    """Return x, y or z if all names of an axis in an expression belong to it, otherwise ''.

    Results of functions such as sin belong to no axis.
    """
    if any(isinstance(part, ast.Call) for part in ast.walk(node)):
        return ''
    found = [AXIS.fullmatch(last(part)) for part in ast.walk(node) if isinstance(part, (ast.Name, ast.Attribute))]
    axes = {match[1].lower() for match in found if match}
    return axes.pop() if len(axes) == 1 else ''


def _part_of_a_quaternion(one: Program, _observed: Observed) -> Iterator[str]:
    """``orientation.z`` as an angle."""
    parts = [node for node in one.nodes if isinstance(node, ast.Attribute) and last(node.value) == 'orientation'
             and isinstance(node.ctx, ast.Load)]
    half = {part for node in one.nodes if isinstance(node, ast.Compare) or isinstance(node, ast.Call) and last(
        node.func) in ('asin', 'arcsin', 'acos', 'arccos', 'atan2', 'arctan2') for part in ast.walk(node)}
    if {part.attr for part in parts} in ({'z'}, {'w'}) and not half & set(parts):
        yield (f'orientation.{parts[0].attr} in line {parts[0].lineno} is a part of a quaternion, and no angle: yaw '
               'is euler_from_quaternion([q.x, q.y, q.z, q.w])[2] of tf.transformations')


def unwrapped(one: Program, observed: Observed) -> Iterator[str]:
    """Sums and differences of headings that are never wrapped to -pi to pi, although a heading came near that."""
    if observed.track and all(abs(sample.theta) < NEAR_PI for sample in observed.track):
        return
    wraps = any(
        isinstance(node, ast.Call) and WRAPS.search(last(node.func))
        or isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mod) and not isinstance(
            node.left, (ast.Constant, ast.JoinedStr))
        or isinstance(node, ast.Compare) and any(
            last(part) == 'pi' or isinstance(part, ast.Constant) and str(part.value).startswith('3.14')
            for part in ast.walk(node))
        for node in one.nodes)
    for node in one.nodes:
        if not wraps and isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)) and any(
                ANGLE.fullmatch(last(side)) for side in (node.left, node.right)):
            yield (f'line {node.lineno} computes with a heading, which jumps from pi to -pi: bring the difference d of '
                   'two headings to this range by math.atan2(math.sin(d), math.cos(d))')
            return


def _read_once(one: Program, _observed: Observed) -> Iterator[str]:
    """A message that is received before a loop, used in it, and never received again."""
    loops = [node for node in one.nodes if isinstance(node, (ast.While, ast.For))]
    inside = {part for loop in loops for part in ast.walk(loop)}
    again = {ast.dump(call.args[0]) for call in calls(one.nodes, 'Subscriber', 'wait_for_message')
             if call.args and (call in inside or last(call.func) == 'Subscriber')}
    for node in one.nodes:
        if (isinstance(node, ast.Assign) and node not in inside and isinstance(node.value, ast.Call)
                and last(node.value.func) == 'wait_for_message' and node.value.args
                and ast.dump(node.value.args[0]) not in again):
            name = last(node.targets[0])
            if any(last(part) == name for loop in loops if isinstance(loop, ast.While) for part in ast.walk(loop)):
                yield (f'{name} in line {node.lineno} is read only once, and stays the same from then on: read it '
                       'again inside of the loop, or use a Subscriber')


def _another_topic_of_a_bag(one: Program, _observed: Observed) -> Iterator[str]:
    """A bag from which other topics are read than were written."""
    def texts(nodes: List[ast.AST]) -> Set[str]:
        return {part.value for node in nodes for part in ast.walk(node) if isinstance(part, ast.Constant)
                and isinstance(part.value, str) and part.value}
    written = texts([call.args[0] for call in calls(one.nodes, 'write') if len(call.args) > 1])
    read = texts([part for call in calls(one.nodes, 'read_messages')
                  for part in (*call.args, *(key.value for key in call.keywords if key.arg == 'topics'))])
    if written and read and not written & read:
        yield (f'the topic {min(read)} is read from the bag, but {min(written)} is what was recorded: read the same '
               'name')


def _before_it_is_connected(one: Program, observed: Observed) -> Iterator[str]:
    """A message that is sent as soon as its publisher is made, and not repeatedly."""
    if observed.commands and len(list(calls(one.nodes, 'publish'))) == 1 and not any(
            isinstance(node, (ast.For, ast.While)) for node in one.nodes):
        return  # it has arrived
    own = {function.name for function in functions(one)}
    for node in one.nodes:
        body = getattr(node, 'body', None)
        block = body if isinstance(body, list) else []
        for index, made in enumerate(block):
            if not _makes_a_publisher(made):
                continue
            sends = f'{dotted(made.targets[0])}.publish'
            following = [call for part in block[index + 1:] if not isinstance(part, (ast.FunctionDef, ast.ClassDef))
                         for call in _in_order(part) if dotted(call.func) == sends or last(call.func) in own
                         or PAUSES.search(last(call.func))]
            if following and dotted(following[0].func) == sends and not _is_repeated(one, following[0]):
                yield (f'line {following[0].lineno} publishes as soon as the publisher is made, when nobody is '
                       'connected, so that the message is lost: wait until get_num_connections() of the publisher is '
                       'not 0, or publish again and again in a loop')


def _makes_a_publisher(statement: ast.stmt) -> bool:
    """Return whether a statement gives a name to a Publisher that does not keep its last message."""
    return (isinstance(statement, ast.Assign) and isinstance(statement.value, ast.Call)
            and last(statement.value.func) == 'Publisher' and not any(
                key.arg == 'latch' for key in statement.value.keywords))


def _in_order(node: ast.AST) -> List[ast.Call]:
    later = {part for inner in ast.walk(node) if isinstance(inner, ast.Lambda) for part in ast.walk(inner)}
    return sorted((part for part in ast.walk(node) if isinstance(part, ast.Call) and part not in later),
                  key=lambda call: (call.lineno, call.col_offset))


def _is_repeated(one: Program, call: ast.Call) -> bool:
    """Return whether a call is in a loop that makes it more often than once a second."""
    for loop in one.nodes:
        if isinstance(loop, (ast.While, ast.For)) and call in ast.walk(loop):
            pauses = [number(part.args[0]) for part in calls(list(ast.walk(loop)), 'sleep') if part.args]
            if isinstance(loop, ast.While) or not pauses or any(pause is None or pause < 1.0 for pause in pauses):
                return True
    return False


def _looked_up_too_early(one: Program, _observed: Observed) -> Iterator[str]:
    """A transform that is looked up for the present time, for which none has arrived."""
    if any(calls(one.nodes, 'waitForTransform', 'can_transform', 'wait_for_transform_async')):
        return
    present = {last(node.targets[0]) for node in one.nodes if isinstance(node, ast.Assign) and _is_now(node.value)}
    for call in calls(one.nodes, 'lookup_transform', 'lookupTransform'):
        if len(call.args) == 3 and not call.keywords and (
                _is_now(call.args[2]) or last(call.args[2]) in present - {''}):
            yield (f'line {call.lineno} looks a transform up for this very moment, for which none has arrived yet: '
                   'rospy.Time(0) asks for the latest one')


def _swapped_frames(one: Program, _observed: Observed) -> Iterator[str]:
    """A way that is looked up in the frame of its goal, instead of that of the turtle that drives."""
    driven = {name.split('/')[1] for name in names(one) if name.endswith('/cmd_vel')}
    for call in calls(one.nodes, 'lookup_transform', 'lookupTransform'):
        target, source = ([text(part).lstrip('/') for part in call.args[:2]] + ['', ''])[:2]
        if source in driven and target and target not in driven:
            yield (f'line {call.lineno} looks up where {source} is for {target}: the frame of the turtle that drives '
                   f'comes first, {source!r}, and then {target!r}')


def _is_now(node: ast.AST) -> bool:
    return isinstance(node, ast.Call) and dotted(node.func) in ('rospy.Time.now', 'rospy.get_rostime')


def _angle_in_a_quaternion(one: Program, _observed: Observed) -> Iterator[str]:
    """``orientation.z = theta``."""
    for node in one.nodes:
        if not isinstance(node, ast.Assign):
            continue
        for target in node.targets:
            if isinstance(target, ast.Attribute) and last(target.value) in ('orientation', 'rotation') and (
                    abs(number(node.value) or 0.0) > 1.0 or ANGLE.fullmatch(last(node.value))
                    or isinstance(node.value, ast.Call) and last(node.value.func) == 'radians'):
                yield (f'{dotted(target)} in line {node.lineno} is a part of a quaternion, and no angle: for a '
                       'heading, z = sin(heading / 2), w = cos(heading / 2)')
                return


def _order_of_values(one: Program, _observed: Observed) -> Iterator[str]:
    """Values of a call in another order than the service has them."""
    kinds = {last(node.targets[0]): last(node.value.args[1]) for node in one.nodes if isinstance(node, ast.Assign)
             and isinstance(node.value, ast.Call) and last(node.value.func) == 'ServiceProxy'
             and len(node.value.args) > 1}
    for call in (node for node in one.nodes if isinstance(node, ast.Call)):
        kind = kinds.get(last(call.func), '')
        if any(meant not in ('', right) for meant, right in zip(map(_field, call.args), FIELDS.get(kind, ()))):
            yield f'{kind} in line {call.lineno} takes its values in this order: {", ".join(FIELDS[kind])}'


def _field(node: ast.AST) -> str:
    """Return the field that the name of a value belongs to, or ''."""
    return _axis(node) or ('theta' if ANGLE.fullmatch(last(node)) else '')


def _crossed_velocities(one: Program, _observed: Observed) -> Iterator[str]:
    """``linear.x = pose.angular_velocity``."""
    crossed = {('linear', 'angular_velocity'), ('angular', 'linear_velocity')}
    for node in (node for node in one.nodes if isinstance(node, ast.Assign)):
        target = dotted(node.targets[0]).split('.')
        if len(target) > 2 and (target[-2], last(node.value)) in crossed:
            yield f'line {node.lineno} sets {".".join(target[-2:])} to {last(node.value)}'


def _own_heading(one: Program, _observed: Observed) -> Iterator[str]:
    """A direction to a point that no heading is subtracted from."""
    if one.read & {'theta', 'orientation', 'lookup_transform', 'lookupTransform', 'markers'} or not re.search(
            r'turtlesim\.msg|\bOdometry\b', one.source):
        return
    for call in calls(one.nodes, 'atan2', 'arctan2'):
        if [_axis(argument) for argument in call.args] == ['y', 'x']:
            yield (f'atan2 in line {call.lineno} is the direction to the point, seen from above: subtract its own '
                   'heading, theta of the pose, from it')
            return


def same_part_twice(one: Program, _observed: Observed) -> Iterator[str]:
    """``(pose.x, pose.x, 0)``."""
    for node in one.nodes:
        if isinstance(node, ast.Tuple) and len(node.elts) > 1:
            parts = [{dotted(part) for part in ast.walk(element) if isinstance(part, ast.Attribute)
                      and part.attr in ('x', 'y')} for element in node.elts[:2]]
            for name in sorted(parts[0] - {''}) if parts[0] == parts[1] and len(parts[0]) == 1 else ():
                other = name[:-1] + {'x': 'y', 'y': 'x'}[name[-1]]
                yield f'line {node.lineno} uses {name} twice, and {other} not at all'


def sleeps_in_a_callback(one: Program, observed: Observed = NOTHING) -> Iterator[str]:
    """A callback that waits, while the next messages queue up behind it, and does what it does as rarely as that."""
    rates = [number(call.args[0]) for call in calls(one.nodes, 'Rate') if call.args]
    of_a_rate = 1.0 / rates[0] if len(rates) == 1 and rates[0] else LONG_SLEEP
    done = max(len(observed.commands), len(observed.lines))
    for function in callbacks(one):
        for call in calls(list(ast.walk(function)), 'sleep'):
            seconds = number(call.args[0]) if call.args else of_a_rate
            if seconds is not None and seconds >= LONG_SLEEP and done * seconds <= 2.0 * (observed.seconds or done):
                yield (f'the callback {function.name} sleeps in line {call.lineno}, and gets the next message only '
                       'after that: let it return at once')
                return


def another_frame(one: Program) -> Iterator[str]:
    """A pose that is in another frame than map, in which those of all tasks of navigation are."""
    match = re.search(r"""frame_id\s*=\s*['"](?!/?map['"])([^'"]*)""", one.source)
    if match:
        yield f"the poses of the task are in the frame map: write frame_id = 'map' instead of {match[1]!r}"


def only_debugs(one: Program) -> Iterator[str]:
    """Messages of the level debug, which are not printed, and no others."""
    shown = any(SHOWS.fullmatch(name) and name != 'logdebug' for name in one.read)
    if 'logdebug' in one.read and not shown and 'log_level' not in one.source:
        yield 'messages of rospy.logdebug are not printed: use rospy.loginfo, or init_node(..., log_level=rospy.DEBUG)'


KINDS: Tuple[Callable[[Program, Observed], Iterator[str]], ...] = (
    _grows, _rounds_down, in_degrees, _swapped_atan2, _part_of_a_quaternion, _angle_in_a_quaternion,
    _crossed_velocities, _another_topic_of_a_bag, _read_once, _looked_up_too_early, _swapped_frames, _order_of_values,
    _before_it_is_connected, sleeps_in_a_callback, _no_pause, same_part_twice)


def found(one: Program, positions: bool, observed: Observed = NOTHING) -> List[str]:
    """Return advice, the most likely causes first; ``positions``: whether a position is required."""
    return [*(_of_positions(one, observed) if positions else ()),
            *(hint for kind in KINDS for hint in kind(one, observed)),
            *(_own_heading(one, observed) if positions else ())]


def _of_positions(one: Program, observed: Observed) -> Iterator[str]:
    line = compares_exactly(one)
    if line is not None:
        yield (f'line {line} compares a position by == or !=, but it never is exactly that number: use < or >=, or '
               'abs(a - b) < 0.1')
    line = degrees(one, {abs(command.angular_z) for command in observed.commands}, whole_turn(observed.track) > SPINS)
    if line is not None:
        yield (f'the angle in line {line} is in degrees, and angles are in radians: write math.radians(90), or '
               'math.pi / 2, for 90 degrees')


def compares_exactly(one: Program) -> Optional[int]:
    """Return the line in which a coordinate is compared by ``==`` or ``!=``, or None.

    ``pose.x != last.x`` is right where ``last = pose`` keeps an earlier message: nothing has changed in between.
    """
    kept = {frozenset((target.id, node.value.id)) for node in one.nodes if isinstance(node, ast.Assign)
            and isinstance(node.value, ast.Name) for target in node.targets if isinstance(target, ast.Name)}
    values = {target.id for node in one.nodes if isinstance(node, ast.Assign) and last(node.value) in POSITIONS
              for target in node.targets if isinstance(target, ast.Name)}
    for node in one.nodes:
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], (ast.Eq, ast.NotEq)):
            sides: Dict[str, ast.expr] = {'left': node.left, 'right': node.comparators[0]}
            known = [side for side in sides.values() if isinstance(side, ast.Constant)
                     and not isinstance(side.value, (int, float))]
            inner = [last(part) for side in sides.values() for part in ast.walk(side)]
            owners = frozenset(side.value.id for side in sides.values()
                               if isinstance(side, ast.Attribute) and isinstance(side.value, ast.Name))
            if not known and owners not in kept and any(name in (*POSITIONS, *values) for name in inner):
                return node.lineno
    return None


def degrees(one: Program, commanded: Container[float] = (), spins: bool = False) -> Optional[int]:
    """Return the line with an angle in degrees that nothing converts to radians, or None.

    It is an angle if names beside it say so, if it is ``commanded`` as a turn speed, or if the vehicle ``spins``.
    """
    if CONVERTS.search(one.source) or any(calls(one.nodes, 'degrees', 'rad2deg')):
        return None
    counted = {part for call in calls(one.nodes, *NO_ANGLES) for part in ast.walk(call)}
    for node in one.nodes:
        if not isinstance(node, (ast.Assign, ast.Compare, ast.BinOp, ast.Call, ast.Tuple, ast.List)):
            continue
        parts = list(ast.walk(node))
        numbers = [part for part in parts if isinstance(part, ast.Constant) and type(part.value) in (int, float)
                   and part.value in ANGLES and part not in counted]
        listed = isinstance(node, (ast.Tuple, ast.List)) and len(node.elts) > 2 and re.search(
            'sin|euler|teleport', one.source)
        if numbers and (spins or listed or any(part.value in commanded for part in numbers) or any(
                ROTATES.fullmatch(last(part)) for part in parts)):
            return numbers[0].lineno
    return None
