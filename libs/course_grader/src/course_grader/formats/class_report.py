"""The table of a class, students x exercises: as CSV, as an HTML page that needs nothing else, and as JUnit XML."""
import base64
import os
from typing import Dict, List, Optional, Sequence
from urllib.parse import quote
from xml.etree import ElementTree

import cv2

from course_grader.classes.class_grader import Graded
from course_grader.formats import harmless, junit, systems
from course_grader.rules import scoring
from course_grader.rules.scoring import Verdict
from kinematic_core.files import write_whole

THUMBNAIL = 200  # [px]
FILES = 'scores.csv', 'grades.csv', 'index.html', 'junit.xml'
COLUMNS = ('student', *systems.COLUMNS[1:])  # of grades.csv
STYLE = '''
body { font: 15px/1.4 sans-serif; margin: 2em; color: #222 } table { border-collapse: collapse }
th, td { border: 1px solid #bbb; padding: .3em .7em; text-align: right } th { background: #eee }
td:first-child, th:first-child { text-align: left } thead th { position: sticky; top: 0 }
.passed { background: #d8f3d8 } .failed { background: #f9d6d2 } .undecided { background: #fdeeb5 }
.missing { color: #999 }
section { border-top: 1px solid #bbb; margin-top: 1.5em; overflow: auto } img { float: left; margin: 0 1.5em 1em 0 }
h2 span { border-radius: .3em; padding: 0 .4em } ul { margin-left: 220px } code { color: #555 } a { color: inherit }
'''


def write(folder: str, title: str, students: Sequence[str], exercises: Sequence[str],
          results: Sequence[Graded]) -> None:
    """Write the FILES into a folder; raise OSError when that cannot be."""
    os.makedirs(folder, exist_ok=True)
    for name, content in zip(FILES, (as_csv(students, exercises, results), as_rows(results),
                                     as_html(title, students, exercises, results, folder), as_junit(results))):
        write_whole(os.path.join(folder, name), content)


def cells(students: Sequence[str], exercises: Sequence[str], results: Sequence[Graded]) -> List[List[str]]:
    """Return the table with its headings, as texts: the scores, '' for missing submissions, and the mean.

    The mean is over all exercises; missing submissions count 0. It is empty if any score is undecided.
    """
    by_place = {(graded.submission.student, graded.submission.exercise): graded for graded in results}
    rows = [['student', *exercises, 'mean']]
    for student in students:
        row = [by_place.get((student, exercise)) for exercise in exercises]
        known = all(graded is None or graded.outcome != scoring.UNDECIDED for graded in row)
        mean = sum(graded.score for graded in row if graded) / len(exercises)
        rows.append([student, *map(_cell, row), f'{mean:.1f}' if known else ''])
    return rows


def _cell(graded: Optional[Graded]) -> str:
    if graded is None:
        return ''
    return scoring.UNDECIDED if graded.outcome == scoring.UNDECIDED else f'{graded.score:g}'


def as_csv(students: Sequence[str], exercises: Sequence[str], results: Sequence[Graded]) -> str:
    """Return the table as CSV."""
    return systems.table(cells(students, exercises, results))


def as_rows(results: Sequence[Graded]) -> str:
    """Return CSV with a row for each submission."""
    return systems.table([COLUMNS, *(
        [graded.submission.student, graded.submission.exercise,
         '' if graded.outcome == scoring.UNDECIDED else f'{graded.score:g}', graded.outcome,
         systems.first_reason(_verdict(graded))] for graded in results)])


def as_junit(results: Sequence[Graded]) -> str:
    """Return JUnit XML: a testsuite for each submission."""
    return junit.document([
        junit.Suite(f'{graded.submission.student}: {graded.submission.exercise}',
                    f'{graded.submission.exercise}.{graded.submission.student}', _verdict(graded), graded.seconds)
        for graded in results])


def _verdict(graded: Graded) -> Verdict:
    return graded.verdict or Verdict(graded.outcome, graded.score, [], list(graded.reasons))


def as_html(title: str, students: Sequence[str], exercises: Sequence[str], results: Sequence[Graded],
            folder: str) -> str:
    """Return the page: the table, then each submission with its reasons and a small picture of its path.

    Links to the files of a grading are relative to ``folder``.
    """
    page = ElementTree.Element('html', lang='en')
    head = _add(page, 'head')
    _add(head, 'meta', charset='utf-8')
    _add(head, 'title', harmless.plain(title))
    _add(head, 'style', STYLE)
    body = _add(page, 'body')
    _add(body, 'h1', harmless.plain(title))
    _add(body, 'p', f'{len(results)} submissions: ' + ', '.join(
        f'{sum(graded.outcome == outcome for graded in results)} {outcome}' for outcome in
        (scoring.PASSED, scoring.FAILED, scoring.UNDECIDED)))
    _table(body, cells(students, exercises, results), {_anchor(graded): graded for graded in results})
    for graded in results:
        _section(body, graded, folder)
    return '<!DOCTYPE html>\n' + ElementTree.tostring(page, encoding='unicode', method='html') + '\n'


def _table(body: ElementTree.Element, rows: Sequence[Sequence[str]], by_anchor: Dict[str, Graded]) -> None:
    table = _add(body, 'table')
    names = _add(_add(table, 'thead'), 'tr')
    for name in rows[0]:
        _add(names, 'th', name)
    inside = _add(table, 'tbody')
    for student, *scores, mean in rows[1:]:
        line = _add(inside, 'tr')
        _add(line, 'td', harmless.plain(student))
        for exercise, score in zip(rows[0][1:], scores):
            graded = by_anchor.get(f'{student}/{exercise}')
            cell = _add(line, 'td', **{'class': graded.outcome if graded else 'missing'})
            if graded:
                _add(cell, 'a', score, href='#' + _quoted(_anchor(graded)),
                     title=harmless.plain(' | '.join(graded.reasons)))
            else:
                cell.text = '\u2013'
        _add(line, 'td', mean)


def _section(body: ElementTree.Element, graded: Graded, folder: str) -> None:
    section = _add(body, 'section', id=_anchor(graded))
    submission = graded.submission
    heading = _add(section, 'h2', harmless.plain(f'{submission.student}: {submission.exercise} '))
    _add(heading, 'span', f'{graded.outcome}, {graded.score:g}', **{'class': graded.outcome})
    picture = os.path.join(graded.folder, 'path.png')
    small = _thumbnail(picture)
    if small:
        link = _add(section, 'a', href=_relative(picture, folder))
        _add(link, 'img', src='data:image/png;base64,' + base64.b64encode(small).decode(), alt='the path',
             width=str(THUMBNAIL), height=str(THUMBNAIL))
    reasons = _add(section, 'ul')
    for reason in graded.reasons:
        _add(reasons, 'li', harmless.plain(reason))
    output = os.path.join(graded.folder, 'output.txt')
    if os.path.isfile(output):
        _add(_add(reasons, 'li'), 'a', 'what it printed', href=_relative(output, folder))
    _add(_add(reasons, 'li'), 'code', harmless.plain(' '.join(submission.command) or 'no command'))


def _thumbnail(path: str) -> Optional[bytes]:
    """Return a picture file made small, as PNG; None where there is none."""
    image = cv2.imread(path) if os.path.isfile(path) else None
    if image is None:
        return None
    encoded, png = cv2.imencode('.png', cv2.resize(image, (THUMBNAIL, THUMBNAIL), interpolation=cv2.INTER_AREA))
    return png.tobytes() if encoded else None


def _anchor(graded: Graded) -> str:
    return f'{graded.submission.student}/{graded.submission.exercise}'


def _relative(path: str, folder: str) -> str:
    return _quoted(os.path.relpath(path, folder))


def _quoted(name: str) -> str:
    return quote(os.fsencode(name))


def _add(parent: ElementTree.Element, tag: str, text: Optional[str] = None, **attributes: str) -> ElementTree.Element:
    element = ElementTree.SubElement(parent, tag, attributes)
    element.text = text
    return element
