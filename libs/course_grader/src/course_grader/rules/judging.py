"""What counts: each check looks at what was Observed and says which share of it is right, what was asked and seen.

A check is a function (observed, parameters) -> Result, registered with the parameters that an exercise file may give
it. The kinds of parameters: a dimension of quantities.py ('length'), a span of one ('span rate'), 'text', 'pattern'
(a regular expression), 'integer', 'colour' ([r, g, b]), or a tuple of the words that are allowed. ``...`` as default:
it has to be given.
"""
import math
from types import SimpleNamespace
from typing import Callable, NamedTuple

CHECKS = {}  # name: Check
ANY = (-math.inf, math.inf)  # the span that everything lies in
FOULS = {
    'teleport': 'it teleported to ({0:.2f}, {1:.2f}) where the way is to be driven',
    'reset': 'it reset the simulator', 'kill': 'it killed {0}',
    'fake_pose': 'it published poses of its own on {0}', 'fake_clock': 'it published /clock',
}


class Result(NamedTuple):
    """How far one check holds: share 0..1, what was asked, what was seen."""

    share: float
    asked: str
    seen: str


class Check(NamedTuple):
    """A registered check: the function and {parameter: (kind, default)}."""

    judge: Callable
    parameters: dict


def check(**parameters):
    """Register a check under its function's name; see the module's text for ``parameters``."""
    def register(judge):
        CHECKS[judge.__name__] = Check(judge, parameters)
        return judge
    return register


def judge(name, observed, parameters):
    """Return the Result of the check ``name`` with {parameter: value}, all of them."""
    return CHECKS[name].judge(observed, SimpleNamespace(**parameters))


def fouls(observed, allowed):
    """Return the texts of what no node may do, except the kinds that are ``allowed``; each kind once."""
    texts = {}
    for event in observed.events:
        if event.kind in FOULS and event.kind not in allowed:
            texts.setdefault(event.kind, FOULS[event.kind].format(*event.values))
    return list(texts.values())


def within(value, span):
    """Return whether a value lies in a span, with a hair's breadth of rounding."""
    low, high = span
    slack = 1e-6 * max(1.0, abs(value))
    return low - slack <= value <= high + slack


def written(span, unit):
    """Return a span as people write it."""
    low, high = span
    if low == high:
        return f'{low:g} {unit}'
    if math.isinf(high):
        return f'at least {low:g} {unit}'
    return f'at most {high:g} {unit}' if math.isinf(low) else f'{low:g} to {high:g} {unit}'
