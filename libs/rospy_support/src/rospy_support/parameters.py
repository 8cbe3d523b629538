"""Parameters of a node: read in one place, with default, type and range; refused with a text that helps.

Every reader takes the parameter's name, usually private (``'~rate'``), and its default, and raises
ParameterError when the parameter is set to something else than it may be. rospy must be initialised.
"""
import http.client
import math
import xmlrpc.client

import rosgraph
import rospy

_effective = {}  # resolved name -> text of the value, in the order of reading


class ParameterError(ValueError):
    """A parameter has a value that it must not have; the text says which, what is allowed and what to type."""


class MasterAway(ParameterError):
    """A parameter could not be read because no master answers."""


def number(name, default, minimum=-math.inf, maximum=math.inf, unit='', infinite='', clamp=False):
    """Return a parameter as a finite float within [minimum, maximum], in ``unit``; the word ``infinite``: math.inf.

    ``clamp``: a value outside counts as the nearest one inside, with a warning, as dynamic_reconfigure has it.
    """
    def convert(value):
        if infinite and value == infinite:
            return math.inf
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise ValueError
        if minimum <= value <= maximum:
            return float(value)
        if not clamp:
            raise ValueError
        nearest = float(min(max(value, minimum), maximum))
        rospy.logwarn('parameter %s is %g; it can be%s %s and counts as %g', rospy.resolve_name(name), value,
                      _range(minimum, maximum), unit, nearest)
        return nearest
    word = f', or {infinite}' if infinite else ''
    return _read(name, default, convert, f'a number{_range(minimum, maximum)}{word}', unit)


def integer(name, default, minimum=-math.inf, maximum=math.inf, unit='', values=None):
    """Return a parameter as an int within [minimum, maximum], in ``unit``.

    ``values``: {resolved name: value} of the parameters that are set, where they have been read already.
    """
    def convert(value):
        if isinstance(value, float) and value.is_integer():  # rosparam keeps 3.0 as a float
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not minimum <= value <= maximum:
            raise ValueError
        return value
    return _read(name, default, convert, f'a whole number{_range(minimum, maximum)}', unit, values)


def boolean(name, default):
    """Return a parameter as a bool."""
    def convert(value):
        if not isinstance(value, bool):
            raise ValueError
        return value
    return _read(name, default, convert, 'true or false')


def text(name, default, choices=()):
    """Return a parameter as a string, one of ``choices`` where there are any."""
    def convert(value):
        if not isinstance(value, str) or (choices and value not in choices):
            raise ValueError
        return value
    return _read(name, default, convert, 'one of ' + ', '.join(choices) if choices else 'a text')


def numbers(name, default, length=None, unit=''):
    """Return a parameter as a list of finite floats (or of such lists), of ``length`` entries where it is given."""
    def convert(value):
        if not isinstance(value, (list, tuple)) or (length is not None and len(value) != length):
            raise ValueError
        return [convert_entry(entry) for entry in value]

    def convert_entry(entry):
        if isinstance(entry, (list, tuple)):
            return [convert_entry(inner) for inner in entry]
        if isinstance(entry, bool) or not isinstance(entry, (int, float)) or not math.isfinite(entry):
            raise ValueError
        return float(entry)
    return _read(name, default, convert, f'a list of {length if length is not None else "finite"} numbers', unit)


def log_effective():
    """Log one INFO line with every parameter read so far, its value and its unit."""
    rospy.loginfo('Parameters: %s', ', '.join(f'{name}={value}' for name, value in _effective.items()))


def _range(minimum, maximum):
    if math.isinf(minimum) and math.isinf(maximum):
        return ''
    if math.isinf(maximum):
        return f' of at least {minimum:g}'
    if math.isinf(minimum):
        return f' of at most {maximum:g}'
    return f' from {minimum:g} to {maximum:g}'


def _read(name, default, convert, allowed, unit='', values=None):
    resolved = rospy.resolve_name(name)
    try:
        value = rospy.get_param(name, default) if values is None else values.get(resolved, default)
    except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
        raise MasterAway(f'parameter {resolved} cannot be read: the ROS master at {rosgraph.get_master_uri()} does not '
                         f'answer ({error}); start roscore and try again') from None
    try:
        converted = convert(value)
    except ValueError:
        raise ParameterError(f'parameter {resolved} is {value!r}; it must be {allowed}{" " + unit if unit else ""}. '
                             f'Set it with {_typed(name, resolved, default)}') from None
    _effective[resolved] = f'{converted} {unit}'.rstrip()
    return converted


def _typed(name, resolved, default):
    """Return what to type in a shell to set the parameter."""
    value = 'TEXT' if default in (None, '') else str(default)
    if isinstance(default, bool):
        value = value.lower()
    if isinstance(default, (list, tuple)):
        value = f'"{value}"'  # a shell would split it
    command = f'rosparam set {resolved} {value}'
    return f'_{name[1:]}:={value} on the command line or {command}' if name.startswith('~') else command
