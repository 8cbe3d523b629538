"""The rules that look at parameters and transforms; see judging.py for their form."""
import bisect
import math
from types import SimpleNamespace
from typing import List

from course_grader.rules.judging import ANY, Result, nearness, period, written
from course_grader.rules.observation import Observed, Transform

NEAR = 0.3  # [s] at most between a transform and the pose that it tells


def parameter(observed: Observed, wanted: SimpleNamespace) -> Result:
    """A parameter is set."""
    asked = f'the parameter {wanted.name} is ' + ('set' if wanted.value is None else f'{wanted.value!r}')
    if wanted.name not in observed.parameters:
        return Result(0.0, asked, 'it is not set')
    value = observed.parameters[wanted.name]
    return Result(float(wanted.value is None or _equal(value, wanted.value)), asked, f'it is {value!r:.80}')


def _equal(value: object, wanted: object) -> bool:
    """Return whether two values are the same: 1 and 1.0 are, 1 and true are not."""
    if isinstance(value, bool) or isinstance(wanted, bool):
        return value is wanted
    if isinstance(value, (int, float)) and isinstance(wanted, (int, float)):
        return math.isclose(value, wanted, rel_tol=1e-6)
    return value == wanted


def transform(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It broadcasts the transform between two frames."""
    parent, child = wanted.parent.lstrip('/'), wanted.child.lstrip('/')
    asked = f'transforms from {parent} to {child}'
    asked += ' at the position of the turtle or robot' if wanted.at == 'the vehicle' else ''
    asked += '' if wanted.rate == ANY else f', {written(wanted.rate, "Hz")}'
    given = [one for one in observed.transforms if (one.parent, one.child) == (parent, child)]
    if not given:
        others = sorted({f'{one.parent} to {one.child}' for one in observed.transforms})
        return Result(0.0, asked, f'only {", ".join(others[:8])}' if others else 'none')
    share, seen = 1.0, f'{len(given)} transforms'
    if wanted.at == 'the vehicle':
        times = [sample.t for sample in observed.track]
        right = sum(_was_there(observed, times, one, wanted.tolerance) for one in given)
        share, seen = right / len(given), f'{seen}, {right} at its position'
    if wanted.rate != ANY:
        rate = 1.0 / max(period([one.t for one in given]), 1e-6) if len(given) > 1 else 0.0
        share, seen = share * (nearness(rate, wanted.rate) if rate else 0.0), f'{seen}, {rate:.1f} Hz'
    return Result(share, asked, seen)


def _was_there(observed: Observed, times: List[float], one: Transform, tolerance: float) -> bool:
    """Return whether the vehicle was at the position of a transform at about that time."""
    near = slice(bisect.bisect_left(times, one.t - NEAR), bisect.bisect_right(times, one.t + NEAR))
    return any(math.hypot(sample.x - one.x, sample.y - one.y) <= tolerance for sample in observed.track[near])
