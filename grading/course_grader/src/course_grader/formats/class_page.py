"""The page of a class, and a page for each student: HTML files that need nothing else, not even a network.

A page is used by hand: its table sorts, and filters choose exercises and verdicts. Without JavaScript everything is
still there. Names, reasons and printed lines are a student's, so that all of it is added as text.
"""
import base64
import hashlib
import os
import re
import shlex
from typing import TYPE_CHECKING, Optional, Sequence
from urllib.parse import quote
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from course_grader.formats import harmless, systems
from course_grader.isolation import levels
from course_grader.rules import scoring

if TYPE_CHECKING:
    from course_grader.classes.graded import Graded
    from course_grader.formats.class_report import Class

PICTURE = 300  # [px]
MOST_PRINTED = 20_000  # characters of what a program printed, on a student's page
OUTCOMES = scoring.PASSED, scoring.FAILED, scoring.UNDECIDED
LEGEND = (('start', 'start'), ('end', 'end'), ('counted', 'what counted'))
STYLE = '''
:root { color-scheme: light dark; --back: #fff; --text: #1d2125; --soft: #59636e; --line: #d0d5da; --head: #f1f3f5;
  --link: #0b5cad; --passed: #d9f2dd; --failed: #fbdcd8; --undecided: #fdf0c0; --hint: #eaf2fd; --good: #7fd08a;
  --bad: #d01414 }
@media (prefers-color-scheme: dark) { :root { --back: #15181c; --text: #e4e7ea; --soft: #9aa4ae; --line: #3a4149;
  --head: #20252b; --link: #7db4ff; --passed: #1d4427; --failed: #5a2421; --undecided: #51430f; --hint: #1b2b40;
  --good: #2f8f46; --bad: #ff6b6b } }
* { box-sizing: border-box }
body { font: 15px/1.45 system-ui, sans-serif; margin: 0 auto; max-width: 1400px; padding: 1rem; color: var(--text);
  background: var(--back) }
a { color: var(--link) } h1 { font-size: 1.5rem; margin: .2rem 0 } p { margin: .4rem 0 }
form { display: flex; flex-wrap: wrap; gap: .4rem 1.2rem; align-items: center; margin: .8rem 0 }
input, select, button { font: inherit; color: inherit; background: var(--back); border: 1px solid var(--line);
  border-radius: .3rem; padding: .2rem .5rem; max-width: 100% }
.table { overflow: auto; max-height: 80vh; border: 1px solid var(--line); width: fit-content; max-width: 100% }
.table table { border-collapse: separate; border-spacing: 0; font-variant-numeric: tabular-nums }
.table th, .table td { padding: .25rem .6rem; border: 0 solid var(--line); border-width: 0 1px 1px 0;
  text-align: right }
.table thead th { position: sticky; top: 0; z-index: 1; background: var(--head); vertical-align: bottom;
  font-weight: 600; max-width: 9rem }
.table th:first-child { position: sticky; left: 0; z-index: 2; background: var(--head); text-align: left;
  font-weight: 600; min-width: 6.5rem; max-width: 40vw; overflow-wrap: break-word }
.table thead th:first-child { z-index: 3 }
.table thead button { all: unset; cursor: pointer } .table thead button:focus-visible { outline: 2px solid var(--link) }
th[aria-sort=ascending] button::after { content: " \\25B2" }
th[aria-sort=descending] button::after { content: " \\25BC" }
.table td a { color: inherit; text-decoration: none; display: block }
.passed { background: var(--passed) } .failed { background: var(--failed) } .undecided { background: var(--undecided) }
.missing { color: var(--soft) } .badge { border-radius: .3rem; padding: .05rem .45rem; white-space: nowrap }
details.submission { border-top: 1px solid var(--line); padding: .5rem 0 }
details.submission > summary { cursor: pointer; overflow-wrap: anywhere } summary b { font-size: 1.05rem }
summary .why { color: var(--soft) } details[open] > summary .why { display: none }
.body { display: flex; flex-wrap: wrap; gap: .5rem 1.5rem; padding: .5rem 0 .5rem 1rem }
.words { flex: 1 1 22rem; min-width: 0; overflow-wrap: anywhere }
.hint { background: var(--hint); border-left: 4px solid var(--link); padding: .4rem .7rem }
.warning { background: var(--undecided); border-left: 4px solid var(--bad); padding: .4rem .7rem }
.checks { border-collapse: collapse; width: 100% } .checks th, .checks td { text-align: left; vertical-align: top;
  padding: .2rem .6rem .2rem 0; border-top: 1px solid var(--line) } .checks td:first-child { white-space: nowrap }
.lost td:first-child { color: var(--bad); font-weight: 600 }
figure { margin: 0 } figure img { display: block; width: 300px; max-width: 100%; height: auto }
figcaption { color: var(--soft); font-size: .85rem } figcaption i { display: inline-block; width: .7em; height: .7em;
  border-radius: 50%; margin: 0 .3em 0 .8em; border: 2px solid currentColor }
i.end { background: var(--bad); border-color: var(--bad) }
i.counted { background: var(--good); border-color: var(--good) }
code, pre { font: .85rem/1.4 ui-monospace, monospace } pre { overflow: auto; max-height: 25rem; background: var(--head);
  padding: .6rem; white-space: pre-wrap; overflow-wrap: anywhere } .soft { color: var(--soft) }
[hidden] { display: none !important }
@media print { :root { --back: #fff; --text: #000; --soft: #444; --line: #999; --head: #eee; --link: #000; color-scheme:
  light; --passed: #d9f2dd; --failed: #fbdcd8; --undecided: #fdf0c0; --hint: #f2f2f2 }
  body { font-size: 10pt; max-width: none; padding: 0 } form, .screen { display: none !important }
  .table { max-height: none; overflow: visible; border: 0 } .table thead th, .table th:first-child { position: static }
  .table table { font-size: 8pt } .table th, .table td { padding: .1rem .3rem }
  * { print-color-adjust: exact } tr, figure, .hint { break-inside: avoid } details.submission > summary {
  break-after: avoid } }
'''
SCRIPT = '''
'use strict';
const all = (selector, root = document) => [...root.querySelectorAll(selector)];
const table = document.querySelector('.table table'), form = document.querySelector('form');
form.hidden = false;
const filter = () => {
  const name = form.elements.name.value.trim().toLowerCase(), exercise = form.elements.exercise.value;
  const verdicts = all('[name=verdict]:checked', form).map(box => box.value);
  const fits = element => (!exercise || element.dataset.exercise === exercise)
    && verdicts.includes(element.dataset.verdict);
  all('[data-column]', table).forEach(cell => { cell.hidden = exercise && cell.dataset.exercise !== exercise; });
  for (const row of table.tBodies[0].rows)
    row.hidden = !row.dataset.student.toLowerCase().includes(name) || !all('td[data-column]', row).some(fits);
  all('.submission').forEach(part => {
    part.hidden = !part.dataset.student.toLowerCase().includes(name) || !fits(part);
  });
};
form.addEventListener('input', filter);
form.addEventListener('submit', event => event.preventDefault());
form.addEventListener('reset', () => setTimeout(filter));
all('thead button', table).forEach(button => button.addEventListener('click', () => {
  const head = button.closest('th'), column = head.cellIndex;
  const up = head.getAttribute('aria-sort') === (column ? 'descending' : 'ascending') ? column : !column;
  all('thead th', table).forEach(other => other.removeAttribute('aria-sort'));
  head.setAttribute('aria-sort', up ? 'ascending' : 'descending');
  const value = row => row.cells[column].dataset.value ?? row.dataset.student;
  const order = (a, b) => column ? value(a) - value(b) : value(a).localeCompare(value(b));
  table.tBodies[0].append(...[...table.tBodies[0].rows].sort((a, b) => up ? order(a, b) : order(b, a)));
}));
const show = () => {
  const part = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (part) { part.hidden = false; part.open = true; part.scrollIntoView(); }
};
addEventListener('hashchange', show);
all('td a', table).forEach(link => link.addEventListener('click', () => setTimeout(show)));
document.getElementById('all').addEventListener('click', event => {
  const parts = all('.submission'), open = parts.some(part => !part.open);
  parts.forEach(part => { part.open = open; });
});
show();
'''


def of_class(graded: 'Class', rows: Sequence[Sequence[str]], folder: str) -> str:
    """Return the page of a class: ``rows`` as a table, then each submission with hints, checks and its path.

    Links to the files of a grading are relative to ``folder``.
    """
    page, body = _page(graded.title, SCRIPT)
    results = graded.results
    _add(body, 'p', f'{len(results)} submissions: ' + ', '.join(
        f'{sum(one.outcome == outcome for one in results)} {outcome}' for outcome in OUTCOMES))
    _isolation(body, results)
    if any(weight != 1.0 for weight in graded.weights.values()):
        _add(body, 'p', 'Weights in the mean: ' + ', '.join(
            f'{exercise} {graded.weights.get(exercise, 1.0):g}' for exercise in graded.exercises))
    _form(body, graded.exercises)
    _table(body, rows, graded)
    _add(_add(body, 'p', **{'class': 'screen'}), 'button', 'Open or close all', type='button', id='all')
    for one in results:
        _submission(body, one, folder)
    return _text(page)


def of_student(student: str, results: Sequence['Graded']) -> str:
    """Return the page of a student, in which no other one is named: it may be sent to its student."""
    page, body = _page(student, '')
    for one in results:
        _submission(body, one, None)
    if not results:
        _add(body, 'p', 'Nothing was handed in.')
    return _text(page)


def _page(title: str, script: str) -> 'tuple[Element, Element]':
    """Return (page, body); only what stands in the page is loaded or run."""
    page = Element('html', lang='en')
    head = _add(page, 'head')
    _add(head, 'meta', charset='utf-8')
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    _add(head, 'meta', **{'http-equiv': 'Content-Security-Policy'},
         content=f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{digest}'")
    _add(head, 'meta', name='viewport', content='width=device-width, initial-scale=1')
    _add(head, 'title', title)
    _add(head, 'style', STYLE)
    body = _add(page, 'body')
    _add(body, 'h1', title)
    if script:
        page.append(Element('script'))
        page[-1].text = script
    return page, body


def _text(page: Element) -> str:
    return '<!DOCTYPE html>\n' + ElementTree.tostring(page, encoding='unicode', method='html') + '\n'


def _isolation(body: Element, results: Sequence['Graded']) -> None:
    """Add how many programs ran at each level, with a warning about those that nothing, or little, held back."""
    counted = [(level, sum(one.isolation == level for one in results)) for level in levels.LEVELS]
    shown = [(level, number) for level, number in counted if number]
    if shown:
        _add(body, 'p', 'Isolation: ' + ', '.join(f'{level} {number}' for level, number in shown))
    for level, number in shown:
        if level != levels.NAMESPACE:
            _add(body, 'p', f'{number} of {len(results)}: {levels.warning(level)}', **{'class': 'warning'})


def _form(body: Element, exercises: Sequence[str]) -> None:
    """Add the filters, which JavaScript shows."""
    form = _add(body, 'form', hidden='')
    label = _add(form, 'label', 'Student ')
    _add(label, 'input', name='name', type='search', size='12')
    choice = _add(_add(form, 'label', 'Exercise '), 'select', name='exercise')
    _add(choice, 'option', 'all', value='')
    for exercise in exercises:
        _add(choice, 'option', exercise, value=harmless.plain(exercise))
    for outcome in (*OUTCOMES, 'missing'):
        label = _add(form, 'label')
        box = _add(label, 'input', type='checkbox', name='verdict', value=outcome, checked='')
        box.tail = f' {outcome}'
    _add(form, 'button', 'Show all', type='reset')


def _table(body: Element, rows: Sequence[Sequence[str]], graded: 'Class') -> None:
    best = graded.best()
    table = _add(_add(body, 'div', **{'class': 'table'}), 'table')
    names = _add(_add(table, 'thead'), 'tr')
    for place, name in enumerate(rows[0]):
        column = {'data-column': '', 'data-exercise': harmless.plain(name)} if 0 < place < len(rows[0]) - 1 else {}
        button = _add(_add(names, 'th', scope='col', **column), 'button', type='button', title='sort')
        first, *others = harmless.plain(name).split('_')
        button.text = first
        for part in others:  # so that a long name may be broken
            _add(button, 'wbr').tail = f'_{part}'
    inside = _add(table, 'tbody')
    for row in rows[1:]:
        student, *scores, mean = row
        line = _add(inside, 'tr', **{'data-student': harmless.plain(student)})
        _add(line, 'th', student, scope='row')
        for exercise, score in zip(graded.exercises, scores):
            one = best.get((student, exercise))
            verdict = one.outcome if one else 'missing'
            value = -2.0 if one is None else -1.0 if one.outcome == scoring.UNDECIDED else one.score
            cell = _add(line, 'td', **{'class': verdict, 'data-column': '', 'data-exercise': harmless.plain(exercise),
                                       'data-verdict': verdict, 'data-value': f'{value:g}'})
            if one:
                reason = systems.first_reason(one.verdict) or one.outcome
                _add(cell, 'a', score, href='#' + _quoted(_anchor(one)), title=_bare(reason, one))
            else:
                cell.text = '\u2013'
        _add(line, 'td', mean, **{'data-value': mean or '-1'})


def _submission(body: Element, one: 'Graded', folder: Optional[str]) -> None:
    """Add a submission; with links into ``folder``, or, where it is None, with what the program printed."""
    submission = one.submission
    attributes = {} if one.outcome == scoring.PASSED else {'open': ''}
    part = _add(body, 'details', id=_anchor(one), **{
        'class': 'submission', 'data-student': harmless.plain(submission.student), 'data-verdict': one.outcome,
        'data-exercise': harmless.plain(submission.exercise)}, **attributes)
    summary = _add(part, 'summary')
    _add(summary, 'b', (f'{submission.student}: ' if folder else '') + submission.exercise).tail = ' '
    if submission.attempt:
        _add(summary, 'span', submission.attempt, **{'class': 'soft'}).tail = ' '
    said = one.outcome + ('' if one.outcome == scoring.UNDECIDED else f', {one.score:g} of 100')
    _add(summary, 'span', said, **{'class': f'badge {one.outcome}'}).tail = ' '
    _add(summary, 'span', _bare(_cut(systems.first_reason(one.verdict)), one), **{'class': 'why'})
    inside = _add(part, 'div', **{'class': 'body'})
    words = _add(inside, 'div', **{'class': 'words'})
    for hint in one.verdict.hints:
        _add(words, 'p', f'Hint: {_bare(hint, one)}', **{'class': 'hint'})
    for objection in one.verdict.objections:
        _add(words, 'p', _bare(objection, one))
    _checks(words, one)
    _footer(words, one, folder)
    _picture(inside, one)


def _checks(words: Element, one: 'Graded') -> None:
    if not one.verdict.reasons:
        return
    table = _add(words, 'table', **{'class': 'checks'})
    line = _add(_add(table, 'thead'), 'tr')
    for name in ('points', 'asked', 'seen'):
        _add(line, 'th', name)
    inside = _add(table, 'tbody')
    for reason in one.verdict.reasons:
        line = _add(inside, 'tr', **({'class': 'lost'} if reason.points < reason.of else {}))
        for text in (f'{reason.points:g} of {reason.of:g}', reason.asked, reason.seen):
            _add(line, 'td', _bare(text, one))


def _footer(words: Element, one: 'Graded', folder: Optional[str]) -> None:
    """Add how it can be repeated, and what the program printed."""
    if one.repeat:
        own = one.submission.student + os.sep
        parts = one.repeat if folder else [part.partition(own)[2] or part for part in one.repeat]
        line = _add(words, 'p', 'Again: ')
        _add(line, 'code', './run grade ' + shlex.join(map(harmless.plain, parts)))
    output = os.path.join(one.folder, 'output.txt')
    printed = os.path.isfile(output) and os.path.getsize(output) > 0
    line = _add(words, 'p', f'{one.seconds:.1f} s' + (f'; isolation: {one.isolation}' if one.isolation else ''),
                **{'class': 'soft'})
    if printed and folder:
        link = _add(line, 'span', '; ', **{'class': 'screen'})
        _add(link, 'a', 'what it printed', href=_quoted(os.path.relpath(output, folder)))
    elif printed:
        with open(output, encoding='utf-8', errors='replace') as file:
            text = file.read(MOST_PRINTED + 1)
        shown = _add(words, 'details')
        _add(shown, 'summary', 'What it printed, and when [s]')
        _add(shown, 'pre', _bare(text[:MOST_PRINTED], one) + ('\n...' if len(text) > MOST_PRINTED else ''))


def _picture(inside: Element, one: 'Graded') -> None:
    path = os.path.join(one.folder, 'path.svg')
    if not os.path.isfile(path):
        return
    with open(path, 'rb') as file:
        content = file.read()
    figure = _add(inside, 'figure')
    _add(figure, 'img', src='data:image/svg+xml;base64,' + base64.b64encode(content).decode(), alt='the path',
         width=str(PICTURE), height=str(PICTURE))
    caption = _add(figure, 'figcaption')
    for name, text in LEGEND:
        if f'class="{name}'.encode() in content:
            _add(caption, 'i', **{'class': name}).tail = text


def _bare(text: str, one: 'Graded') -> str:
    """Return a text without the folder in which the student's folder lies: it helps no student."""
    return re.sub(rf"""/[^\s"']*?/{re.escape(one.submission.student)}/""", '', text)


def _cut(text: str, most: int = 120) -> str:
    return text if len(text) <= most else text[:most - 1] + '\u2026'


def _anchor(one: 'Graded') -> str:
    submission = one.submission
    return harmless.plain('/'.join(filter(None, (submission.student, submission.exercise, submission.attempt))))


def _quoted(name: str) -> str:
    return quote(os.fsencode(name))


def _add(parent: Element, tag: str, text: Optional[str] = None, **attributes: str) -> Element:
    element = ElementTree.SubElement(parent, tag, {name: harmless.plain(value) for name, value in attributes.items()})
    element.text = None if text is None else harmless.plain(text)
    return element
