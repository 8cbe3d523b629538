"""What a rule is: it looks at what was Observed and says which share of it is right, what was asked and seen.

A rule is a function (observed, parameters) -> Result. registry.py lists them all, with the parameters that an exercise
file may give in an entry of ``checks``. The kinds of parameters: a dimension of quantities.py ('length'), which is
above 0; 'time or 0'; 'coordinate', a length of either sign; a span of a dimension ('span rate'); 'text'; 'name' of a
topic or service; 'service type'; 'pattern', a regular expression; 'integer', which is above 0; 'colour', [r, g, b];
'value', a number, a text, true or false; or a tuple of the values that are allowed.
"""
import math
from types import SimpleNamespace
from typing import Any, Callable, Container, Dict, List, Mapping, NamedTuple, Tuple, Union

from course_grader.rules.observation import Observed

Span = Tuple[float, float]  # lowest, highest
Kind = Union[str, Tuple[Any, ...]]  # of a parameter's value
ANY = (-math.inf, math.inf)  # the span that everything lies in
SHORTCUTS = {
    'teleport': 'the program teleported to ({0:.2f}, {1:.2f}) instead of driving',
    'reset': 'the program reset the simulator', 'kill': 'the program killed {0}',
    'fake_pose': 'the program published fake poses on {0}', 'fake_clock': 'the program published /clock',
}


class Result(NamedTuple):
    """How far one rule holds: share 0..1, what was asked, what was seen."""

    share: float
    asked: str
    seen: str


class Parameter(NamedTuple):
    """What an exercise file may set: the kind of its value, its default (``...``: it is required), and its meaning."""

    kind: Kind
    default: Any
    meaning: str


Parameters = Mapping[str, Parameter]
Judge = Callable[[Observed, SimpleNamespace], Result]


class Rule(NamedTuple):
    """A rule as an exercise file names it: the function, whose first sentence says what it looks at, and parameters."""

    judge: Judge
    parameters: Parameters


def shortcuts(observed: Observed, allowed: Container[str]) -> List[str]:
    """Return the texts of what no node may do, except the kinds that are ``allowed``; each kind once."""
    texts: Dict[str, str] = {}
    for event in observed.events:
        if event.kind in SHORTCUTS and event.kind not in allowed:
            texts.setdefault(event.kind, SHORTCUTS[event.kind].format(*event.values))
    return list(texts.values())


def within(value: float, span: Span) -> bool:
    """Return whether a value lies in a span, up to rounding errors (1e-6 of the value)."""
    low, high = span
    slack = 1e-6 * max(1.0, abs(value))
    return low - slack <= value <= high + slack


def nearness(value: float, span: Span) -> float:
    """Return 1 inside a span of positive numbers, outside the quotient of the value and the limit that it breaks."""
    low, high = span
    if within(value, span):
        return 1.0
    return value / low if value < low else high / value


def written(span: Span, unit: str) -> str:
    """Return a span as people write it."""
    low, high = span
    if low == high:
        return f'{low:g} {unit}'
    if math.isinf(high):
        return f'at least {low:g} {unit}'
    return f'at most {high:g} {unit}' if math.isinf(low) else f'{low:g} to {high:g} {unit}'
