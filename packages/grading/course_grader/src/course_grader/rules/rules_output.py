"""The rules about printed lines, answers and connections; judging.py says what a rule is.

A line counts if it contains the right numbers, whatever its words. The numbers may be rounded, and may have a decimal
comma. Labels (``y: 2 x: 1``) or the heading of a table tell which number is which; without them the order does. A whole
message, which rospy prints with one line per field, counts, too.
"""
import collections
import functools
import itertools
import math
import re
from dataclasses import dataclass, replace
from typing import Any, Callable, Dict, Iterable, List, NamedTuple, Optional, Sequence, Set, Tuple

from course_grader.rules.judging import Result, Rule, counted, key
from course_grader.rules.observation import Call, Goal, Observed, OutputLine, computed
from course_grader.rules.values import NUMBER

MAX_EARLY = 0.1  # [s] by which a line may seem to precede its event
LEVELS = 'DEBUG', 'INFO', 'WARN', 'ERROR', 'FATAL'  # of log messages, as rospy prints them
MAX_LATE = 1.0  # [s] by which a line may follow the first message with its numbers, unless that is shown longer
MAX_WRONG = 2  # lines with what does not belong there: a value at the limit may be rounded
MAX_GAP = 0.1  # [s] at most between the lines of one message
MAX_NUMBERS = 12  # in a line with a pose; a line with more is a guess
MAX_MARKER_NUMBERS = 30  # numbers in a line with markers, for the same reason
MIN_RIGHT = 0.4  # share of the values at one position of a line that must be right: a message has two x
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


Judge = Callable[[Any, Observed], Result]  # the method of a Rule


def _with_decimal_comma(judge: Judge) -> Judge:
    """Return a rule that also reads ``1,5`` as 1.5 in lines without a decimal point, if that improves the result."""
    @functools.wraps(judge)
    def both(rule: Rule, observed: Observed) -> Result:
        lines = [line if re.search(r'\d\.\d', line.text) else line._replace(text=DECIMAL_COMMA.sub('.', line.text))
                 for line in observed.lines]
        results = [judge(rule, observed)]
        if lines != observed.lines:
            results.append(judge(rule, replace(observed, lines=lines)))
        return max(results, key=lambda result: result.share)
    return both


@dataclass(frozen=True)
class Prints(Rule):
    """It prints lines that match a pattern."""

    pattern: str = key('pattern', ..., 'what has to be found in a line')
    times: int = key('integer', 1, 'in how many lines')
    level: Optional[str] = key(LEVELS, None, 'only lines that were logged with this level')
    without: Optional[str] = key('pattern', None, 'what such lines must not have, except for two of them')
    what: str = key('text', '', 'what the report calls such a line; the pattern, if empty')

    def judge(self, observed: Observed) -> Result:
        count = self.matching(observed)
        asked = f'{self.what or repr(self.pattern)}, printed {self.times} times'
        seen = f'{count} of {len(observed.lines)} lines match' + _example(observed)
        if self.without is not None:
            wrong = [line.text for line in observed.lines
                     if self.level in (None, line.level) and re.search(self.without, line.text)]
            if len(wrong) > MAX_WRONG:
                return Result(0.0, asked, f'{seen}; {len(wrong)} others do not belong there, such as {wrong[0]!r:.60}')
        return Result(min(1.0, count / self.times), asked, seen)

    def matching(self, observed: Observed) -> int:
        """Return the number of lines that match the pattern."""
        return sum(bool(re.search(self.pattern, line.text)) and self.level in (None, line.level)
                   for line in observed.lines)


@dataclass(frozen=True)
class PrintsPoses(Rule):
    """It prints where the turtle is while it moves."""

    fields: int = key((2, 3), 2, '2: x and y; 3: theta as well')
    tolerance: float = key('length', 0.02, 'how far off a printed value may be')
    share: float = key('share', 0.8, 'how many of the lines with numbers must be right')
    lines: int = key('integer', 20, 'at how many different poses')

    @_with_decimal_comma
    def judge(self, observed: Observed) -> Result:
        names = ('x', 'y', 'theta')[:self.fields]
        asked = f'{self.lines} lines with the {", ".join(names)} of the turtle; {self.share:.0%} of all lines correct'
        numbered = [statement for statement in _statements(observed.lines, self.fields)
                    if len(statement.numbers) >= self.fields]
        right = [statement for statement in numbered if _was_there(observed, statement, names, self.tolerance)]
        positions = {tuple(statement.numbers) for statement in right}
        seen = (f'{len(right)} of {len(numbered)} lines with numbers are correct, at {len(positions)} poses'
                + _example(observed))
        if not numbered:
            seen = f'{len(observed.lines)} lines, none with {self.fields} numbers' + _example(observed)
            return Result(0.0, asked, seen)
        correct = min(1.0, len(right) / len(numbered) / self.share)
        return Result(correct * min(1.0, len(positions) / self.lines), asked, seen)


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


@dataclass(frozen=True)
class Answers(Rule):
    """It offers a service and answers every call of the grader."""

    service: str = key('name', ..., 'name of the service, which a stimulus calls')
    prints: str = key(('request', 'nothing'), 'nothing', 'request: the numbers of each request must be printed')
    tolerance: float = key('length', 0.01, 'how far off a printed number may be')

    @_with_decimal_comma
    def judge(self, observed: Observed) -> Result:
        calls = [call for call in observed.calls if call.service == self.service]
        asked = f'{self.service} answers'
        asked += ' and prints the numbers of each request' if self.prints == 'request' else ''
        if not calls:
            return Result(0.0, asked, 'the program never offered it')
        good = [call for call in calls if call.answered]
        trouble = next((call.trouble for call in calls if not call.answered), '')
        seen = f'{len(good)} of {len(calls)} calls answered' + (f'; {trouble}' if trouble else '')
        if self.prints == 'request':
            printed = [call for call in good if _is_printed(observed.lines, call, self.tolerance)]
            share = counted(0.5 * (len(good) + len(printed)), len(calls))
            return Result(share, asked, f'{seen}; {len(printed)} requests printed')
        return Result(counted(len(good), len(calls)), asked, seen)


@dataclass(frozen=True)
class Reaches(Rule):
    """It serves the action Fibonacci: results, feedback on the way, and goals that are cancelled."""

    action: str = key('name', ..., 'name of the action, to which a stimulus sends goals')

    def judge(self, observed: Observed) -> Result:
        goals = [goal for goal in observed.goals if goal.action == self.action]
        asked = f'{self.action} reaches its goals, with feedback, and ends one that is cancelled'
        if not goals:
            return Result(0.0, asked, 'the program never offered it')
        wrong = list(filter(None, map(_missed, goals)))
        right = len(goals) - len(wrong)
        if not any(goal.cancelled for goal in goals):  # the last one
            wrong.append('the time was over before the last goal: are two numbers added per second?')
        seen = f'{right} of {right + len(wrong)} goals' + (f'; {wrong[0]}' if wrong else '')
        return Result(counted(right, right + len(wrong)), asked, seen)


def _missed(goal: Goal) -> Optional[str]:
    """Return what is wrong with the result of a goal, or None."""
    if goal.cancelled:
        return None if goal.state == 'PREEMPTED' else f'the cancelled goal is {goal.state}, not PREEMPTED'
    if goal.state != 'SUCCEEDED':
        return f'the goal of order {goal.order} is {goal.state}'
    numbers = [0, 1]
    while len(numbers) <= goal.order:
        numbers.append(numbers[-1] + numbers[-2])
    if list(goal.result) != numbers:
        return f'the result of order {goal.order} is {str(list(goal.result)):.80}, expected {numbers}'
    least = computed(goal.order)
    return None if goal.feedback >= least else f'{goal.feedback} messages of feedback for {least} numbers'


def _is_printed(lines: Iterable[OutputLine], call: Call, tolerance: float) -> bool:
    """Return whether a few consecutive lines after the call contain all numbers of a request."""
    after = [numbers_in(line.text) for line in lines if line.t >= call.t - MAX_EARLY]
    rows = [list(itertools.chain.from_iterable(after[start:start + len(call.request)])) for start in range(len(after))]
    return any(all(any(number.is_near(value, tolerance) for number in numbers) for value in call.request)
               for numbers in rows)


@dataclass(frozen=True)
class PrintsMarkers(Rule):
    """It prints a value of each marker that is shown.

    Only positions in its lines that often have the right value count, because a program that prints all numbers
    identifies no marker.
    """

    what: str = key(('id', 'x'), ..., 'the id, or x of the position')
    tolerance: float = key('length', 0.005, 'how far off x may be')

    @_with_decimal_comma
    def judge(self, observed: Observed) -> Result:
        matches: Dict[Tuple[str, int], List[Set[Tuple[int, int]]]] = collections.defaultdict(list)
        ends = [shown.t for shown in observed.shown[1:]] + [0.0]
        for number, (shown, end) in enumerate(zip(observed.shown, ends)):
            late = max(MAX_LATE, end - shown.t)
            near = [line.text for line in observed.lines if shown.markers and -MAX_EARLY <= line.t - shown.t <= late]
            for text in near:
                numbers, words = numbers_in(text), re.sub(NUMBER, '#', text)
                for index, printed in enumerate(numbers if len(numbers) <= MAX_MARKER_NUMBERS else ()):
                    matches[words, index].append({
                        (number, marker) for marker, position in shown.markers.items()
                        if (printed.value == marker if self.what == 'id' else
                            printed.is_near(position[0], self.tolerance))})
        found: Set[Tuple[int, int]] = set()
        for values in matches.values():
            if sum(map(bool, values)) >= MIN_RIGHT * len(values):
                found.update(*values)
        expected = sum(len(shown.markers) for shown in observed.shown)
        share = counted(len(found), MIN_PRINTED * expected) if expected else 0.0
        return Result(share, f'a line with the {self.what} of each marker shown',
                      f'{len(found)} of {expected}' + _example(observed))


@dataclass(frozen=True)
class PrintsNoMarker(Rule):
    """It says so when no marker is seen, and only then."""

    pattern: str = key('pattern', r'(?i)\bno(ne)?\b(?!\W*\d)',
                       'how it says so: by default with the word "no" or "none"')

    def judge(self, observed: Observed) -> Result:
        matching = [line.t for line in observed.lines if re.search(self.pattern, line.text)]
        ends = [shown.t - MAX_EARLY for shown in observed.shown[1:]] + [math.inf]
        shows = {kind: [(shown.t, end) for shown, end in zip(observed.shown, ends) if bool(shown.markers) == kind]
                 for kind in (False, True)}
        right = sum(any(start - MAX_EARLY <= t < end for t in matching) for start, end in shows[False])
        wrong = sum(any(start < t < end for t in matching) for start, end in shows[True])
        share = right / len(shows[False]) if shows[False] else 0.0
        seen = f'printed {right} of {len(shows[False])} times'
        if wrong:
            seen += f', and {wrong} of {len(shows[True])} times with a marker shown'
        share *= 1.0 - wrong / max(1, len(shows[True]))
        return Result(share, 'a line when no marker is shown, and only then', seen)


@dataclass(frozen=True)
class Connects(Rule):
    """It publishes, subscribes to or serves a name."""

    topic: str = key('name', ..., 'name of the topic or service')
    role: str = key(('publishes', 'subscribes', 'serves'), ..., 'what it does with it')
    type: str = key('text', '', 'the name of the type of a topic, in any package; any, if empty')

    def judge(self, observed: Observed) -> Result:
        there = (self.topic, self.role) in observed.connections
        others = sorted(name for name, role in observed.connections if role == self.role)
        does = 'subscribes to' if self.role == 'subscribes' else self.role
        asked = f'the program {does} {self.topic}' + (f', of the type {self.type}' if self.type else '')
        if there and self.type and observed.types.get(self.topic, '').rpartition('/')[2] != self.type:
            return Result(0.0, asked, f'its type is {observed.types.get(self.topic, "unknown")}')
        return Result(float(there), asked, 'yes' if there else f'the program {does} {", ".join(others) or "nothing"}')


@dataclass(frozen=True)
class Runs(Rule):
    """It runs as long as it should."""

    until: str = key(('the end', 'it is done'), 'the end',
                     'the end: it must not end by itself; it is done: it ends with exit code 0')

    def judge(self, observed: Observed) -> Result:
        if self.until == 'the end':
            asked = 'the program runs until the grader ends it'
            if observed.exit_code is None:
                return Result(1.0, asked, 'yes')
            return Result(0.0, asked, f'it ended after {observed.ended_at:.1f} s with exit code {observed.exit_code}')
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
