"""Check the private parameters of a lesson: ``check_params`` ends the program with the line to type if one is wrong.

A lesson stays plain rospy. It says once which parameters it has, and reads them with rospy.get_param::

    rospy.init_node('stop_at_x')
    check_params(x=number(0.0, 11.0889, 'm'), speed=number(0.05, 10.0, 'm/s'))
    x = rospy.get_param('~x', 10.0)

A program without the second line works, too. With it, a value that is not allowed, an unknown name (``_sped:=2``) and a
missing underscore (``speed:=2``) are errors instead of being ignored, and a parameter of the command line applies to
this run only.
"""
import difflib
import math
import re
import sys
from typing import Any, Callable, Dict, List, NamedTuple

import rosgraph
import rosgraph.names
import rospy

WRONG_PARAMETER = 2  # exit code


class Allowed(NamedTuple):
    """The allowed values of a parameter: a description, an example to type, and a function that checks a value."""

    text: str
    example: str
    accepts: Callable[[Any], bool]
    kind: str = 'text'


def number(low: float = -math.inf, high: float = math.inf, unit: str = '') -> Allowed:
    """Allow a finite number from ``low`` to ``high`` in ``unit``."""
    between = f' from {low:g} to {high:g}' if math.isfinite(high) else ' in' if unit else ''
    return Allowed(f'a number{between} {unit}'.rstrip(), f'{high:g}' if math.isfinite(high) else '1.0',
                   lambda value: _is_number(value) and low <= value <= high, 'float')


def whole(low: int, high: float = math.inf, unit: str = '') -> Allowed:
    """Allow a whole number from ``low`` to ``high`` in ``unit``."""
    upper = f' to {high:g}' if math.isfinite(high) else ''
    return Allowed(f'a whole number from {low}{upper} {unit}'.rstrip(), str(low),
                   lambda value: isinstance(value, int) and not isinstance(value, bool) and low <= value <= high,
                   'int')


def one_of(*choices: str) -> Allowed:
    """Allow one of these words."""
    return Allowed(f'one of {", ".join(choices)}', choices[0], lambda value: value in choices)


def true_or_false() -> Allowed:
    """Allow a bool."""
    return Allowed('true or false', 'true', lambda value: isinstance(value, bool), 'bool')


def ros_name(example: str) -> Allowed:
    """Allow the name of a turtle, or of anything else in ROS."""
    return Allowed(f'a ROS name such as {example}', example, lambda value: isinstance(value, str) and value != ''
                   and not value.startswith('~') and rosgraph.names.is_legal_name(value), 'name')


def list_of(entry: Allowed, example: str, least: int = 1, most: float = math.inf) -> Allowed:
    """Allow a list of ``least`` to ``most`` entries."""
    entries = 'entry' if least == 1 else 'entries'
    count = f'{least} {entries}' if least == most else f'at least {least} {entries}'
    return Allowed(f'a list of {count}, each {entry.text}', f'"{example}"',
                   lambda value: isinstance(value, list) and least <= len(value) <= most
                   and all(entry.accepts(each) for each in value), f'list of {entry.kind}')


def point(low: float = -math.inf, high: float = math.inf) -> Allowed:
    """Allow a pair [x, y] of numbers [m] from ``low`` to ``high``."""
    coordinate = number(low, high, 'm')
    return Allowed(f'a pair [x, y], both {coordinate.text}', '[2.0, 2.0]',
                   lambda value: isinstance(value, list) and len(value) == 2
                   and all(coordinate.accepts(each) for each in value), '[x, y]')


def check_params(**allowed: Allowed) -> None:
    """End the program with exit code 2 and a message unless its private parameters are among ``allowed``.

    Call it after rospy.init_node. Parameters of the command line are deleted from the parameter server when the program
    ends. Parameters that an earlier run has left there cause a warning.
    """
    typed = _typed(sys.argv[1:])
    rospy.on_shutdown(lambda: _forget(typed))
    stored = rospy.get_param(rospy.get_name(), {})
    wrong = _wrong_arguments(allowed)
    wrong += [_unknown(f'parameter {rospy.resolve_name("~" + name)}', name, value, allowed)
              for name, value in typed.items() if name not in allowed]
    wrong += [f'parameter {rospy.resolve_name("~" + name)} is {stored[name]!r}; it must be {rule.text}. '
              f'Type for example _{name}:={rule.example}'
              for name, rule in allowed.items() if name in stored and not rule.accepts(stored[name])]
    for text in wrong:
        rospy.logfatal('%s', text)
    if wrong:
        sys.exit(WRONG_PARAMETER)
    left = sorted(set(stored) - set(typed))
    if left and not any(argument.startswith('__log:=') for argument in sys.argv):  # roslaunch sets __log and parameters
        rospy.logwarn('%s has parameters from an earlier run: %s; rosparam delete %s forgets them', rospy.get_name(),
                      ', '.join(f'{name}={stored[name]}' for name in left), rospy.get_name())


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _typed(arguments: List[str]) -> Dict[str, str]:
    """Return {name: text} of the parameters on a command line, ``_name:=text``."""
    found = (re.fullmatch(r'_([^_:].*?):=(.*)', argument, re.DOTALL) for argument in arguments)
    return {match[1]: match[2] for match in found if match}


def _wrong_arguments(allowed: Dict[str, Allowed]) -> List[str]:
    """Return the errors in the arguments that are neither parameters nor remappings of names."""
    wrong = []
    for argument in sys.argv[1:]:
        name, value = (re.split(':?=', argument, maxsplit=1) + [''])[:2]
        if argument.startswith('_') or ':=' in argument and name not in allowed and _is_name(value):
            continue
        wrong.append(_unknown(f'argument {argument}', name.lstrip('-_'), value, allowed))
    return wrong


def _is_name(text: str) -> bool:
    return bool(rosgraph.names.is_legal_name(text))


def _unknown(what: str, name: str, value: str, allowed: Dict[str, Allowed]) -> str:
    """Return the text for a parameter or an argument that does not exist."""
    near = difflib.get_close_matches(name, allowed, 1, 0.5)
    advice = f'Did you mean _{near[0]}:={value or allowed[near[0]].example}?' if near else ''
    return f'{what}: this program has no such parameter. {advice or "It has " + ", ".join(sorted(allowed)) + "."}'


def _forget(typed: Dict[str, str]) -> None:
    for name in typed:
        try:
            rosgraph.Master(rospy.get_name()).deleteParam(rospy.resolve_name(f'~{name}'))
        except (OSError, rosgraph.MasterException):
            return  # the master has gone, or the parameter
