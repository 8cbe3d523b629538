"""Numbers with units, as exercise files have them: ``40 s``, ``0.5 m/s``, ``90 deg``, ``5 %``."""
import math
import re
from typing import Tuple

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
    """Return the same for a span from which a value is drawn, so that it has both ends."""
    found = span(text, dimension)
    if math.isinf(found[0]) or math.isinf(found[1]):
        raise QuantityError(f'{shown(text)} has no end, and a value is drawn from it; write it like '
                            f'"3 to 5 {units_of(dimension).split(",")[0]}"')
    return found
