"""Exercise files: what a student is asked to do, how long it is observed, and what counts. YAML, without ROS.

=============  ==========================================================================================
key            meaning
=============  ==========================================================================================
title          one line
asks           what the student is asked, for the report
simulator      turtlesim (default) or robotont
time           how long the node is observed at most, in simulated time, such as ``40 s``
pass           the score from 0 to 100 that passes, default 80
start          where the turtle or robot starts, drawn by the seed: x, y ``3 to 5 m``, theta ``0 to 90 deg``
allows         kinds of shortcuts that are allowed: teleport, reset, kill
stimuli        what the grader does meanwhile, a list of {do: ..., ...}, see STIMULI
checks         a list of {check: NAME, points: N, must: true|false, ...}; the other keys are the check's parameters
=============  ==========================================================================================

The points of all checks add up to 100. A check that ``must`` hold fails the exercise below half of its share.
"""
import re
import sys
from typing import Any, Dict, List, NamedTuple, Tuple

from course_grader.rules import registry
from course_grader.rules.judging import Kind, Parameters, Span
from course_grader.rules.quantities import UNITS, QuantityError, quantity, span
from kinematic_core import documents
from kinematic_core.validation import shown
from kinematic_core.worlds.turtle_world import ARENA_SIZE

SIMULATORS = ('turtlesim', 'robotont')
LONGEST = 120.0  # [s] of simulated time
ALLOWED = ('teleport', 'reset', 'kill')
START: Parameters = {'x': ('span length', None), 'y': ('span length', None), 'theta': ('span angle', (0.0, 0.0))}
STIMULI: Dict[str, Parameters] = {  # what the grader can do
    'drive': {'after': ('time', 0.0), 'linear': ('span speed', (0.5, 1.5)), 'angular': ('span turn speed', (-0.8, 0.8)),
              'for': ('time', ...)},
    'call': {'service': ('text', ...), 'type': ('text', ...), 'request': ('spans', ...), 'times': ('integer', 3),
             'after': ('time', 0.0)},
    'markers': {'topic': ('text', 'ar_pose_marker'), 'rate': ('rate', 2.0), 'most': ('integer', 3),
                'for': ('time', ...)},
}


class ExerciseError(ValueError):
    """An exercise file is wrong; the text says where, what and what is allowed."""


class ScoredRule(NamedTuple):
    """A rule of an exercise, one of its ``checks``: name, parameters, points, and whether it must hold."""

    name: str
    parameters: Dict[str, Any]
    points: float
    must: bool


class Exercise(NamedTuple):
    """An exercise as its file describes it; times in s, angles in rad, ``start`` as {axis: (low, high)}."""

    name: str
    title: str
    asks: str
    simulator: str
    time: float
    pass_score: float
    start: Dict[str, Span]
    allows: Tuple[str, ...]
    stimuli: List[Tuple[str, Dict[str, Any]]]  # (what, {parameter: value})
    rules: List[ScoredRule]


KEYS: Parameters = {
    'title': ('text', ...), 'asks': ('text', ''), 'simulator': (SIMULATORS, 'turtlesim'), 'time': ('time', ...),
    'pass': ('number', 80.0), 'start': ('mapping', {}), 'allows': ('list', []),
    'stimuli': ('list', []), 'checks': ('list', ...)}


def load(path: documents.Path) -> Exercise:
    """Return the Exercise of a file. Raise ExerciseError, or OSError when it cannot be read."""
    try:
        content = documents.read_yaml(path)
    except documents.DocumentError as error:
        raise ExerciseError(f'{path}: {error}') from None
    name = re.sub(r'\.ya?ml$', '', str(path).rsplit('/', 1)[-1])
    try:
        return parse(content, name)
    except ExerciseError as error:
        raise ExerciseError(f'{path}: {error}') from None


def parse(content: Any, name: str = 'exercise') -> Exercise:
    """Return the Exercise in what a YAML file holds."""
    values = _fields(content, KEYS, 'the exercise')
    if not 0.0 < values['time'] <= LONGEST:
        raise ExerciseError(f'time is {shown(content["time"])}; it must be above 0 and at most {LONGEST:g} s')
    if not 0.0 < values['pass'] <= 100.0:
        raise ExerciseError(f'pass is {values["pass"]:g}; it must be above 0 and at most 100')
    unknown = [kind for kind in values['allows'] if kind not in ALLOWED]
    if unknown:
        raise ExerciseError(f'allows has {shown(unknown[0])}; it may have {", ".join(ALLOWED)}')
    start = {axis: limits for axis, limits in _fields(values['start'], START, 'start').items() if limits is not None}
    for axis in 'xy' if values['simulator'] == 'turtlesim' else '':
        if not 0.0 <= start.get(axis, (0.0,))[0] <= start.get(axis, (0.0,))[-1] <= ARENA_SIZE:
            raise ExerciseError(f'start: {axis} is {values["start"][axis]}; the arena allows 0 to {ARENA_SIZE:.4f} m')
    rules = [_rule(entry, number) for number, entry in enumerate(values['checks'], 1)]
    points = sum(scored.points for scored in rules)
    if abs(points - 100.0) > 1e-6:
        raise ExerciseError(f'the points of the checks add up to {points:g}; they must add up to 100')
    stimuli = [_stimulus(entry, number) for number, entry in enumerate(values['stimuli'], 1)]
    return Exercise(name, values['title'], values['asks'].strip(), values['simulator'], values['time'],
                    values['pass'], start, tuple(values['allows']), stimuli, rules)


def _rule(entry: Any, number: int) -> ScoredRule:
    where = f'check {number}'
    entry = dict(_mapping(entry, where))
    name = entry.pop('check', None)
    if not isinstance(name, str) or name not in registry.RULES:
        raise ExerciseError(f'{where} is {shown(name)}; it must be one of {", ".join(sorted(registry.RULES))}')
    where = f'{where} ({name})'
    common = _fields({key: entry.pop(key) for key in ('points', 'must') if key in entry},
                     {'points': ('number', ...), 'must': ('boolean', False)}, where)
    if common['points'] <= 0.0:
        raise ExerciseError(f'{where}: points is {common["points"]:g}; it must be above 0')
    return ScoredRule(name, _fields(entry, registry.RULES[name].parameters, where), common['points'], common['must'])


def _stimulus(entry: Any, number: int) -> Tuple[str, Dict[str, Any]]:
    where = f'stimulus {number}'
    entry = dict(_mapping(entry, where))
    what = entry.pop('do', None)
    if not isinstance(what, str) or what not in STIMULI:
        raise ExerciseError(f'{where}: do is {shown(what)}; it must be one of {", ".join(STIMULI)}')
    return what, _fields(entry, STIMULI[what], f'{where} ({what})')


def _mapping(value: Any, where: str) -> Dict[Any, Any]:
    if not isinstance(value, dict):
        raise ExerciseError(
            f'{where} is {"empty" if value is None else shown(value)}; it must be a mapping (keys with values)')
    return value


def _fields(entry: Any, kinds: Parameters, where: str) -> Dict[str, Any]:
    """Return {key: value} of all ``kinds``, converted; unknown and missing keys are errors."""
    entry = _mapping(entry, where)
    unknown = [key for key in entry if key not in kinds]
    if unknown:
        raise ExerciseError(f'{where} has an unknown key {shown(unknown[0])}; it may have '
                            f'{", ".join(kinds) or "none"}')
    values = {}
    for key, (kind, default) in kinds.items():
        if key not in entry:
            if default is ...:
                raise ExerciseError(f'{where} lacks the key {key}')
            values[key] = default
            continue
        try:
            values[key] = _convert(entry[key], kind)
        except (QuantityError, re.error, OverflowError, RecursionError) as error:
            raise ExerciseError(f'{where}: {key}: {error}') from None
    return values


PLAIN: Dict[str, Tuple[Any, str]] = {
    'text': (str, 'a text'), 'boolean': (bool, 'true or false'), 'integer': (int, 'a whole number'),
    'number': ((int, float), 'a number'), 'mapping': (dict, 'a mapping (keys with values)'), 'list': (list, 'a list')}


def _convert(value: Any, kind: Kind) -> Any:
    """Return a value of a kind (see judging.py); raise QuantityError."""
    if isinstance(kind, tuple):
        if value not in kind:
            raise QuantityError(f'{shown(value)} must be one of {", ".join(kind)}')
        return value
    if kind in PLAIN:
        types, words = PLAIN[kind]
        if (not isinstance(value, types) or (isinstance(value, bool) and kind != 'boolean')
                or kind in ('number', 'integer') and not abs(value) <= sys.float_info.max):
            raise QuantityError(f'{shown(value)} must be {words}')
        return float(value) if kind == 'number' else value
    if kind == 'pattern':
        return re.compile(_convert(value, 'text')).pattern
    if kind == 'colour':
        if not isinstance(value, list) or len(value) != 3 or not all(type(v) is int and 0 <= v <= 255 for v in value):
            raise QuantityError(f'{shown(value)} must be three whole numbers from 0 to 255, [red, green, blue]')
        return tuple(value)
    if kind == 'spans':
        return [span(entry, _dimension(entry)) for entry in _convert(value, 'list')]
    if kind.startswith('span '):
        return span(value, kind[len('span '):])
    return quantity(value, kind)


def _dimension(text: object) -> str:
    """Return what the unit at the end of a text measures."""
    unit = str(text).split()[-1] if str(text).split() else ''
    if unit not in UNITS:
        raise QuantityError(f'{shown(text)} has no unit at its end; the units are {", ".join(UNITS)}')
    return UNITS[unit][0]
