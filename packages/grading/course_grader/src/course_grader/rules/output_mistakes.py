"""Mistakes in printed lines, compared with what should be printed: advice for each. Without ROS."""
import dataclasses
from typing import Any, Callable, Container, Dict, Iterator, List

from course_grader.rules import judging, rules_output
from course_grader.rules.exercise import Exercise
from course_grader.rules.observation import Observed
from course_grader.rules.rules_output import Prints, PrintsMarkers, PrintsPoses

MAJORITY = 0.5  # share of the lines or markers above which a mistake explains them
FEW_LINES = 5
SAME_LINES = 10  # lines with equal numbers although the turtle is driven


def found(exercise: Exercise, observed: Observed, lost: Container[str]) -> Dict[str, List[str]]:
    """Return {check: advice} for checks of an exercise that lost points: those of printed poses and markers."""
    hints: Dict[str, List[str]] = {}
    for scored in exercise.rules:
        if scored.name in lost and scored.name in KINDS:
            hints.setdefault(scored.name, []).extend(KINDS[scored.name](scored.rule, observed))
    lines = [scored.rule for scored in exercise.rules
             if isinstance(scored.rule, Prints) and scored.visible == judging.ALWAYS]
    counts = [wanted.matching(observed) for wanted in lines]
    if 'prints' in lost and lines and all(0 < count < wanted.times for count, wanted in zip(counts, lines)):
        hints['prints'] = [f'only {counts[0]} of {lines[0].times} lines are printed for "{lines[0].what}": print one '
                           'each time, also if nothing has changed']
    return hints


def _poses(wanted: PrintsPoses, observed: Observed) -> Iterator[str]:
    numbers = [numbers for numbers in (rules_output.numbers_in(line.text) for line in observed.lines) if numbers]
    if not numbers:
        return
    if (rules_output.poses_are(observed, ('y', 'x'), wanted.tolerance) > MAJORITY
            > rules_output.poses_are(observed, ('x', 'y'), wanted.tolerance)):  # both, if x and y are nearly equal
        yield 'x and y are swapped: print x first and then y, or say which is which'
    elif len(numbers) <= FEW_LINES < 2 * wanted.lines and observed.exit_code in (None, 0):
        yield f'only {len(numbers)} poses are printed: print in the callback, which is called for every pose'
    elif len(numbers) >= SAME_LINES and len({tuple(number.value for number in one) for one in numbers}) == 1:
        yield 'the numbers are always the same: print those of the message that the callback gets'
    elif all(number.value == int(number.value) and not number.rounded for one in numbers for number in one[-2:]):
        yield 'x and y are printed as whole numbers: print two decimals or more, as by %.2f'
    elif sum(len(one) > 1 and one[-1].value == one[-2].value for one in numbers) > MAJORITY * len(numbers):
        yield 'the same number is printed twice: print pose.x and pose.y'
    elif len(numbers) < wanted.lines and rules_output.poses_are(observed, ('x', 'y'), wanted.tolerance) > MAJORITY:
        yield (f'only {len(numbers)} poses are printed, of {wanted.lines} or more: print each one, in the callback, '
               'and let it neither sleep nor wait')
    elif any(rules_output.poses_are(observed, (axis, 'theta'), wanted.tolerance) > MAJORITY for axis in 'xy'):
        yield 'one of the numbers is theta, the heading: print pose.x and pose.y'


def _markers(wanted: PrintsMarkers, observed: Observed) -> Iterator[str]:
    values = {'id': ('z', 'y', 'x'), 'x': ('z', 'y', 'id')}[wanted.what]
    asked = {'id': 'marker.id', 'x': 'marker.pose.pose.position.x'}[wanted.what]
    if wanted.judge(observed).share > MAJORITY:
        return
    numbers = [numbers[-1] for numbers in (rules_output.numbers_in(line.text) for line in observed.lines) if numbers]
    if wanted.what == 'x' and 'position.x' in observed.source and len(numbers) > FEW_LINES and all(
            number.value == int(number.value) and not number.rounded for number in numbers):
        yield 'x is printed as a whole number: print metres, with two decimals or more, as by %.2f'
        return
    for value in values:
        if value == 'id':
            other, what = observed, 'id'
        else:
            axis = 'xyz'.index(value)
            other = dataclasses.replace(observed, shown=[shown._replace(markers={
                marker: (position[axis],) * 3 for marker, position in shown.markers.items()})
                for shown in observed.shown])
            what = 'x'
        if PrintsMarkers(what).judge(other).share > MAJORITY:
            yield f'it prints {value} of each marker: print {asked} instead'
            return
    counted = [dataclasses.replace(observed, shown=[shown._replace(markers=dict(enumerate(
        shown.markers.values(), first))) for shown in observed.shown]) for first in (0, 1)]
    if any(PrintsMarkers('id').judge(other).share > MAJORITY for other in counted):
        yield f'it counts the markers of each message: print {asked} instead of its place in the list'


KINDS: Dict[str, Callable[[Any, Observed], Iterator[str]]] = {
    'prints_poses': _poses, 'prints_markers': _markers}
