"""Values of exercise files: numbers with units, such as ``40 s``, ``0.5 m/s``, ``90 deg`` or ``5 %``, and others."""
import difflib
import math
import re
import sys
from typing import Any, Callable, Dict, Iterable, Tuple

from course_grader.rules.judging import Kind
from plain_support import shown

UNITS = {  # unit: (dimension, factor to the SI unit)
    's': ('time', 1.0), 'ms': ('time', 1e-3), 'min': ('time', 60.0),
    'm': ('length', 1.0), 'cm': ('length', 1e-2), 'mm': ('length', 1e-3),
    'rad': ('angle', 1.0), 'deg': ('angle', math.pi / 180.0),
    'm/s': ('speed', 1.0), 'cm/s': ('speed', 1e-2),
    'rad/s': ('turn speed', 1.0), 'deg/s': ('turn speed', math.pi / 180.0),
    'Hz': ('rate', 1.0),
    'px': ('pixels', 1.0),
    '%': ('share', 1e-2),
}
NUMBER = r'[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?'
UNIT = r'[^\s\d.+-]\S*'


class QuantityError(ValueError):
    """A text is not a number with the right unit; the error says what is allowed."""


def units_of(dimension: str) -> str:
    """Return the units that measure a dimension, as a text."""
    return ', '.join(unit for unit, (measured, _) in UNITS.items() if measured == dimension)


def quantity(text: object, dimension: str) -> float:
    """Return a text such as ``'90 deg'`` as a float in the SI unit of ``dimension`` (a share: 0..1).

    Raise QuantityError. A number without a unit is ambiguous and refused, except 0.
    """
    if text == 0 and not isinstance(text, bool):
        return 0.0
    match = re.fullmatch(rf'\s*({NUMBER})\s*({UNIT})\s*', text) if isinstance(text, str) else None
    allowed = f'a number with one of the units {units_of(dimension)}, such as "2 {units_of(dimension).split(",")[0]}"'
    if match is None:
        raise QuantityError(f'{shown(text)} is not {allowed}')
    unit = match.group(2)
    if UNITS.get(unit, ('',))[0] != dimension:
        raise QuantityError(f'the unit {shown(unit)} in {shown(text)} does not measure a {dimension}; it must be '
                            f'{allowed}')
    value = float(match.group(1)) * UNITS[unit][1]
    if math.isinf(value):
        raise QuantityError(f'{shown(text)} is too large')
    return value


def span(text: object, dimension: str) -> Tuple[float, float]:
    """Return a text such as ``'9 to 11 Hz'``, ``'at least 0.1 m/s'``, ``'at most 2 s'`` or ``'2 s'`` as (low, high)."""
    text = text.strip() if isinstance(text, str) else text
    between = re.fullmatch(rf'({NUMBER})\s+to\s+({NUMBER})\s*({UNIT})', text) if isinstance(text, str) else None
    if between:
        low, high = (quantity(f'{between.group(end)} {between.group(3)}', dimension) for end in (1, 2))
        if low > high:
            raise QuantityError(f'{shown(text)} starts above its end; write it like "9 to 11 Hz"')
        return low, high
    if isinstance(text, str) and text.startswith('at least '):
        return quantity(text[len('at least '):], dimension), math.inf
    if isinstance(text, str) and text.startswith('at most '):
        return -math.inf, quantity(text[len('at most '):], dimension)
    exact = quantity(text, dimension)
    return exact, exact


def bounded(text: object, dimension: str) -> Tuple[float, float]:
    """Return a span() from which a value is drawn, so that it has both ends. Raise QuantityError."""
    found = span(text, dimension)
    if math.isinf(found[0]) or math.isinf(found[1]):
        raise QuantityError(f'{shown(text)} has no end, and a value is drawn from it; write it like '
                            f'"3 to 5 {units_of(dimension).split(",")[0]}"')
    return found


def meant(word: Any, allowed: Iterable[str]) -> str:
    """Return '. Did you mean WORD?' or ''."""
    close = difflib.get_close_matches(word, list(allowed), 1) if isinstance(word, str) else []
    return f'. Did you mean {close[0]}?' if close else ''


PLAIN: Dict[str, Tuple[Any, str]] = {
    'text': (str, 'a text'), 'boolean': (bool, 'true or false'), 'integer': (int, 'a whole number'),
    'number': ((int, float), 'a number'), 'mapping': (dict, 'a mapping (keys with values)'), 'list': (list, 'a list')}
PATTERNS = {'name': (r'(/[A-Za-z]\w*)+', 'a full name, such as /turtle1/pose'),
            'service type': (r'[A-Za-z]\w*/[A-Za-z]\w*', 'a type, such as turtlesim/TeleportAbsolute')}


def convert(value: Any, kind: Kind) -> Any:
    """Return a value of a kind (see judging.py). Raise QuantityError, or re.error for a pattern."""
    if isinstance(kind, tuple):
        found = [allowed for allowed in kind if type(allowed) is type(value) and allowed == value]
        if not found:
            words = [str(allowed) for allowed in kind]
            raise QuantityError(f'{shown(value)} must be one of {", ".join(words)}{meant(value, words)}')
        return found[0]
    if kind in PLAIN:
        return _plain(value, kind)
    if kind in PATTERNS:
        pattern, meaning = PATTERNS[kind]
        if not isinstance(value, str) or not re.fullmatch(pattern, value, re.ASCII):
            raise QuantityError(f'{shown(value)} must be {meaning}')
        return value
    if kind in OTHERS:
        return OTHERS[kind](value)
    if kind.startswith('span '):
        return span(value, kind[len('span '):])
    if kind.startswith('drawn '):
        return bounded(value, kind[len('drawn '):])
    return _above(value, quantity(value, kind.replace(' or 0', '')), kind)


def _above(value: Any, number: float, kind: str) -> float:
    """Return a number that is above 0, or 0 where its kind allows that; of a share at most 1."""
    if number < 0.0 or (number == 0.0 and not kind.endswith(' or 0')):
        raise QuantityError(f'{shown(value)} must be {"at least" if kind.endswith(" or 0") else "above"} 0')
    if number > (1.0 if kind == 'share' else math.inf):
        raise QuantityError(f'{shown(value)} must be at most 100 %')
    return number


def _plain(value: Any, kind: str) -> Any:
    types, words = PLAIN[kind]
    if (not isinstance(value, types) or (isinstance(value, bool) and kind != 'boolean')
            or kind in ('number', 'integer') and not abs(value) <= sys.float_info.max):
        raise QuantityError(f'{shown(value)} must be {words}')
    if kind == 'integer':
        return int(_above(value, value, kind))
    return float(value) if kind == 'number' else value


def _dimension(text: object) -> str:
    """Return the dimension of the unit at the end of a text."""
    unit = str(text).split()[-1] if str(text).split() else ''
    if unit not in UNITS:
        raise QuantityError(f'{shown(text)} has no unit at its end; the units are {", ".join(UNITS)}')
    return UNITS[unit][0]


def _colour(value: Any) -> Tuple[int, ...]:
    if not isinstance(value, list) or len(value) != 3 or not all(type(v) is int and 0 <= v <= 255 for v in value):
        raise QuantityError(f'{shown(value)} must be three whole numbers from 0 to 255, [red, green, blue]')
    return tuple(value)


def _point(value: Any) -> Tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise QuantityError(f'{shown(value)} must be a point with x and y, such as [2 m, 3 m]')
    return quantity(value[0], 'length'), quantity(value[1], 'length')


def _pose(value: Any) -> Tuple[float, ...]:
    if not isinstance(value, list) or len(value) != 3:
        raise QuantityError(f'{shown(value)} must be [x, y, heading], such as [-2 m, 0.5 m, 90 deg]')
    return tuple(quantity(part, dimension) for part, dimension in zip(value, ('length', 'length', 'angle')))


def _value(value: Any) -> Any:
    if not isinstance(value, (str, bool, int, float)) or value != value:
        raise QuantityError(f'{shown(value)} must be a number, a text, true or false')
    return value


OTHERS: Dict[str, Callable[[Any], Any]] = {
    'value': _value,
    'pattern': lambda value: re.compile(_plain(value, 'text')).pattern,
    'colour': _colour,
    'pose': _pose,
    'poses': lambda value: [_pose(entry) for entry in _plain(value, 'list')],
    'spans': lambda value: [span(entry, _dimension(entry)) for entry in _plain(value, 'list')],
    'coordinate': lambda value: quantity(value, 'length'),
    'points': lambda value: [_point(entry) for entry in _plain(value, 'list')]}
