"""The rules about printed lines, answers and connections; see judging.py for their form.

A line counts if it contains the right numbers, whatever its words. The numbers may be rounded, and may have a decimal
comma. Labels (``y: 2 x: 1``) or the heading of a table tell which number is which; without them the order does. A whole
message, which rospy prints with one line per field, counts, too.
"""
import collections
import dataclasses
import functools
import itertools
import math
import re
from types import SimpleNamespace
from typing import Dict, Iterable, List, NamedTuple, Sequence, Set, Tuple

from course_grader.rules.judging import Judge, Result, counted
from course_grader.rules.observation import Call, Goal, Observed, OutputLine, computed
from course_grader.rules.quantities import NUMBER

MAX_EARLY = 0.1  # [s] by which a line may seem to precede its event
LEVELS = 'DEBUG', 'INFO', 'WARN', 'ERROR', 'FATAL'  # of log messages, as rospy prints them
MAX_LATE = 1.0  # [s] by which a line may follow the first message with its numbers, unless that is shown longer
MAX_WRONG = 2  # lines with what does not belong there: a value at the limit may be rounded
MAX_GAP = 0.1  # [s] at most between the lines of one message
MAX_NUMBERS = 12  # in a line with a pose; a line with more is a guess
MAX_MARKER_NUMBERS = 30  # numbers in a line with markers, for the same reason
MIN_RIGHT = 0.4  # share of the values at one place of a line that must be right: a message has two x
MIN_PRINTED = 0.85  # share of the markers that must be printed: one or two lines may be lost
LABEL = r'(?i)(?<![a-z])(x|y|theta)(?![a-z])'
DECIMAL_COMMA = re.compile(r'(?<=\d),(?=\d)')


class PrintedNumber(NamedTuple):
    """A printed number, its rounding (half of its last decimal), and its label.

    ``label``: x, y or theta, if it is the only word between the previous number and this one; otherwise ''.
    """

    value: float
    rounded: float
    label: str = ''

    def is_near(self, value: float, tolerance: float) -> bool:
        """Return whether it equals a value, within a tolerance or its rounding."""
        return abs(self.value - value) <= max(tolerance, self.rounded) + 1e-9


class Statement(NamedTuple):
    """The numbers of one line, or of several that belong together, and their time."""

    t: float
    numbers: List[PrintedNumber]


def _with_decimal_comma(judge: Judge) -> Judge:
    """Return a rule that also reads ``1,5`` as 1.5 in lines without a decimal point, if that improves the result."""
    @functools.wraps(judge)
    def both(observed: Observed, wanted: SimpleNamespace) -> Result:
        lines = [line if re.search(r'\d\.\d', line.text) else line._replace(text=DECIMAL_COMMA.sub('.', line.text))
                 for line in observed.lines]
        results = [judge(observed, wanted)]
        if lines != observed.lines:
            results.append(judge(dataclasses.replace(observed, lines=lines), wanted))
        return max(results, key=lambda result: result.share)
    return both


def prints(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It prints lines that match a pattern."""
    count = matching(observed, wanted)
    asked = f'{wanted.what or repr(wanted.pattern)}, printed {wanted.times} times'
    seen = f'{count} of {len(observed.lines)} lines match' + _example(observed)
    if wanted.without is not None:
        wrong = [line.text for line in observed.lines
                 if wanted.level in (None, line.level) and re.search(wanted.without, line.text)]
        if len(wrong) > MAX_WRONG:
            return Result(0.0, asked, f'{seen}; {len(wrong)} others do not belong there, such as {wrong[0]!r:.60}')
    return Result(min(1.0, count / wanted.times), asked, seen)


def matching(observed: Observed, wanted: SimpleNamespace) -> int:
    """Return the number of lines that match a pattern."""
    return sum(bool(re.search(wanted.pattern, line.text)) and wanted.level in (None, line.level)
               for line in observed.lines)


@_with_decimal_comma
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


def poses_are(observed: Observed, names: Sequence[str], tolerance: float) -> float:
    """Return the share of the lines with numbers that contain these values of the turtle's pose, in this order."""
    numbered = [statement for statement in _statements(observed.lines, len(names))
                if len(statement.numbers) >= len(names)]
    return sum(_was_there(observed, statement, names, tolerance) for statement in numbered) / max(1, len(numbered))


def _statements(lines: Iterable[OutputLine], fields: int) -> List[Statement]:
    """Group lines into Statements: one per line, but lines with fewer numbers than ``fields`` are joined.

    Lines belong together if they come at the same time, until a label repeats, as in ``x: 1``, ``y: 2``.
    """
    statements: List[Statement] = []
    labels: Set[str] = set()
    columns: List[str] = []
    for line in lines:
        numbers = numbers_in(line.text)
        columns = columns if numbers else _heading(line.text) or columns
        if len(numbers) == len(columns):
            numbers = [number._replace(label=label) for number, label in zip(numbers, columns)]
        label = re.split(NUMBER, line.text)[0].strip()
        if not numbers:
            continue
        again = label in labels if label else bool(statements) and len(statements[-1].numbers) >= fields
        if len(numbers) >= fields or not labels or again or line.t - statements[-1].t > MAX_GAP:
            statements.append(Statement(line.t, []))
            labels = set()
        statements[-1].numbers.extend(numbers)
        if len(numbers) < fields:
            labels.add(label)
    return statements


def _heading(text: str) -> List[str]:
    """Return the column labels of a table's heading, such as ``y | x | speed``; [] if a line is not a heading."""
    words = re.findall(r'[^\W\d]+', text.lower())
    return words if {'x', 'y'} <= set(words) else []


def _was_there(observed: Observed, statement: Statement, names: Sequence[str], tolerance: float) -> bool:
    """Return whether numbers with the labels, or else consecutive ones, are a pose shortly before they were printed."""
    if len(statement.numbers) > MAX_NUMBERS:
        return False
    near = [sample for sample in observed.track if -MAX_LATE <= sample.t - statement.t <= 0.2 * MAX_LATE]
    labelled = [[number for number in statement.numbers if number.label == name] for name in names]
    windows = list(itertools.product(*labelled)) or [
        tuple(statement.numbers[start:start + len(names)]) for start in range(len(statement.numbers) - len(names) + 1)]
    return any(all(number.is_near(getattr(sample, name), tolerance) for name, number in zip(names, window))
               for window in windows for sample in near)


@_with_decimal_comma
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
        share = counted(0.5 * (len(good) + len(printed)), len(calls))
        return Result(share, asked, f'{seen}; {len(printed)} requests printed')
    return Result(counted(len(good), len(calls)), asked, seen)


def reaches(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It serves the action Fibonacci: results, feedback on the way, and goals that are cancelled."""
    goals = [goal for goal in observed.goals if goal.action == wanted.action]
    asked = f'{wanted.action} reaches its goals, with feedback, and ends one that is cancelled'
    if not goals:
        return Result(0.0, asked, 'the program never offered it')
    wrong = [text for text in map(_missed, goals) if text]
    right = len(goals) - len(wrong)
    if not any(goal.cancelled for goal in goals):  # the last one
        wrong.append('the time was over before the last goal: are two numbers added per second?')
    seen = f'{right} of {right + len(wrong)} goals' + (f'; {wrong[0]}' if wrong else '')
    return Result(counted(right, right + len(wrong)), asked, seen)


def _missed(goal: Goal) -> str:
    """Return what is wrong with the result of a goal, or ''."""
    if goal.cancelled:
        return '' if goal.state == 'PREEMPTED' else f'the cancelled goal is {goal.state}, not PREEMPTED'
    if goal.state != 'SUCCEEDED':
        return f'the goal of order {goal.order} is {goal.state}'
    numbers = [0, 1]
    while len(numbers) <= goal.order:
        numbers.append(numbers[-1] + numbers[-2])
    if list(goal.result) != numbers:
        return f'the result of order {goal.order} is {str(list(goal.result)):.80}, expected {numbers}'
    least = computed(goal.order)
    return '' if goal.feedback >= least else f'{goal.feedback} messages of feedback for {least} numbers'


def _is_printed(lines: Iterable[OutputLine], call: Call, tolerance: float) -> bool:
    """Return whether a few consecutive lines after the call contain all numbers of a request."""
    after = [numbers_in(line.text) for line in lines if line.t >= call.t - MAX_EARLY]
    rows = [list(itertools.chain.from_iterable(after[start:start + len(call.request)])) for start in range(len(after))]
    return any(all(any(number.is_near(value, tolerance) for number in numbers) for value in call.request)
               for numbers in rows)


@_with_decimal_comma
def prints_markers(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It prints a value of each marker that is shown.

    Only places of its lines with often the right value count, because a program that prints all numbers identifies no
    marker.
    """
    told: Dict[Tuple[str, int], List[Set[Tuple[int, int]]]] = collections.defaultdict(list)
    ends = [shown.t for shown in observed.shown[1:]] + [0.0]
    for number, (shown, end) in enumerate(zip(observed.shown, ends)):
        late = max(MAX_LATE, end - shown.t)
        near = [line.text for line in observed.lines if shown.markers and -MAX_EARLY <= line.t - shown.t <= late]
        for text in near:
            numbers, words = numbers_in(text), re.sub(NUMBER, '#', text)
            for place, printed in enumerate(numbers if len(numbers) <= MAX_MARKER_NUMBERS else ()):
                told[words, place].append({
                    (number, marker) for marker, position in shown.markers.items()
                    if (printed.value == marker if wanted.what == 'id' else
                        printed.is_near(position[0], wanted.tolerance))})
    found = {each for values in told.values() if sum(map(bool, values)) >= MIN_RIGHT * len(values)
             for one in values for each in one}
    expected = sum(len(shown.markers) for shown in observed.shown)
    share = counted(len(found), MIN_PRINTED * expected) if expected else 0.0
    return Result(share, f'a line with the {wanted.what} of each marker shown',
                  f'{len(found)} of {expected}' + _example(observed))


def prints_no_marker(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It says so when no marker is seen, and only then."""
    matching = [line.t for line in observed.lines if re.search(wanted.pattern, line.text)]
    ends = [shown.t - MAX_EARLY for shown in observed.shown[1:]] + [math.inf]
    shows = {kind: [(shown.t, end) for shown, end in zip(observed.shown, ends) if bool(shown.markers) == kind]
             for kind in (False, True)}
    said = sum(any(start - MAX_EARLY <= t < end for t in matching) for start, end in shows[False])
    wrong = sum(any(start < t < end for t in matching) for start, end in shows[True])
    share = said / len(shows[False]) if shows[False] else 0.0
    seen = f'printed {said} of {len(shows[False])} times' + (
        f', and {wrong} of {len(shows[True])} times with a marker shown' if wrong else '')
    share *= 1.0 - wrong / max(1, len(shows[True]))
    return Result(share, 'a line when no marker is shown, and only then', seen)


def connects(observed: Observed, wanted: SimpleNamespace) -> Result:
    """It publishes, subscribes to or serves a name."""
    there = (wanted.topic, wanted.role) in observed.connections
    others = sorted(name for name, role in observed.connections if role == wanted.role)
    does = 'subscribes to' if wanted.role == 'subscribes' else wanted.role
    asked = f'the program {does} {wanted.topic}' + (f', of the type {wanted.type}' if wanted.type else '')
    if there and wanted.type and observed.types.get(wanted.topic, '').rpartition('/')[2] != wanted.type:
        return Result(0.0, asked, f'its type is {observed.types.get(wanted.topic, "unknown")}')
    return Result(float(there), asked, 'yes' if there else f'the program {does} {", ".join(others) or "nothing"}')


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
    found, end = [], 0
    for match in re.finditer(rf'(?<![\w.]){NUMBER}', text):
        labels = {label.lower() for label in re.findall(LABEL, text[end:match.start()])}
        decimals = re.fullmatch(r'[-+]?\d*\.(\d+)', match[0])
        found.append(PrintedNumber(float(match[0]), 0.5 * 10.0 ** -len(decimals[1]) if decimals else 0.0,
                                   labels.pop() if len(labels) == 1 else ''))
        end = match.end()
    return found


def _example(observed: Observed) -> str:
    return f', for example {observed.lines[-1].text[:80]!r}' if observed.lines else ''
