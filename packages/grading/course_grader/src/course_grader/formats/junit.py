"""A grading as a testsuite of JUnit: a testcase for the verdict and one for each check.

A check fails if it lost points and the exercise did not pass. In an undecided grading the verdict is an error, and the
checks are skipped.
"""
from typing import NamedTuple, Optional, Sequence, Tuple
from xml.etree import ElementTree

from course_grader.formats import harmless
from course_grader.rules import scoring
from course_grader.rules.scoring import Reason, Verdict

VERDICT = 'verdict'  # the name of the first testcase
LEFT_OUT = 'not graded'  # the name of the testsuite of what was handed in, and is not graded
TAGS = {scoring.FAILED: 'failure', scoring.UNDECIDED: 'error'}


class Suite(NamedTuple):
    """A testsuite: its name, the class name of its testcases, the verdict, and the time [s].

    ``isolation``: the level at which the program ran, or ''.
    """

    name: str
    classname: str
    decided: Verdict
    seconds: float
    isolation: str = ''


def document(suites: Sequence[Suite], left_out: Sequence[Tuple[str, str]] = ()) -> str:
    """Return the XML of some gradings; ``left_out``: (name, reason) of what is not graded, as skipped testcases."""
    root = ElementTree.Element('testsuites')
    for suite in suites:
        _add(root, suite)
    if left_out:
        _add_left_out(root, left_out)
    for name in ('tests', 'failures', 'errors'):
        root.set(name, str(sum(int(element.get(name, '0')) for element in root)))
    return ElementTree.tostring(root, encoding='unicode', xml_declaration=True) + '\n'


def _add(root: ElementTree.Element, suite: Suite) -> None:
    decided = suite.decided
    element = ElementTree.SubElement(root, 'testsuite', name=harmless.plain(suite.name), time=f'{suite.seconds:.3f}')
    if suite.isolation:
        ElementTree.SubElement(ElementTree.SubElement(element, 'properties'), 'property', name='isolation',
                               value=harmless.plain(suite.isolation))
    first = _case(element, suite, VERDICT, suite.seconds)
    score = f'{decided.outcome}, {decided.score:g} of 100'
    message = decided.objections[0] if decided.objections else score
    _judge(first, TAGS.get(decided.outcome), message, '\n'.join(decided.objections))
    for number, reason in enumerate(decided.reasons, 1):
        case = _case(element, suite, f'{number}. {reason.check}: {reason.asked}', 0.0)
        _judge(case, _tag(decided, reason), f'{reason.points:g} of {reason.of:g} points', f'seen: {reason.seen}')
    _count(element)


def _add_left_out(root: ElementTree.Element, left_out: Sequence[Tuple[str, str]]) -> None:
    element = ElementTree.SubElement(root, 'testsuite', name=LEFT_OUT, time='0.000')
    for name, reason in left_out:
        case = ElementTree.SubElement(element, 'testcase', classname=LEFT_OUT, name=harmless.plain(name), time='0.000')
        ElementTree.SubElement(case, 'skipped', message=harmless.plain(reason))
    _count(element)


def _count(element: ElementTree.Element) -> None:
    for name, path in ('tests', 'testcase'), ('failures', '*/failure'), ('errors', '*/error'), ('skipped', '*/skipped'):
        element.set(name, str(len(element.findall(path))))


def _case(element: ElementTree.Element, suite: Suite, name: str, seconds: float) -> ElementTree.Element:
    return ElementTree.SubElement(element, 'testcase', classname=harmless.plain(suite.classname),
                                  name=harmless.plain(name), time=f'{seconds:.3f}')


def _tag(decided: Verdict, reason: Reason) -> Optional[str]:
    """Return the element for the result of a check, or None if it passed."""
    if decided.outcome == scoring.UNDECIDED:
        return 'skipped'
    return 'failure' if decided.outcome == scoring.FAILED and reason.points < reason.of else None


def _judge(case: ElementTree.Element, tag: Optional[str], message: str, text: str) -> None:
    if tag:
        ElementTree.SubElement(case, tag, message=harmless.plain(message)).text = harmless.plain(text)
    else:
        ElementTree.SubElement(case, 'system-out').text = harmless.plain(f'{message}\n{text}'.rstrip())
