"""What a node reads and registers, found in its source: the parameters, topics and services of a script.

From the script's main() on, every call of a function or class of this repository is followed with the arguments that
it is given, as far as these are known without running it.
"""
import ast
import importlib.machinery
import importlib.util
import inspect
import pathlib
import sys
import textwrap
from collections.abc import Hashable
from typing import NamedTuple

import rospy

from rospy_support import parameters
from rospy_support.topics import LatestPublisher, Publisher

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
UNKNOWN = object()  # a value that only running the node would tell
TURTLE = 'turtle1'  # stands for a turtle's name where it is unknown
READERS = {parameters.number: 'float', parameters.integer: 'int', parameters.boolean: 'bool', parameters.text: 'text',
           parameters.numbers: 'list of'}
KINDS = {**dict.fromkeys((rospy.Publisher, Publisher, LatestPublisher), 'publishes'), rospy.Subscriber: 'subscribes',
         rospy.Service: 'serves', rospy.ServiceProxy: 'calls'}


class Parameter(NamedTuple):
    type: str
    unit: str
    default: object
    minimum: float
    maximum: float
    choices: tuple
    infinite: str  # the word for a number without end, or nothing


class Walk(ast.NodeVisitor):
    """One function or class with the values bound to its names; what it leads to goes into a Node."""

    def __init__(self, node, scope, bound):
        self.node, self.scope, self.bound = node, scope, bound

    def value(self, expression):
        """Return the value of an expression, or UNKNOWN."""
        if isinstance(expression, ast.JoinedStr):
            parts = [part.value if isinstance(part, ast.Constant) else self.value(part.value)
                     for part in expression.values]
            return ''.join(TURTLE if part is UNKNOWN else str(part) for part in parts)
        if isinstance(expression, ast.Call):
            function, arguments = self.value(expression.func), [self.value(entry) for entry in expression.args]
            if function is zip and UNKNOWN not in arguments:
                return list(zip(*arguments))
            return '/'.join(arguments) if getattr(function, '__name__', '') == 'topic_below' else UNKNOWN
        if any(isinstance(part, (ast.Call, ast.Lambda)) for part in ast.walk(expression)):
            return UNKNOWN
        try:
            return eval(compile(ast.Expression(expression), '', 'eval'), self.scope, self.bound)
        except Exception:
            return UNKNOWN

    def visit_Call(self, call):
        function = self.value(call.func)
        positional = [self.value(argument) for argument in call.args]
        named = {keyword.arg: self.value(keyword.value) for keyword in call.keywords if keyword.arg}
        if isinstance(function, Hashable) and function in READERS:
            self.node.read(function, positional, named)
        elif isinstance(function, Hashable) and function in KINDS:
            self.node.register(KINDS[function], *positional[:2])
        elif function is UNKNOWN and len(positional) > 1 and hasattr(positional[1], '_request_class'):
            self.node.register('serves', *positional[:2])  # FrameServices.add of an object that is made while running
        else:
            self.node.follow(function, positional, named)
        self.visit(call.func)
        for part in (*call.args, *(keyword.value for keyword in call.keywords)):
            self.visit(part)
            if not isinstance(part, ast.Call):
                self.node.follow(self.value(part), [], {})  # a callback

    def visit_Assign(self, assignment):
        self.visit(assignment.value)
        target, value = assignment.targets[0], self.value(assignment.value)
        if isinstance(target, ast.Name) and value is not UNKNOWN:
            self.bound.setdefault(target.id, value)

    def visit_For(self, loop):
        self._each(loop.target, loop.iter, loop.body)

    def visit_GeneratorExp(self, comprehension):
        first = comprehension.generators[0]
        self._each(first.target, first.iter, [comprehension.elt])

    visit_ListComp = visit_SetComp = visit_GeneratorExp

    def _each(self, target, entries, body):
        self.visit(entries)
        names = [name.id for name in ast.walk(target) if isinstance(name, ast.Name)]
        for entry in self._entries(entries):
            values = list(entry) if isinstance(entry, (list, tuple)) and len(names) > 1 else [entry]
            inner = Walk(self.node, self.scope, {**self.bound, **dict(zip(names, values))})
            for part in body:
                inner.visit(part)

    def _entries(self, expression):
        if isinstance(expression, (ast.Tuple, ast.List)):
            return [[self.value(part) for part in entry.elts] if isinstance(entry, (ast.Tuple, ast.List))
                    else self.value(entry) for entry in expression.elts]
        value = self.value(expression)
        return value if isinstance(value, (list, tuple)) else [UNKNOWN]


class Node:
    """What a script leads to: ``parameters`` {name: Parameter} and ``names`` {(name, kind, type)}."""

    def __init__(self, script):
        self.parameters, self.names, self._followed = {}, set(), set()
        self._folders = {REPOSITORY, script.parent}
        loader = importlib.machinery.SourceFileLoader(f'script_{script.stem}', str(script))
        module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
        sys.modules[loader.name] = module  # where inspect looks for a class's source
        loader.exec_module(module)
        self.follow(module.main, [], {})

    def read(self, reader, positional, named):
        values = inspect.signature(reader).bind(*positional, **named)
        values.apply_defaults()
        given = {'minimum': None, 'maximum': None, 'choices': (), 'unit': '', 'infinite': '', **values.arguments}
        self.parameters[given['name']] = Parameter(READERS[reader], given['unit'], given['default'], given['minimum'],
                                                   given['maximum'], tuple(given['choices']), given['infinite'])

    def register(self, kind, name, data_type):
        if name is not UNKNOWN:
            self.names.add((name, kind, getattr(data_type, '_type', '?')))

    def follow(self, target, positional, named):
        """Walk through a function or class if it is one of this repository."""
        if not inspect.isroutine(target) and not inspect.isclass(target) or not self._is_ours(target):
            return
        key = (target, repr(positional), repr(sorted(named.items())))
        if key in self._followed:
            return
        self._followed.add(key)
        scope = vars(sys.modules[target.__module__]) if inspect.isclass(target) else target.__globals__
        tree = ast.parse(textwrap.dedent(inspect.getsource(target))).body[0]
        if inspect.isclass(target):
            for base in target.__bases__:
                self.follow(base, [], {})
            for part in tree.body:
                first = getattr(part, 'name', '') == '__init__'
                Walk(self, scope, bind(part, [UNKNOWN, *positional], named) if first else {}).generic_visit(part)
        else:
            Walk(self, scope, bind(tree, positional, named)).generic_visit(tree)

    def _is_ours(self, target):
        if getattr(target, '__module__', None) in (None, parameters.__name__) or not (
                inspect.isclass(target) or hasattr(target, '__globals__')):
            return False
        try:
            inspect.getsource(target)
            return bool(self._folders & set(pathlib.Path(inspect.getsourcefile(target)).resolve().parents))
        except (OSError, TypeError):  # built in, or made while running
            return False


def bind(tree, positional, named):
    """Return {name: value} of a function's arguments, without the unknown ones."""
    names = [argument.arg for argument in tree.args.args]
    defaults = {name: value.value for name, value in zip(names[::-1], tree.args.defaults[::-1])
                if isinstance(value, ast.Constant)}
    given = {**defaults, **dict(zip(names, positional)), **named}
    return {name: value for name, value in given.items() if value is not UNKNOWN}
