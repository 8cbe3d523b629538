"""Refuse values that make no sense for a robot; every value from outside passes here before it reaches a world."""
import math
import reprlib

LARGEST_MARKER_ID = 2 ** 32 - 1  # of ALVAR, and of AlvarMarker.id, a uint32
ABSURD = 1e6  # [m, m/s, rad or rad/s] far beyond any course, and small enough that float32 and angles stay meaningful


MAX_SHOWN = 200  # [characters] of a value in a text
_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = 80  # [characters]
_SHORT.maxlist = _SHORT.maxtuple = _SHORT.maxdict = 16  # [entries]


class InvalidInput(ValueError):
    """A value was refused, and nothing has changed; the text names the value and the allowed range."""


def shown(value: object) -> str:
    """Return the repr of a value, shortened in the middle if it is long; for the texts of errors."""
    text = _SHORT.repr(value)
    return text if len(text) <= MAX_SHOWN else f'{text[:MAX_SHOWN - 40]} ... {text[-30:]}'


def require_sane(what: str, **values: float) -> None:
    """Raise InvalidInput unless every value is a finite number within +-ABSURD.

    ``what`` says where the values come from, e.g. ``'teleport_absolute of turtle1'``.
    """
    for name, value in values.items():
        if not math.isfinite(value):
            raise InvalidInput(f'{what}: {name} is {value}; it must be a finite number')
        if abs(value) > ABSURD:
            raise InvalidInput(f'{what}: {name} is {value:g}; it must be -{ABSURD:g} to {ABSURD:g}')
