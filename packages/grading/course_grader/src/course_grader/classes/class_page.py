"""The page of a class, and a page for each student: HTML files that need nothing else, not even a network.

The table of the class page sorts, and filters choose exercises and verdicts. Without JavaScript everything is visible.
"""
import base64
import collections
import hashlib
import os
import re
import shlex
import time
from typing import Any, Dict, List, Optional, Sequence
from urllib.parse import quote

from course_grader.classes.class_table import SUMMARIES, Class, cells
from course_grader.classes.graded import SIMILAR, Graded
from course_grader.classes.submissions import LeftOut
from course_grader.formats import harmless, templates
from course_grader.isolation import levels
from course_grader.rules import judging, scoring

MAX_PRINTED = 20_000  # characters of a program's output on a student's page
MAX_REASON = 120  # characters of the reason beside the title of a submission
OUTCOMES = scoring.PASSED, scoring.FAILED, scoring.UNDECIDED
MAX_MISTAKES = 3  # that are listed for an exercise
MISSING = 'missing'  # the verdict of a cell without a submission
UNDECIDED_MEANS = ('Undecided: there is no score, because the machine was too slow or the grader itself failed. This '
                   'is not the student\u2019s fault. The program is graded again the next time.')
HIDDEN = {judging.LATER: 'students see it after the deadline', judging.NEVER: 'students do not see it'}
LEGEND = {'start': 'start', 'end': 'end', 'counted': 'what counted'}  # style of a path picture: its meaning


def of_class(graded: Class, folder: str) -> str:
    """Return the page of a class: a table, then each submission with hints, checks and its path.

    Links to the files of a grading are relative to ``folder``.
    """
    outcomes = [one.outcome for one in graded.results]
    weights = {exercise: graded.weight(exercise) for exercise in graded.exercises}
    return _page(
        'class.html', graded.title, 'class_page.js', exercises=graded.exercises, summaries=tuple(SUMMARIES),
        outcomes={outcome: outcomes.count(outcome) for outcome in OUTCOMES}, verdicts=(*OUTCOMES, MISSING),
        isolation=_isolation(graded.results), rows=_rows(graded),
        weights='' if set(weights.values()) <= {1.0} else ', '.join(f'{name} {weights[name]:g}' for name in weights),
        submissions=[_submission(one, folder) for one in graded.results],
        left_out=[harmless.plain(one.text()) for one in graded.left_out], statistics=_statistics(graded),
        similar=[(harmless.plain(pair.text()), f'{SIMILAR}/{number}.html')
                 for number, pair in enumerate(graded.similar, 1)])


def _statistics(graded: Class) -> List[Dict[str, Any]]:
    """Return for each exercise how many have handed it in and passed, their mean, and the most frequent advice."""
    best, found = graded.best(), []
    for exercise in graded.exercises:
        own = [one for (_, name), one in best.items() if name == exercise]
        decided = [one for one in own if one.outcome in scoring.DECIDED]
        hints = collections.Counter(hint for one in decided for hint in one.verdict.hints[:1])
        lost = collections.Counter(check.asked for one in decided for check in one.verdict.reasons
                                   if check.points < check.of)
        found.append({
            'exercise': exercise, 'count': len(own), 'passed': sum(one.outcome == scoring.PASSED for one in own),
            'mean': f'{sum(one.score for one in decided) / len(decided):.1f}' if decided else '',
            'mistakes': [(harmless.plain(text), count) for text, count in (
                *hints.most_common(MAX_MISTAKES), *lost.most_common(MAX_MISTAKES - len(hints)))][:MAX_MISTAKES]})
    return found


def of_student(student: str, results: Sequence[Graded], left_out: Sequence[LeftOut] = ()) -> str:
    """Return the page of a student, which may be sent to that student: it names no other."""
    return _page('student.html', student, submissions=[_submission(one, None) for one in results],
                 left_out=[harmless.plain(one._replace(student='').text()) for one in left_out])


def _page(template: str, title: str, script: str = '', **values: Any) -> str:
    """Return a page that loads and runs nothing but what it contains."""
    code = templates.verbatim(script) if script else ''
    digest = base64.b64encode(hashlib.sha256(code.encode()).digest()).decode()
    return templates.rendered(template, title=title, written=time.strftime('%Y-%m-%d %H:%M'),
                              style=templates.verbatim('class_page.css'), script=code, script_digest=digest, **values)


def _isolation(results: Sequence[Graded]) -> List[Any]:
    """Return (level, number of programs, warning) for each level of isolation at which programs ran."""
    used = [one.isolation for one in results]
    return [(level, used.count(level), levels.warning(level)) for level in levels.LEVELS if level in used]


def _rows(graded: Class) -> List[Dict[str, Any]]:
    """Return the rows of the table: the student, the cells of the exercises, and the SUMMARIES."""
    best = graded.best()
    return [{'student': student, 'summaries': others[len(graded.exercises):],
             'cells': [_cell(best.get((student, exercise)), exercise, text)
                       for exercise, text in zip(graded.exercises, others)]} for student, *others in cells(graded)[1:]]


def _cell(one: Optional[Graded], exercise: str, text: str) -> Dict[str, str]:
    """Return a cell; its ``value`` is what it is sorted by."""
    if one is None:
        return {'exercise': exercise, 'verdict': MISSING, 'value': '-2', 'text': '', 'link': '', 'reason': ''}
    reason = one.verdict.main_reason() or one.outcome
    return {'exercise': exercise, 'verdict': one.outcome, 'text': text, 'link': f'#{_quoted(_anchor(one))}',
            'value': '-1' if one.outcome == scoring.UNDECIDED else f'{one.score:g}', 'reason': _local(reason, one)}


def _submission(one: Graded, folder: Optional[str]) -> Dict[str, Any]:
    """Return the texts of a submission; with a link into ``folder``, or the program's output if that is None."""
    submission = one.submission
    verdict = one.verdict if folder is not None else one.verdict.public(one.over)
    reason = verdict.main_reason()
    reason = reason if len(reason) <= MAX_REASON else reason[:MAX_REASON - 1] + '\u2026'
    picture = _content(os.path.join(one.folder, 'path.svg'))
    output = os.path.join(one.folder, 'output.txt')
    has_output = os.path.isfile(output) and os.path.getsize(output) > 0
    return {
        'anchor': _anchor(one), 'student': submission.student, 'exercise': submission.exercise,
        'attempt': submission.attempt, 'outcome': one.outcome, 'reason': _local(reason, one),
        'title': submission.exercise if folder is None else f'{submission.student}: {submission.exercise}',
        'verdict': one.outcome + ('' if one.outcome == scoring.UNDECIDED else f', {one.score:g} of 100'),
        'hints': [_local(advice, one) for advice in verdict.advice()],
        'objections': [_local(objection, one) for objection in verdict.objections],
        'notes': [_local(note, one) for note in one.notes],
        'hidden': sum(check.of for check in one.verdict.reasons) - sum(check.of for check in verdict.reasons),
        'when': time.strftime('%Y-%m-%d %H:%M', time.localtime(one.at)) if one.at else '',
        'handed_in': harmless.plain(submission.handed_in), 'task': one.title, 'asks': _local(one.asks, one),
        'undecided': UNDECIDED_MEANS if one.outcome == scoring.UNDECIDED else '',
        'checks': [{'lost': check.points < check.of, 'points': f'{check.points:g} of {check.of:g}',
                    'asked': _local(check.asked, one), 'seen': _local(check.seen, one),
                    'visible': HIDDEN.get(check.visible, '')} for check in verdict.reasons],
        'command': _command(one, folder), 'seconds': f'{one.seconds:.1f} s', 'isolation': one.isolation,
        'output': _quoted(os.path.relpath(output, folder)) if has_output and folder is not None else '',
        'printed': _printed(output, one) if has_output and folder is None else '',
        'picture': base64.b64encode(picture).decode(),
        'legend': [entry for entry in LEGEND.items() if f'class="{entry[0]}'.encode() in picture]}


def _command(one: Graded, folder: Optional[str]) -> str:
    """Return the command line that repeats a grading, or ''; without ``folder`` paths start at the student's folder."""
    own = one.submission.student + os.sep
    parts = one.repeat if folder is not None else [part.partition(own)[2] or part for part in one.repeat]
    return './run grade ' + shlex.join(map(harmless.plain, parts)) if parts else ''


def _printed(path: str, one: Graded) -> str:
    with open(path, encoding='utf-8', errors='replace') as file:
        text = file.read(MAX_PRINTED + 1)
    return _local(text[:MAX_PRINTED], one) + ('\n...' if len(text) > MAX_PRINTED else '')


def _content(path: str) -> bytes:
    if not os.path.isfile(path):
        return b''
    with open(path, 'rb') as file:
        return file.read()


def _local(text: str, one: Graded) -> str:
    """Return a text without the path of the folder that contains the student's folder: it helps no student."""
    return re.sub(rf"""/[^\s"']*?/{re.escape(one.submission.student)}/""", '', text)


def _anchor(one: Graded) -> str:
    submission = one.submission
    return harmless.plain('/'.join(filter(None, (submission.student, submission.exercise, submission.attempt))))


def _quoted(name: str) -> str:
    return quote(os.fsencode(name))
