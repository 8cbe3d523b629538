"""Parameters of a node: declare them in a table; read them with default, type, range, and errors that say what to type.

A node declares all its parameters in one table; a test compares the documentation of the node with it::

    PARAMETERS = Table(Number('~rate', 10.0, 0.1, 1000.0, 'Hz'), Boolean('~strafe', False))

    def main():
        nodes.init_node('my_node', PARAMETERS)
        rate, strafe = PARAMETERS.read('~rate', '~strafe')

A parameter has a name, usually private (``'~rate'``), a default, and usually a range and a unit. Reading raises
ParameterError if the value is not allowed. rospy must be initialised.

``Table(..., run_only=True)`` declares parameters that are said about one run, such as the rate of a simulator: when a
node of a launch file ends with its launch, it deletes them (see nodes.init_node). The others stay on the master, as
those of every ROS node.
"""
import dataclasses
import difflib
import http.client
import math
import xmlrpc.client
from typing import Any, Container, Dict, Iterable, Iterator, List, Mapping, Optional, Set, Tuple, Union

import rosgraph
import rospy
import yaml

from plain_support.doctor import findings
from rospy_support.master import Master, NoMaster

SIMILAR, MISSPELT = 0.5, 0.8  # similarity of a name to the one that is meant; of one that a launch file has set
HIDDEN = '(hidden)'  # instead of a secret value
_effective: Dict[str, str] = {}  # resolved name -> text of the value, in the order of reading
_declared: Optional[Set[str]] = None  # names that this node may read; None: any, for tests of a part of a node


class ParameterError(ValueError):
    """A parameter has an invalid value; the text names it, the allowed values, and the line to type."""


class MasterAway(ParameterError):
    """A parameter could not be read because no master answers."""


def check_command_line(arguments: Iterable[str]) -> None:
    """Raise ParameterError for a value, as in ``_name:=value``, that no master can store.

    rospy gives such values to the master unchecked, which ends in a traceback, or in a question about the master.
    """
    for argument in arguments:
        name, separator, text = argument.partition(':=')
        if not separator or not name.startswith('_') or name.startswith('__'):
            continue
        try:
            xmlrpc.client.dumps((yaml.safe_load(text.strip()) if text.strip() else '',))
        except yaml.YAMLError as error:
            raise ParameterError(f'{argument} is not valid YAML: {str(error).splitlines()[0]}. For a text, type '
                                 f'{name}:="\'...\'"') from None
        except (OverflowError, TypeError):
            raise ParameterError(f'{argument} is not a value that a parameter can have: allowed are true, false, whole '
                                 'numbers from -2147483648 to 2147483647, numbers with a point, texts, lists and maps. '
                                 f'For a text that looks like something else, type {name}:="\'{text}\'"') from None


class Computed(str):
    """A default that the node computes when it runs; the text describes it in the documentation."""


class Parameter:
    """Base class of all kinds of parameters; their first fields are ``name`` and ``default``.

    ``kind`` is the name of the type in the documentation. ``allowed`` describes valid values in errors, and ``range``
    in the documentation; it is empty where that needs a sentence.
    """

    name: str
    default: Any
    unit = kind = ''
    secret = False  # no log or error shows the value

    @property
    def allowed(self) -> str:
        return ''

    @property
    def range(self) -> str:
        return ''

    def convert(self, value: Any) -> Any:
        """Convert a value of the parameter server to the value for the node; raise ValueError if it is not allowed."""
        raise NotImplementedError

    def read(self, default: Any = None, values: Optional[Mapping[str, Any]] = None) -> Any:
        """Return the parameter's value; ``default`` replaces the table's, and is required if that is Computed.

        ``values`` {resolved name: value} contains the parameters that are set, if the caller has read them already.
        """
        if _declared is not None and self.name not in _declared:
            raise LookupError(f'{self.name} is not in the table of parameters that this node was initialised with')
        default = self.default if default is None else default
        if isinstance(default, Computed):
            raise TypeError(f'the default of {self.name}, {default}, has to be given')
        resolved = rospy.resolve_name(self.name)
        value = _value(self.name, resolved, default) if values is None else values.get(resolved, default)
        unit = f' {self.unit}' if self.unit else ''
        try:
            converted = self.convert(value)
        except ValueError:
            raise ParameterError(f'parameter {resolved} is {self.shown(repr(value))}; it must be {self.allowed}{unit}. '
                                 f'Set it with {_typed(self.name, resolved, default)}') from None
        _effective[resolved] = self.shown(f'{converted}{unit}')
        return converted

    def shown(self, text: str) -> str:
        """Return the text of a value for logs and errors."""
        return HIDDEN if self.secret and text else text


class _Ranged(Parameter):
    """A parameter between a minimum and a maximum."""

    article = ''
    minimum: float
    maximum: float
    infinite: str

    @property
    def allowed(self) -> str:
        word = f', or {self.infinite}' if self.infinite else ''
        return f'{self.article}{_range(self.minimum, self.maximum)}{word}'

    @property
    def range(self) -> str:
        low, high = self.minimum, self.maximum
        if low == -math.inf:
            text = 'finite' if high == math.inf else f'{high:g} or less'
        else:
            text = f'{low:g} or more' if high == math.inf else f'{low:g} to {high:g}'
        return ', '.join(filter(None, (text, self.infinite)))


@dataclasses.dataclass(frozen=True)
class Number(_Ranged):
    """A finite float within [minimum, maximum], in ``unit``; the word ``infinite`` stands for math.inf.

    ``clamp``: replace a value out of range by the nearest limit, with a warning, as dynamic_reconfigure does.
    """

    name: str
    default: 'float | str'  # the word ``infinite``
    minimum: float = -math.inf
    maximum: float = math.inf
    unit: str = ''
    infinite: str = ''
    clamp: bool = False
    kind, article = 'float', 'a number'

    def convert(self, value: Any) -> Any:
        if self.infinite and value == self.infinite:
            return math.inf
        _require_finite(value)
        nearest = float(min(max(value, self.minimum), self.maximum))
        if nearest != value:
            if not self.clamp:
                raise ValueError
            rospy.logwarn('parameter %s is %g; it must be%s %s; using %g', rospy.resolve_name(self.name), value,
                          _range(self.minimum, self.maximum), self.unit, nearest)
        return nearest


@dataclasses.dataclass(frozen=True)
class Integer(_Ranged):
    """An int within [minimum, maximum], in ``unit``."""

    name: str
    default: int
    minimum: float = -math.inf
    maximum: float = math.inf
    unit: str = ''
    kind, article, infinite = 'int', 'a whole number', ''

    def convert(self, value: Any) -> Any:
        if isinstance(value, float) and value.is_integer():  # rosparam keeps 3.0 as a float
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not self.minimum <= value <= self.maximum:
            raise ValueError
        return value


@dataclasses.dataclass(frozen=True)
class Boolean(Parameter):
    """A bool."""

    name: str
    default: 'bool | Computed'
    kind, allowed, range = 'bool', 'true or false', 'true, false'

    def convert(self, value: Any) -> Any:
        if not isinstance(value, bool):
            raise ValueError
        return value


@dataclasses.dataclass(frozen=True)
class Text(Parameter):
    """A string; one of ``choices`` if there are any; ``secret``: no log or error shows it; ``filled``: not empty."""

    name: str
    default: str
    choices: Tuple[str, ...] = ()
    secret: bool = False
    filled: bool = False
    kind = 'text'

    @property
    def allowed(self) -> str:
        if self.choices:
            return f'one of {self.range}'
        return 'a text that is not empty' if self.filled else 'a text'

    @property
    def range(self) -> str:
        return ', '.join(self.choices)

    def convert(self, value: Any) -> Any:
        if not isinstance(value, str) or (self.choices and value not in self.choices) or (self.filled and not value):
            raise ValueError
        return value


@dataclasses.dataclass(frozen=True)
class Numbers(Parameter):
    """A list of finite floats (or of such lists), in ``unit``, with ``length`` entries if that is given."""

    name: str
    default: 'List[Any] | Computed'
    length: Optional[int] = None
    unit: str = ''
    kind = 'list of'

    @property
    def allowed(self) -> str:
        return f'a list of {self.length if self.length is not None else "finite"} numbers'

    def convert(self, value: Any) -> Any:
        if not isinstance(value, (list, tuple)) or (self.length is not None and len(value) != self.length):
            raise ValueError
        return [self._entry(entry) for entry in value]

    def _entry(self, entry: Any) -> Any:
        if isinstance(entry, (list, tuple)):
            return [self._entry(inner) for inner in entry]
        _require_finite(entry)
        return float(entry)


class Table:
    """The parameters of a node: Parameters, and Tables of parameters that it shares with other nodes.

    ``run_only``: all of them are of one run only; those of a part that says so are in any case.
    """

    def __init__(self, *parts: Union[Parameter, 'Table'], run_only: bool = False) -> None:
        self._parameters: Dict[str, Parameter] = {}
        self.run_only: Set[str] = set()  # names of the parameters that are of one run only
        for part in parts:
            self.run_only |= getattr(part, 'run_only', set())
            for parameter in part if isinstance(part, Table) else [part]:
                if parameter.name in self._parameters:
                    raise ValueError(f'{parameter.name} is declared twice')
                self._parameters[parameter.name] = parameter
        if run_only:
            self.run_only |= self._parameters.keys()

    def __iter__(self) -> Iterator[Parameter]:
        return iter(self._parameters.values())

    def __getitem__(self, name: str) -> Parameter:
        return self._parameters[name]

    def read(self, *names: str) -> List[Any]:
        """Return the values of the parameters with these names as a list; without names, of all parameters."""
        return [self._parameters[name].read() for name in names or self._parameters]


def declare(parameters: Iterable[Parameter]) -> None:
    """Let the node read these Parameters (usually a Table) and no others; nodes.init_node calls this."""
    global _declared
    _declared = {parameter.name for parameter in parameters}


def warn_of_stale(parameters: Iterable[Parameter], given: Container[str]) -> None:
    """Warn about private parameters that an earlier run has left: they are set, but are not in ``given``.

    ``given`` holds the resolved names from the command line. Parameters with their default value cause no warning.
    """
    private = [parameter for parameter in parameters if parameter.name.startswith('~')]
    try:
        values = Master().parameters([parameter.name for parameter in private])
    except NoMaster:
        return  # the master does not answer; reading a parameter reports this
    stale = {}
    for parameter in private:
        resolved = rospy.resolve_name(parameter.name)
        if resolved in values and resolved not in given and values[resolved] != parameter.default:
            stale[parameter.name[1:]] = HIDDEN if parameter.secret else values[resolved]
    if stale:
        rospy.logwarn('%s', findings.stale_parameters(rospy.get_name(), stale))


def private() -> Dict[str, Any]:
    """Return {name without ~: value} of what the master has below the name of this node; {} without a master."""
    try:
        (code, _, stored), = Master().request([('getParam', rospy.get_name())])
    except NoMaster:
        return {}
    return stored if code == 1 and isinstance(stored, dict) else {}


def of_launch(parameters: Iterable[Parameter], given: Container[str], stored: Mapping[str, Any]) -> Dict[str, Any]:
    """Return {resolved name: value} of the parameters of one run only that are not on the command line.

    Only a Table has some. ``stored`` as ``private`` returns it. The launch file of this node has set them, or a run
    that was killed has left them, which nobody can tell; so those that are not the default are logged.
    """
    if not isinstance(parameters, Table):
        return {}
    found = {name: stored[name[1:]] for name in parameters.run_only
             if name[1:] in stored and rospy.resolve_name(name) not in given}
    unusual = [f'{name[1:]}={_yaml(stored[name[1:]])}' for name in sorted(found)
               if parameters[name].default != stored[name[1:]] and not parameters[name].secret]
    if unusual:
        rospy.loginfo('Started with %s, because a launch file has set this, or a run that was killed has left it: '
                      'then type rosparam delete %s, and start again.', ', '.join(unusual), rospy.get_name())
    return {rospy.resolve_name(name): value for name, value in found.items()}


def warn_of_unknown(parameters: Iterable[Parameter], given: Container[str], stored: Mapping[str, Any]) -> None:
    """Warn about private parameters that the node does not have: of the command line, and misspelt ones on the master.

    ``given`` holds the resolved names from the command line, ``stored`` is what ``private`` returns. A launch file for
    another node of this kind may set parameters that this one does not have, so of those only names that are nearly
    one of ``parameters`` are told.
    """
    known = [parameter.name[1:] for parameter in parameters if parameter.name.startswith('~')]
    parts = {name.split('/')[0] for name in known}  # of ~a/b, the master has a map named a
    for name in sorted(stored.keys() - parts) if known else ():
        typed = rospy.resolve_name(f'~{name}') in given
        near = difflib.get_close_matches(name, known, 1, SIMILAR if typed else MISSPELT)
        if typed or near:
            rospy.logwarn('parameter %s has no effect: this node has no such parameter. %s',
                          rospy.resolve_name(f'~{name}'),
                          f'Did you mean _{near[0]}?' if near else f'It has {", ".join(sorted(known))}.')


def log_effective() -> None:
    """Log one INFO line with every parameter read so far, its value and its unit."""
    rospy.loginfo('Parameters: %s', ', '.join(f'{name}={value}' for name, value in _effective.items()))


def _range(minimum: float, maximum: float) -> str:
    if math.isinf(minimum) and math.isinf(maximum):
        return ''
    if math.isinf(maximum):
        return f' of at least {minimum:g}'
    if math.isinf(minimum):
        return f' of at most {maximum:g}'
    return f' from {minimum:g} to {maximum:g}'


def _require_finite(value: Any) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise ValueError


def _value(name: str, resolved: str, default: Any) -> Any:
    try:
        return rospy.get_param(name, default)
    except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
        raise MasterAway(f'parameter {resolved} cannot be read: the ROS master at {rosgraph.get_master_uri()} does not '
                         f'answer ({error}); start roscore and try again') from None


def _yaml(value: Any) -> str:
    """Return a value as in YAML."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _typed(name: str, resolved: str, default: Any) -> str:
    """Return how to set the parameter: on the command line of the node, or with rosparam."""
    value = 'TEXT' if default in (None, '') else _yaml(default)
    if isinstance(default, (list, tuple)):
        value = f'"{value}"'  # quoted for the shell
    command = f'rosparam set {resolved} {value}'
    return f'_{name[1:]}:={value} on the command line or {command}' if name.startswith('~') else command
