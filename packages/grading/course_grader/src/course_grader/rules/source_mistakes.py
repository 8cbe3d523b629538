"""Mistakes in the source of a Python program, independent of its run: advice for each. Without ROS."""
import ast
import re
from typing import Callable, Iterator, List, NamedTuple, Optional, Set, Tuple, Union

Function = Union[ast.FunctionDef, ast.AsyncFunctionDef]
NEED_PARENTHESES = ('publish', 'sleep', 'spin', 'is_shutdown', 'init_node', 'wait_for_service', 'unregister', 'start',
                    'wait_for_server', 'wait_for_result', 'close')
TAKE_A_FUNCTION = {'Subscriber': 2, 'Service': 2, 'Timer': 1, 'on_shutdown': 0}  # and its place
WORKS = 'publish', 'init_node', 'Publisher', 'Subscriber', 'Service', 'ServiceProxy', 'spin', 'sendTransform'
MAKES = 'Publisher', 'Subscriber', 'Service', 'ServiceProxy', 'Timer', 'publish'
MAX_SOURCE = 20_000  # characters: the search takes quadratic time
WAITING = 'Subscriber', 'Service', 'Timer'

TYPES = (  # pattern of a name, its type, and the module of that
    (r'(/turtle\w*)?/cmd_vel', 'Twist', 'geometry_msgs.msg'), (r'/turtle\w*/pose', 'Pose', 'turtlesim.msg'),
    (r'/scan', 'LaserScan', 'sensor_msgs.msg'), (r'/global_localization', 'Empty', 'std_srvs.srv'),
    (r'/scan_to_distance', 'LaserScanSplit', 'robotont_laserscan_to_distance.msg'),
    (r'/initialpose', 'PoseWithCovarianceStamped', 'geometry_msgs.msg'),
    (r'/odom', 'Odometry', 'nav_msgs.msg'), (r'/ar_pose_marker', 'AlvarMarkers', 'ar_track_alvar_msgs.msg'),
    (r'/turtle\w*/set_pen', 'SetPen', 'turtlesim.srv'), (r'/spawn', 'Spawn', 'turtlesim.srv'),
    (r'/turtle\w*/teleport_absolute', 'TeleportAbsolute', 'turtlesim.srv'), (r'/kill', 'Kill', 'turtlesim.srv'),
    (r'/turtle\w*/teleport_relative', 'TeleportRelative', 'turtlesim.srv'), (r'/clear|/reset', 'Empty', 'std_srvs.srv'))


class Program(NamedTuple):
    """A program: its source, its tree, all nodes of that, and the names that are read anywhere."""

    source: str
    tree: ast.Module
    nodes: List[ast.AST]
    read: Set[str]


def program(source: str) -> Optional[Program]:
    """Return the Program of a source, or None if Python cannot parse it, or it is too long to search."""
    if len(source) > MAX_SOURCE:
        return None
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    nodes = list(ast.walk(tree))
    read = {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
    read |= {node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load)}
    return Program(source, tree, nodes, read)


def names(one: Program) -> List[str]:
    """Return the full names of topics and services in a program.

    These are strings with a slash, and arguments of Publisher, Subscriber, Service, ServiceProxy and wait_for_service.
    """
    parts = {part for node in one.nodes if isinstance(node, (ast.JoinedStr, ast.BinOp)) for part in ast.walk(node)}
    texts = [node.value for node in one.nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)
             and '/' in node.value and node not in parts]
    for call in calls(one.nodes, 'Publisher', 'Subscriber', 'Service', 'ServiceProxy', 'wait_for_service'):
        texts += [first.value for first in call.args[:1] if isinstance(first, ast.Constant)
                  and isinstance(first.value, str)]
    return ['/' + text.lstrip('/') for text in texts if re.fullmatch(r'/?[A-Za-z]\w*(/\w+)*', text)]


def calls(nodes: List[ast.AST], *called: str) -> Iterator[ast.Call]:
    """Return the calls of functions or methods with these names."""
    return (node for node in nodes if isinstance(node, ast.Call) and last(node.func) in called)


def last(node: Optional[ast.AST]) -> str:
    """Return the last part of a dotted name, or ''."""
    return node.attr if isinstance(node, ast.Attribute) else node.id if isinstance(node, ast.Name) else ''


def dotted(node: ast.AST) -> str:
    """Return a dotted name as it is written, or ''."""
    if isinstance(node, ast.Attribute):
        before = dotted(node.value)
        return before and f'{before}.{node.attr}'
    return node.id if isinstance(node, ast.Name) else ''


def number(node: ast.AST) -> Optional[float]:
    """Return the number that is written there, or None."""
    value = node.value if isinstance(node, ast.Constant) else None
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def text(node: ast.AST) -> str:
    """Return the text that is written there, or ''."""
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ''


def functions(one: Program) -> List[Function]:
    return [node for node in one.nodes if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))]


def callbacks(one: Program) -> List[Function]:
    """Return the functions that are given to Subscribers."""
    names = {last(argument) for call in calls(one.nodes, 'Subscriber')
             for argument in (*call.args[2:3], *(key.value for key in call.keywords if key.arg == 'callback'))}
    return [function for function in functions(one) if function.name in names]


def _methods(one: Program) -> Iterator[Tuple[ast.ClassDef, Function]]:
    for node in one.nodes:
        if isinstance(node, ast.ClassDef):
            yield from ((node, part) for part in node.body if isinstance(part, (ast.FunctionDef, ast.AsyncFunctionDef)))


def _no_parentheses(one: Program) -> Iterator[str]:
    """Functions and services that are named instead of called."""
    own = {function.name for function in functions(one)} | {
        last(node.targets[0]) for node in one.nodes if isinstance(node, ast.Assign)
        and isinstance(node.value, ast.Call) and last(node.value.func) == 'ServiceProxy'}
    for node in one.nodes:
        if isinstance(node, ast.Expr) and dotted(node.value) and (
                last(node.value) in NEED_PARENTHESES or last(node.value) in own):
            yield (f'line {node.lineno} only names {dotted(node.value)}: parentheses call it, as in '
                   f'{dotted(node.value)}()')
        if isinstance(node, (ast.While, ast.If)):
            called = [call.func for call in calls(one.nodes, 'is_shutdown')]
            if any(last(part) == 'is_shutdown' and part not in called for part in ast.walk(node.test)):
                yield f'line {node.lineno} only names is_shutdown: parentheses call it, as in rospy.is_shutdown()'


def _called_at_once(one: Program) -> Iterator[str]:
    """A callback that is called instead of passed."""
    own = {function.name for function in functions(one)}
    for kind, place in TAKE_A_FUNCTION.items():
        for call in calls(one.nodes, kind):
            given = call.args[place:place + 1] + [key.value for key in call.keywords if key.arg in (
                'callback', 'handler')]
            for argument in given:
                if isinstance(argument, ast.Call) and last(argument.func) in own and not _returns_a_function(
                        one, last(argument.func)):
                    name = dotted(argument.func)
                    yield f'hand over the function itself, without parentheses: `{name}`, not `{name}()`'


def _returns_a_function(one: Program, name: str) -> bool:
    return any(isinstance(node, ast.Return) and node.value is not None for function in functions(one)
               if function.name == name for node in ast.walk(function))


def _wrong_type(one: Program) -> Iterator[str]:
    """A topic or service of a simulator with a wrong type."""
    modules = {alias.asname or alias.name: node.module or '' for node in one.nodes if isinstance(node, ast.ImportFrom)
               for alias in node.names}
    for call in calls(one.nodes, 'Publisher', 'Subscriber', 'ServiceProxy', 'wait_for_message'):
        if len(call.args) < 2 or not isinstance(call.args[0], ast.Constant):
            continue
        name, given = '/' + str(call.args[0].value).lstrip('/'), last(call.args[1])
        for pattern, right, module in TYPES:
            known = modules.get(given, module)
            other = known.endswith(('.msg', '.srv')) and known != module
            if given and given[0].isupper() and re.fullmatch(pattern, name) and (
                    given != right and given in modules and modules[given].endswith(('.msg', '.srv')) or other):
                yield f'{name} has the type {right}: `from {module} import {right}`'


def _no_callback(one: Program) -> Iterator[str]:
    """A subscriber without a callback."""
    for call in calls(one.nodes, 'Subscriber'):
        if len(call.args) == 2 and not any(key.arg in ('callback', None) for key in call.keywords) and (
                dotted(call.func) in ('Subscriber', 'rospy.Subscriber') and 'message_filters' not in one.source):
            yield (f'the Subscriber in line {call.lineno} has no callback: its third argument is the function that '
                   'gets each message')


def _proxy_with_a_function(one: Program) -> Iterator[str]:
    """A service that is called instead of offered."""
    own = {function.name for function in functions(one)}
    for call in calls(one.nodes, 'ServiceProxy'):
        if any(last(argument) in own for argument in call.args[2:]):
            yield ('rospy.ServiceProxy calls a service of somebody else; rospy.Service(NAME, TYPE, function) offers '
                   'your own')


def _wrong_main(one: Program) -> Iterator[str]:
    """``if __name__ == 'main'``."""
    for node in one.nodes:
        if isinstance(node, ast.Compare) and last(node.left) == '__name__':
            other = node.comparators[0]
            if isinstance(other, ast.Constant) and other.value != '__main__':
                yield f"line {node.lineno} is never true: it has to be `if __name__ == '__main__':`"


def _never_called(one: Program) -> Iterator[str]:
    """Functions, methods and classes with the work of a program that nothing uses."""
    for node in one.tree.body:
        if isinstance(node, ast.ClassDef) and not node.bases and not node.decorator_list and node.name not in one.read \
                and any(calls(list(ast.walk(node)), *WORKS)):
            yield f'nothing uses the class {node.name}: make an object by {node.name}(...)'
    parts = [(function, '') for function in one.tree.body if isinstance(function, ast.FunctionDef)]
    parts += [(method, 'self.') for owner, method in _methods(one) if isinstance(method, ast.FunctionDef)
              and _bare(owner) and not method.name.startswith('__') and owner.name in one.read]
    for function, before in parts:
        nodes = list(ast.walk(function))
        works = any(_all_in(one, nodes, kind) for kind in WORKS) or (  # otherwise it may be left over
            len(function.args.args) == (2 if before else 1) and _stores(nodes)
            and any(calls(one.nodes, 'Publisher')) and not any(calls(one.nodes, *WAITING, 'wait_for_message')))
        if function.name not in one.read and not function.decorator_list and works:
            call = 'call it' if before else f'write `{function.name}(...)` at the end of the program'
            yield f'nothing calls {function.name}: ' + (
                f'hand it over to what calls it, such as rospy.Subscriber(TOPIC, TYPE, {before}{function.name}) or '
                f'rospy.Timer, or {call}' if len(function.args.args) > (1 if before else 0) else call)


def _stores(nodes: List[ast.AST]) -> bool:
    """Return whether a function keeps something outside of it."""
    return any(isinstance(node, ast.Global) or isinstance(node, ast.Attribute) and last(node.value) == 'self'
               and isinstance(node.ctx, ast.Store) for node in nodes)


def _bare(owner: ast.ClassDef) -> bool:
    """Return whether a class has no base class except object; a base class could call its methods."""
    return not [base for base in owner.bases if last(base) != 'object']


def _values_of_a_type(one: Program) -> Iterator[str]:
    """``Pose.x``, where Pose is the type."""
    types = {alias.asname or alias.name for node in one.nodes if isinstance(node, ast.ImportFrom)
             and (node.module or '').endswith('.msg') for alias in node.names
             if alias.name[:1].isupper()}
    for node in one.nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in types \
                and node.attr[:1].islower() and not node.attr.startswith(('serialize', 'deserialize')):
            yield (f'{node.value.id}.{node.attr} is of the type and no value: use the message that the callback gets, '
                   f'or make one by `message = {node.value.id}()`')


def _returned_type(one: Program) -> Iterator[str]:
    """``return TeleportAbsoluteResponse``, which is the type."""
    for node in one.nodes:
        name = last(node.value) if isinstance(node, ast.Return) else ''
        if name.endswith('Response') and name[0].isupper():
            yield f'the function of a service must return a response, and not its type: `return {name}()`'


def _handler_without_return(one: Program) -> Iterator[str]:
    """The function of a service that returns nothing."""
    handlers = {last(call.args[2]): last(call.args[1]) for call in calls(one.nodes, 'Service') if len(call.args) > 2}
    handlers.update((last(key.value), last(call.args[1])) for call in calls(one.nodes, 'Service')
                    for key in call.keywords if key.arg == 'handler' and len(call.args) > 1)
    for function in functions(one):
        if function.name in handlers and not any(
                isinstance(node, ast.Return) and node.value or isinstance(node, (ast.Yield, ast.Raise))
                for node in ast.walk(function)):
            yield f'the function of a service must return a response: `return {handlers[function.name]}Response()`'


def _no_value_returned(one: Program) -> Iterator[str]:
    """A function whose value is kept, but which returns none."""
    silent = {function.name for function in functions(one) if not function.decorator_list and not any(
        isinstance(node, ast.Return) and node.value or isinstance(node, (ast.Yield, ast.YieldFrom, ast.Raise))
        for node in ast.walk(function))}
    for node in one.nodes:
        if isinstance(node, (ast.Assign, ast.Compare, ast.BinOp)):
            call = node.value if isinstance(node, ast.Assign) else node.left
            name = last(call.func) if isinstance(call, ast.Call) else ''
            if isinstance(call, ast.Call) and name in silent and dotted(call.func) in (name, f'self.{name}'):
                yield f'{name} is used as a value in line {node.lineno}, but returns none: `return ...` gives it one'


def _too_late(one: Program) -> Iterator[str]:
    """Work after rospy.spin(), or after a loop that runs as long as the program, here or in a function."""
    for node in one.nodes:
        for block in (getattr(node, 'body', None), getattr(node, 'orelse', None)):
            if not isinstance(block, list) or isinstance(node, ast.ClassDef):
                continue
            for number, part in enumerate(block):
                after = [inner for later in block[number + 1:] for inner in ast.walk(later)]
                late, stays = list(calls(after, 'publish', 'sendTransform')), _stays_in(one, part)
                if _is_endless(part) and late and _all_in(one, after, 'publish', 'sendTransform'):
                    yield (f'line {late[0].lineno} stands after the loop in line {part.lineno}, which ends only '
                           'with the program: indent it, so that it belongs to the loop')
                elif stays:
                    after += [inner for function in functions(one) if any(calls(after, function.name))
                              for inner in ast.walk(function)]
                    if any(_all_in(one, after, kind) for kind in MAKES):
                        yield (f'{stays} in line {part.lineno} returns only when the program ends: what stands after '
                               'it comes too late')


def _stays_in(one: Program, statement: ast.stmt) -> str:
    """Return what keeps a program in a statement until its end: a loop, rospy.spin(), a function with one; or ''."""
    if _is_endless(statement):
        return 'the loop'
    call = statement.value if isinstance(statement, ast.Expr) else None
    name = dotted(call.func) if isinstance(call, ast.Call) else ''
    waits = any(_is_spin(part) or _is_endless(part) for function in functions(one)
                if name in (function.name, f'self.{function.name}') for part in function.body)
    return f'{name}()' if waits or _is_spin(statement) else ''


def _late_lambda(one: Program) -> Iterator[str]:
    """A lambda that is made in a loop, kept, and looks at the variable of the loop when it is called."""
    for loop in one.nodes:
        if not isinstance(loop, ast.For) or isinstance(loop.iter, ast.Constant):
            continue
        varies = {node.id for node in ast.walk(loop.target) if isinstance(node, ast.Name)}
        for call in calls(list(ast.walk(loop)), *WAITING):
            for given in (*call.args, *(key.value for key in call.keywords)):
                own = {node.arg for node in ast.walk(given) if isinstance(node, ast.arg)}
                used = {node.id for node in ast.walk(given) if isinstance(given, ast.Lambda)
                        and isinstance(node, ast.Name)}
                for name in sorted(varies & used - own):
                    yield (f'the lambda in line {given.lineno} looks at {name} when it is called, and finds its last '
                           f'value: keep each one by `lambda message, {name}={name}: ...`')


def _wrong_loop(one: Program) -> Iterator[str]:
    """``while rospy.is_shutdown()``, and rospy.spin() in a loop that publishes, or in a callback."""
    repeated = {part: 'the loop' for loop in one.nodes if isinstance(loop, ast.While) and any(
        calls(list(ast.walk(loop)), 'publish')) for part in ast.walk(loop)}
    repeated.update((part, function.name) for function in callbacks(one) for part in ast.walk(function))
    for node in one.nodes:
        if isinstance(node, ast.While) and isinstance(node.test, ast.Call) and last(node.test.func) == 'is_shutdown':
            yield f'the loop in line {node.lineno} never runs: it has to be `while not rospy.is_shutdown():`'
        elif node in repeated and isinstance(node, ast.stmt) and _is_spin(node):
            yield (f'rospy.spin() in line {node.lineno} returns only when the program ends, so that {repeated[node]} '
                   'does not go on: call it once, in the last line of the program')


def _all_in(one: Program, nodes: List[ast.AST], *called: str) -> bool:
    """Return whether these nodes contain calls of these functions, and nothing else in the program calls them."""
    inside = len(list(calls(nodes, *called)))
    return inside > 0 and inside == len(list(calls(one.nodes, *called)))


def _is_spin(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Call) and dotted(
        statement.value.func) == 'rospy.spin'


def _is_endless(statement: ast.stmt) -> bool:
    """Return whether a statement is ``while not rospy.is_shutdown()``, without another way out."""
    return (isinstance(statement, ast.While) and isinstance(statement.test, ast.UnaryOp)
            and isinstance(statement.test.operand, ast.Call) and last(statement.test.operand.func) == 'is_shutdown'
            and not any(isinstance(inner, (ast.Break, ast.Return)) for inner in ast.walk(statement)))


def _order_of_a_quaternion(one: Program) -> Iterator[str]:
    """``euler_from_quaternion([q.w, q.x, q.y, q.z])``."""
    for call in calls(one.nodes, 'euler_from_quaternion'):
        parts = [last(part) for part in getattr(call.args[0], 'elts', ())] if call.args else []
        if sorted(parts) == ['w', 'x', 'y', 'z'] and parts[0] != 'x':
            yield (f'euler_from_quaternion in line {call.lineno} takes a quaternion in the order x, y, z, w: '
                   'euler_from_quaternion([q.x, q.y, q.z, q.w])')


def _no_publish(one: Program) -> Iterator[str]:
    """A publisher that publishes nothing."""
    if any(calls(one.nodes, 'Publisher')) and 'publish' not in one.read:
        yield 'a publisher sends nothing by itself: call its publish(message)'


def _proxy_not_called(one: Program) -> Iterator[str]:
    """A ServiceProxy that is never called."""
    for node in one.nodes:
        if not isinstance(node, ast.Assign) or not any(node.value is call and len(call.args) <= 2
                                                       for call in calls(one.nodes, 'ServiceProxy')):
            continue
        name = last(node.targets[0])
        read = [other for other in one.nodes if isinstance(other, (ast.Name, ast.Attribute)) and last(other) == name
                and isinstance(other.ctx, ast.Load)]
        waits = [other for other in one.nodes if isinstance(other, ast.Attribute) and last(other.value) == name
                 and other.attr in ('wait_for_service', 'close')]
        if name and len(read) <= len(waits):
            made = dotted(node.targets[0])
            yield f'{made} is made, but never called: `{made}(...)` calls the service'


def _not_started(one: Program) -> Iterator[str]:
    """An action server that is never started."""
    for call in calls(one.nodes, 'SimpleActionServer', 'ActionServer'):
        given = [*call.args[3:4], *(key.value for key in call.keywords if key.arg == 'auto_start')]
        if any(isinstance(value, ast.Constant) and value.value is False for value in given) and 'start' not in one.read:
            yield f'the action server in line {call.lineno} is never started: call its start() after it is made'


def _never_holds(one: Program) -> Iterator[str]:
    """``if x >= 6: ... elif x >= 8: ...``."""
    below = {part for node in one.nodes if isinstance(node, ast.If) for part in node.orelse[:1]
             if len(node.orelse) == 1}
    for node in one.nodes:
        earlier: List[Tuple[str, bool, float, int]] = []
        part = node if isinstance(node, ast.If) and node not in below else None
        while part is not None:
            bound = _bound(part.test)
            for value, upward, limit, line in earlier if bound else ():
                if bound and bound[:2] == (value, upward) and (bound[2] >= limit if upward else bound[2] <= limit):
                    yield (f'the condition in line {part.lineno} never holds, because that in line {line} comes first '
                           'and holds whenever it does: swap their order')
                    return
            earlier += [(*bound, part.lineno)] if bound else []
            following = part.orelse[0] if len(part.orelse) == 1 else None
            part = following if isinstance(following, ast.If) else None


def _bound(test: ast.AST) -> Optional[Tuple[str, bool, float]]:
    """Return of ``value > 6`` the value, whether it has to be larger, and the number; None of other conditions."""
    if not isinstance(test, ast.Compare) or len(test.ops) != 1 or any(
            isinstance(part, ast.Call) for part in ast.walk(test)):
        return None
    limit, upward = number(test.comparators[0]), isinstance(test.ops[0], (ast.Gt, ast.GtE))
    if limit is None or not (upward or isinstance(test.ops[0], (ast.Lt, ast.LtE))):
        return None
    return ast.dump(test.left), upward, limit


def _no_init_node(one: Program) -> Iterator[str]:
    """A program that uses rospy without init_node, which only calls of services do not need."""
    if (any(calls(one.nodes, *(kind for kind in MAKES if kind != 'ServiceProxy'))) and 'init_node' not in one.source
            and 'rospy' in one.read):
        yield 'call rospy.init_node before everything else of rospy'


def _local_variable(one: Program) -> Iterator[str]:
    """Functions that give a value to a name that is read outside of them, without ``global``.

    One that a callback also reads itself counts if all that it gets outside is its first value, such as None or 0.
    """
    own = {function.name for function in callbacks(one)}
    for outer, statements in _scopes(one):
        outside = {node for statement in statements if not isinstance(statement, (ast.FunctionDef, ast.ClassDef))
                   for node in ast.walk(statement)}
        first = {last(node.targets[0]): node.value for node in outside if isinstance(node, ast.Assign)}
        for function in (part for part in statements if isinstance(part, ast.FunctionDef)):
            inside = list(ast.walk(function))
            declared = {name for node in inside if isinstance(node, (ast.Global, ast.Nonlocal)) for name in node.names}
            declared |= {argument.arg for node in inside if isinstance(node, ast.arguments) for argument in node.args}
            read = {node.id for node in inside if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
            elsewhere = {node.id for node in set(one.nodes) - set(inside)
                         if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}
            for name in sorted(_stored(inside) & set(first) & elsewhere - declared):
                if name not in read or function.name in own and not getattr(first[name], 'value', True) and sum(
                        isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Store)
                        for node in set(one.nodes) - set(inside)) == 1:
                    yield (f'{name} in {function.name} is another variable than {name} outside: write '
                           f'`{"nonlocal" if outer else "global"} {name}` in the first line of the function')


def _scopes(one: Program) -> Iterator[Tuple[str, List[ast.stmt]]]:
    """Yield the name of each function, '' of the module, and its statements."""
    yield '', [*one.tree.body, *(part for node in one.tree.body if isinstance(node, ast.If) for part in node.body)]
    yield from ((function.name, function.body) for function in functions(one))


def _stored(nodes: List[ast.AST]) -> Set[str]:
    return {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def _forgotten_self(one: Program) -> Iterator[str]:
    """Methods that give a value to a name that is read as ``self.name`` elsewhere."""
    for owner, method in _methods(one):
        own = {node.attr for node in ast.walk(owner) if isinstance(node, ast.Attribute) and last(node.value) == 'self'
               and isinstance(node.ctx, ast.Load)}
        inside = [node for node in ast.walk(method) if isinstance(node, ast.Name)]
        read = {node.id for node in inside if isinstance(node.ctx, ast.Load)}
        for name in sorted({node.id for node in inside if isinstance(node.ctx, ast.Store)} & own - read):
            yield (f'{name} in {method.name} is another variable than self.{name}: write `self.{name} = ...`')


def _no_self(one: Program) -> Iterator[str]:
    """Methods without ``self``."""
    for _, method in _methods(one):
        arguments = method.args.posonlyargs + method.args.args
        first = arguments[0].arg if arguments else ''
        if not method.decorator_list and not method.args.vararg and first not in ('self', 'cls', 'this', '_'):
            shown = ', '.join(['self', *(argument.arg for argument in arguments)])
            yield f'a method needs self as its first parameter: `def {method.name}({shown}):`'


def _waits_for_itself(one: Program) -> Iterator[str]:
    """A loop in a callback that waits for the message to change."""
    for function in callbacks(one):
        given = {argument.arg for argument in function.args.args} - {'self'}
        for node in ast.walk(function):
            if isinstance(node, ast.While) and given & {last(part) for part in ast.walk(node.test)} and not given & {
                    part.id for part in ast.walk(node) if isinstance(part, ast.Name)
                    and isinstance(part.ctx, ast.Store)}:
                yield (f'the loop in line {node.lineno} looks at the same message again and again: the next one comes '
                       f'with the next call of {function.name}, so write `if` instead of `while`')


KINDS: Tuple[Callable[[Program], Iterator[str]], ...] = (
    _wrong_type, _wrong_main, _no_parentheses, _called_at_once, _proxy_with_a_function, _values_of_a_type,
    _returned_type, _handler_without_return, _no_value_returned, _no_self, _never_called, _no_callback, _no_init_node,
    _wrong_loop, _local_variable, _forgotten_self, _no_publish, _proxy_not_called, _not_started, _never_holds,
    _too_late, _late_lambda, _order_of_a_quaternion, _waits_for_itself)


def found(one: Program) -> List[str]:
    """Return advice on all mistakes in a program, the most likely causes first."""
    return [hint for mistake in KINDS for hint in mistake(one)]


def never_spins(one: Program) -> bool:
    """Return whether a program with callbacks has nothing that keeps it alive."""
    loops = any(isinstance(node, ast.While) for node in one.nodes)
    return any(calls(one.nodes, *WAITING)) and not loops and not any(calls(one.nodes, 'spin'))
