"""Rules: each judges the Observed, and returns which share is right, what was asked, and what was seen.

A rule is a dataclass: its fields are the keys that an entry of ``checks`` may have, ``judge`` returns the Result, and
the first line of its docstring describes it in the documentation. registry.py lists them all.

The kinds of values: a dimension of values.py ('length'), which is above 0; 'time or 0'; 'coordinate', a length of
either sign; a span of a dimension ('span rate'), which has both ends if a value is drawn from it ('drawn length');
'text'; 'name' of a topic or service; 'service type'; 'pattern', a regular expression; 'integer', which is above 0;
'colour', [r, g, b]; 'value', a number, a text, true or false; 'points', a list of [x, y]; or a tuple of the values that
are allowed.
"""
import dataclasses
import math
import statistics
from typing import Any, Container, Dict, List, Mapping, NamedTuple, Sequence, Tuple, Union

from course_grader.rules.observation import Observed
from plain_support.arrays import Floats

Point = Tuple[float, float]  # [m]
Pose = Tuple[float, float, float]  # [m, m, rad]
Colour = Tuple[int, int, int]  # red, green, blue
Span = Tuple[float, float]  # lowest, highest
Kind = Union[str, Tuple[Any, ...]]  # of a parameter's value
ANY = (-math.inf, math.inf)  # the span of all values
SHORTCUTS = {  # kind of event: (what an exercise file says to allow it, the text)
    'teleport': ('teleport', 'the program teleported to ({0:.2f}, {1:.2f}) instead of driving'),
    'teleport_relative': ('teleport', 'the program teleported to ({0:.2f}, {1:.2f}) instead of driving'),
    'reset': ('reset', 'the program reset the simulator'), 'kill': ('kill', 'the program killed {0}'),
    'delete_model': ('', 'the program removed {0} from the world'),
    'spawn_model': ('', 'the program put a model into the world, at ({0:.2f}, {1:.2f})'),
    'fake_result': ('', 'the program published on {0}, in the place of a node of the grader'),
    'fake_pose': ('', 'the program published fake poses on {0}'), 'fake_clock': ('', 'the program published /clock'),
}
PAUSE = 2.0  # times the median period; a longer one is a pause and does not count in a rate
VISIBLE = ALWAYS, LATER, NEVER = 'always', 'after the deadline', 'never'  # when students see a check
MISSED = 0.49  # the highest share of a check that is not fulfilled; a required check then fails the exercise


class Result(NamedTuple):
    """The result of a rule: share 0..1, what was asked, what was seen."""

    share: float
    asked: str
    seen: str


class Parameter(NamedTuple):
    """A key of an exercise file: the kind of its value, its default (``...``: required), and its meaning."""

    kind: Kind
    default: Any
    meaning: str


Parameters = Mapping[str, Parameter]


def key(kind: Kind, default: Any, meaning: str) -> Any:
    """Return the field of a rule for one of its keys; see Parameter."""
    metadata = {'parameter': Parameter(kind, default, meaning)}
    if default is ...:
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


@dataclasses.dataclass(frozen=True)
class Rule:
    """A rule of exercise files, with the values of one of their ``checks``."""

    def judge(self, observed: Observed) -> Result:
        """Return the Result for a program."""
        raise NotImplementedError

    def counted_parts(self, observed: Observed) -> Sequence[Floats]:
        """Return the parts of the path, or points, that count, each of shape (n, 2) [m]."""
        return ()

    @classmethod
    def parameters(cls) -> Parameters:
        """Return the keys of the rule."""
        return {field.name: field.metadata['parameter'] for field in dataclasses.fields(cls)}


def shortcuts(observed: Observed, allowed: Container[str]) -> List[str]:
    """Return a text for each kind of shortcut that was taken and is not ``allowed``."""
    texts: Dict[str, str] = {}
    for event in observed.events:
        permission, text = SHORTCUTS.get(event.kind, ('', ''))
        if text and permission not in allowed:
            texts.setdefault(permission or event.kind, text.format(*event.values))
    return list(texts.values())


def counted(done: float, asked: float) -> float:
    """Return the share for ``done`` of ``asked`` things: 1 for all of them, else less than half."""
    return 1.0 if done >= asked else MISSED * max(done, 0.0) / asked


def within(value: float, span: Span) -> bool:
    """Return whether a value lies in a span, up to rounding errors (1e-6 of the value)."""
    low, high = span
    slack = 1e-6 * max(1.0, abs(value))
    return low - slack <= value <= high + slack


def nearness(value: float, span: Span) -> float:
    """Return 1 inside a span of positive numbers; outside less than half, decreasing with the distance."""
    low, high = span
    if within(value, span):
        return 1.0
    return MISSED * (value / low if value < low else high / value)


def period(times: Sequence[float]) -> float:
    """Return the mean period [s] of periodic times, without pauses; each period is a whole number of ticks."""
    periods = [after - before for before, after in zip(times, times[1:])]
    longest = PAUSE * statistics.median(periods)
    return statistics.mean(period for period in periods if period <= longest)


def written(span: Span, unit: str) -> str:
    """Return a span in words."""
    low, high = span
    if low == high:
        return f'{low:g} {unit}'
    if math.isinf(high):
        return f'at least {low:g} {unit}'
    return f'at most {high:g} {unit}' if math.isinf(low) else f'{low:g} to {high:g} {unit}'
