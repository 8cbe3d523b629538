"""The keys, checks and stimuli of exercise files as tables, for ./run grade --checks and docs/exercise_files.md."""
import textwrap
from typing import Any, Dict, List, NamedTuple, Tuple

from course_grader.rules.exercise import KEYS, ODOMETRY, OF_A_CHECK, OF_A_SYMPTOM, SHIFT, START, STIMULI
from course_grader.rules.judging import ANY, Kind, Parameters
from course_grader.rules.registry import RULES
from course_grader.rules.values import UNITS

SPANS = 'span ', 'drawn '  # beginnings of kinds
WIDTH = 100  # characters of a line in the terminal
HEADINGS = 'parameter', 'kind', 'default', 'meaning'
WORDS = {'integer': 'whole number', 'pattern': 'regular expression', 'boolean': 'true or false',
         'spans': 'list of spans', 'poses': 'list of poses', 'coordinate': 'length of either sign',
         'value': 'number, text, true, false', 'check': 'name of a check', 'points': 'list of points'}


class Entry(NamedTuple):
    """A check or a stimulus: its name, one sentence, and its parameters."""

    name: str
    meaning: str
    parameters: Parameters


def checks() -> List[Entry]:
    """Return all checks."""
    return [Entry(name, (rule.__doc__ or '').split('\n', 1)[0], rule.parameters()) for name, rule in RULES.items()]


def stimuli() -> List[Entry]:
    """Return all stimuli."""
    return [Entry(name, *stimulus) for name, stimulus in STIMULI.items()]


def symptoms() -> List[Entry]:
    """Return the keys of an entry of ``symptoms``."""
    return [Entry('symptom', 'A mistake of a program that lost points: all that is given must hold.', OF_A_SYMPTOM)]


SECTIONS: Dict[str, Tuple[str, List[Entry]]] = {'Checks': ('check', checks()), 'Stimuli': ('stimulus', stimuli()),
                                          'Symptoms': ('entry', symptoms())}


def markdown(section: str) -> str:
    """Return the table of a section of docs/exercise_files.md."""
    heading, entries = SECTIONS[section]
    lines = [f'| {heading} | {" | ".join(HEADINGS)} |', '|---' * (1 + len(HEADINGS)) + '|']
    for entry in entries:
        lines.append(f'| `{entry.name}` | | | | {entry.meaning} |')
        lines += [f'| | `{name}` | {kind} | {default} | {meaning} |'
                  for name, kind, default, meaning in rows(entry.parameters, '`')]
    return '\n'.join(lines) + '\n'


def text() -> str:
    """Return everything for a terminal."""
    parts = ['An exercise file is YAML. These are its keys:', _table(KEYS),
             'start: {...}, and each of robots, may have', _table(START), 'shift: {...} may have', _table(SHIFT),
             'odometry: {...} may have', _table(ODOMETRY),
             'Each entry of checks is {check: NAME, ...} with the parameters of the check and', _table(OF_A_CHECK)]
    for section, (_, entries) in SECTIONS.items():
        parts.append(f'{section.upper()}\n' + '-' * len(section))
        for entry in entries:
            meaning = textwrap.fill(entry.meaning, WIDTH, initial_indent='  ', subsequent_indent='  ')
            parts += [f'{entry.name}\n{meaning}', _table(entry.parameters)]
    return '\n\n'.join(filter(None, parts))


def _table(parameters: Parameters) -> str:
    found = rows(parameters, '')
    widths = [max(len(row[column]) for row in found) for column in range(3)] if found else []
    lines: List[str] = []
    for *cells, meaning in found:
        first = '  ' + '  '.join(cell.ljust(width) for cell, width in zip(cells, widths)) + '  '
        lines += textwrap.wrap(first + meaning, max(WIDTH, len(first) + 40), subsequent_indent=' ' * len(first),
                               drop_whitespace=False, break_on_hyphens=False)
    return '\n'.join(line.rstrip() for line in lines)


def rows(parameters: Parameters, quote: str) -> List[Tuple[str, str, str, str]]:
    """Return (name, kind, default, meaning) of each parameter, in words; ``quote`` encloses a pattern."""
    return [(name, kind_of(parameter.kind), default_of(parameter.kind, parameter.default, quote),
             parameter.meaning.replace('`', quote)) for name, parameter in parameters.items()]


def kind_of(kind: Kind) -> str:
    """Return a kind of judging.py in words."""
    if isinstance(kind, tuple):
        return ', '.join(map(str, kind))
    return f'span of {kind.split(" ", 1)[1]}' if kind.startswith(SPANS) else WORDS.get(kind, kind)


def default_of(kind: Kind, default: Any, quote: str = '') -> str:
    """Return a default in words."""
    if default is ...:
        return 'required'
    if default == ANY:
        return 'any'
    if default is None:
        words = {'coordinate': 'not checked', 'number': 'any', 'value': 'any', 'pattern': 'any', 'check': 'any',
                 'colour': 'any'}
        return 'any' if isinstance(kind, tuple) else words.get(kind, 'the middle')
    if isinstance(default, bool):
        return str(default).lower()
    if kind == 'pattern':
        return f'{quote}{default}{quote}'
    if isinstance(kind, str) and kind.startswith(SPANS):
        low, high = default
        return f'{low:g} to {high:g} {_unit(kind.split(" ", 1)[1])}' if low != high else f'{low:g}'
    if isinstance(default, (list, dict, tuple)):
        return 'none'
    if isinstance(default, float) and kind != 'number':
        unit = _unit(str(kind).replace(' or 0', ''))
        return f'{default * 100:g} %' if unit == '%' else f'{default:g} {unit}'
    return f'{default:g}' if isinstance(default, float) else str(default) or 'empty'


def _unit(dimension: str) -> str:
    """Return the first unit of a dimension, the SI unit."""
    return next(unit for unit, (measured, _) in UNITS.items() if measured == dimension)
