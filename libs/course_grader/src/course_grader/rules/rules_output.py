"""The rules that look at what a node prints, answers and connects to; see judging.py for their form.

A line counts if it contains the right numbers, whatever the other words. The numbers may be rounded. A whole message,
which rospy prints with one line per field, counts, too.
"""
import itertools
import re
from types import SimpleNamespace
from typing import Iterable, List, NamedTuple, Sequence, Set

from course_grader.rules.judging import Result
from course_grader.rules.observation import Call, Observed, OutputLine, ShownMarkers
from course_grader.rules.quantities import NUMBER

EARLY = 0.1  # [s] a line may seem to come before what it tells of
NEAR = 1.0  # [s] at most between a message and the line that prints it
TOGETHER = 0.1  # [s] at most between the lines of one message
MOST_NUMBERS = 12  # in a line with a pose; more would be guessing
MOST_VALUES = 50  # different numbers per marker, for the same reason: a whole message has about 20


class PrintedNumber(NamedTuple):
    """A number that was printed, and half of its last digit if it has decimals: so far it may be rounded."""

    value: float
    rounded: float

    def is_near(self, value: float, tolerance: float) -> bool:
        """Return whether it tells a value, within a tolerance or as far as its digits go."""
        return abs(self.value - value) <= max(tolerance, self.rounded) + 1e-9


class Statement(NamedTuple):
    """What one line, or several that belong together, tell: when, and the numbers."""

    t: float
    numbers: List[PrintedNumber]


def prints(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It prints lines that match a pattern."""
    count = sum(bool(re.search(wanted.pattern, line.text)) for line in observed.lines)
    asked = f'{wanted.what or repr(wanted.pattern)}, printed {wanted.times} times'
    seen = f'{count} of {len(observed.lines)} lines match' + _example(observed)
    return Result(min(1.0, count / wanted.times), asked, seen)


def prints_poses(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It prints where the turtle is while it moves."""
    names = ('x', 'y', 'theta')[:wanted.fields]
    asked = f'{wanted.lines} lines with the {", ".join(names)} of the turtle; {wanted.share:.0%} of all lines correct'
    numbered = [statement for statement in _statements(observed.lines, wanted.fields)
                if len(statement.numbers) >= wanted.fields]
    right = [statement for statement in numbered if _was_there(observed, statement, names, wanted.tolerance)]
    positions = {tuple(statement.numbers) for statement in right}
    seen = (f'{len(right)} of {len(numbered)} lines with numbers are correct, at {len(positions)} poses'
            + _example(observed))
    if not numbered:
        seen = f'{len(observed.lines)} lines, none with {wanted.fields} numbers' + _example(observed)
        return Result(0.0, asked, seen)
    correct = min(1.0, len(right) / len(numbered) / wanted.share)
    return Result(correct * min(1.0, len(positions) / wanted.lines), asked, seen)


def _statements(lines: Iterable[OutputLine], fields: int) -> List[Statement]:
    """Return the Statements of lines: one each, but lines with fewer numbers than ``fields`` are taken together.

    Lines belong together if they come at the same time, until a label repeats, as in ``x: 1``, ``y: 2``.
    """
    statements: List[Statement] = []
    labels: Set[str] = set()
    for line in lines:
        numbers = numbers_in(line.text)
        label = re.split(NUMBER, line.text)[0].strip()
        if not numbers:
            continue
        again = label in labels if label else bool(statements) and len(statements[-1].numbers) >= fields
        if len(numbers) >= fields or not labels or again or line.t - statements[-1].t > TOGETHER:
            statements.append(Statement(line.t, []))
            labels = set()
        statements[-1].numbers.extend(numbers)
        if len(numbers) < fields:
            labels.add(label)
    return statements


def _was_there(observed: Observed, statement: Statement, names: Sequence[str], tolerance: float) -> bool:
    """Return whether consecutive numbers are those of a pose shortly before they were printed."""
    if len(statement.numbers) > MOST_NUMBERS:
        return False
    near = [sample for sample in observed.track if -NEAR <= sample.t - statement.t <= 0.2 * NEAR]
    windows = [statement.numbers[start:start + len(names)]
               for start in range(len(statement.numbers) - len(names) + 1)]
    return any(all(number.is_near(getattr(sample, name), tolerance) for name, number in zip(names, window))
               for window in windows for sample in near)


def answers(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It offers a service and answers every call of the grader."""
    calls = [call for call in observed.calls if call.service == wanted.service]
    asked = f'{wanted.service} answers'
    asked += ' and prints the numbers of each request' if wanted.prints == 'request' else ''
    if not calls:
        return Result(0.0, asked, 'the program never offered it')
    good = [call for call in calls if call.answered]
    trouble = next((call.trouble for call in calls if not call.answered), '')
    seen = f'{len(good)} of {len(calls)} calls answered' + (f'; {trouble}' if trouble else '')
    if wanted.prints == 'request':
        printed = [call for call in good if _is_printed(observed.lines, call, wanted.tolerance)]
        return Result(0.5 * (len(good) + len(printed)) / len(calls), asked, f'{seen}; {len(printed)} requests printed')
    return Result(len(good) / len(calls), asked, seen)


def _is_printed(lines: Iterable[OutputLine], call: Call, tolerance: float) -> bool:
    """Return whether as many lines in a row as a request has numbers, or fewer, hold them after the call."""
    after = [numbers_in(line.text) for line in lines if line.t >= call.t - EARLY]
    rows = [list(itertools.chain.from_iterable(after[start:start + len(call.request)])) for start in range(len(after))]
    return any(all(any(number.is_near(value, tolerance) for number in numbers) for value in call.request)
               for numbers in rows)


def prints_markers(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It prints a value of each marker that is shown."""
    asked = f'a line with the {wanted.what} of each marker shown'
    expected = found = 0
    lines = [(line.t, numbers_in(line.text)) for line in observed.lines]
    for shown in observed.shown:
        near = {number for t, numbers in lines if -EARLY <= t - shown.t <= NEAR for number in numbers}
        if len(near) > MOST_VALUES * max(1, len(shown.markers)):
            near = set()
        for marker, position in shown.markers.items():
            expected += 1
            found += any(number.value == marker if wanted.what == 'id' else
                         number.is_near(position[0], wanted.tolerance) for number in near)
    seen = f'{found} of {expected}' + _example(observed)
    return Result(found / expected if expected else 0.0, asked, seen)


def prints_no_marker(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It says so when no marker is seen, and only then."""
    matching = [line.t for line in observed.lines if re.search(wanted.pattern, line.text)]
    empty = [shown.t for shown in observed.shown if not shown.markers]
    said = sum(any(-EARLY <= t - start <= NEAR for t in matching) for start in empty)
    wrong = sum(not any(-EARLY <= t - start <= _lasted(start, observed.shown) for start in empty) for t in matching)
    share = said / len(empty) if empty else 0.0
    seen = f'printed {said} of {len(empty)} times' + (f', and {wrong} times with a marker shown' if wrong else '')
    return Result(share * (1.0 if wrong <= 0.1 * len(matching) else 0.5), 'a line when no marker is shown', seen)


def _lasted(start: float, shown: Iterable[ShownMarkers]) -> float:
    """Return for how long [s] what was shown at ``start`` may be told of: until NEAR after the next was shown."""
    return min((later.t for later in shown if later.t > start), default=float('inf')) - start + NEAR


def connects(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It publishes, subscribes to or serves a name."""
    there = (wanted.topic, wanted.role) in observed.connections
    others = sorted(name for name, role in observed.connections if role == wanted.role)
    return Result(float(there), f'the program {wanted.role} {wanted.topic}',
                  'yes' if there else f'the program {wanted.role} {", ".join(others) or "nothing"}')


def runs(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It runs as long as it should."""
    if wanted.until == 'the end':
        seen = 'yes' if observed.exit_code is None else f'it ended after {observed.ended_at:.1f} s with exit code ' \
            f'{observed.exit_code}'
        return Result(float(observed.exit_code is None), 'the program runs until the grader ends it', seen)
    seen = 'it did not end' if observed.exit_code is None else f'exit code {observed.exit_code}'
    return Result(float(observed.exit_code == 0), 'the program ends when it is done', seen)


def numbers_in(text: str) -> List[PrintedNumber]:
    """Return the PrintedNumbers in a text."""
    return [PrintedNumber(float(number), 0.5 * 10.0 ** -len(decimals.group(1)) if decimals else 0.0)
            for number in re.findall(rf'(?<![\w.]){NUMBER}', text)
            for decimals in [re.fullmatch(r'[-+]?\d*\.(\d+)', number)]]


def _example(observed: Observed) -> str:
    return f', for example {observed.lines[-1].text[:80]!r}' if observed.lines else ''
