"""course_grader.classes: the tables of a class, in files and in a terminal."""
import csv
import io
from xml.etree import ElementTree

import pytest

from course_grader.classes import class_page, class_results, class_table, grade_all
from course_grader.classes.class_table import Class
from course_grader.classes.similarity import Pair
from course_grader.formats import terminal
from course_grader.rules import scoring
from course_grader.rules.scoring import Reason
from unit_support.gradings import graded


def test_weights_count_in_the_mean_and_missing_submissions_as_zero():
    results = [graded('anna', 'x', 90.0), graded('anna', 'y', 60.0), graded('ben', 'x', 50.0, 'failed'),
               graded('carl', 'y', 0.0, 'undecided')]
    table = class_table.cells(Class('', ['anna', 'ben', 'carl'], ['x', 'y'], results, {'x': 2.0}))
    assert [row[:4] for row in table] == [  # without columns after the mean
        ['student', 'x', 'y', 'mean'], ['anna', '90', '60', '80.0'],  # (2 * 90 + 60) / 3
        ['ben', '50', '', '33.3'], ['carl', '', 'undecided', '']]


@pytest.mark.parametrize('attempts, score', [
    ([('failed', 70.0), ('passed', 80.0), ('undecided', 0.0)], '80'),
    ([('failed', 90.0), ('passed', 80.0)], '80'),  # 90 points, but a required check failed
    ([('undecided', 0.0), ('failed', 0.0)], '0'),
    ([('undecided', 0.0)], 'undecided')])
def test_the_best_attempt_is_in_the_table(attempts, score):
    results = [graded('anna', 'x', points, outcome, attempt=str(number))
               for number, (outcome, points) in enumerate(attempts)]
    assert class_table.cells(Class('', ['anna'], ['x'], results))[1][1] == score
    assert len(list(csv.reader(io.StringIO(class_results.as_rows(results))))) == len(attempts) + 1


def test_the_level_of_isolation_is_in_every_table():
    results = [graded('anna', 'x', 90.0)._replace(isolation='namespace'), graded('ben', 'x', 90.0),
               *(graded('carl', name, 90.0)._replace(isolation='none') for name in 'xy')]
    rows = list(csv.DictReader(io.StringIO(class_results.as_rows(results))))
    assert [row['isolation'] for row in rows] == ['namespace', '', 'none', 'none']
    suites = ElementTree.fromstring(class_results.as_junit(results))
    assert [[one.get('value') for one in suite.iter('property')] for suite in suites] == [
        ['namespace'], [], ['none'], ['none']]
    a_class = Class('', ['anna', 'ben', 'carl'], ['x', 'y'], results)
    page = class_page.of_class(a_class, '.')
    assert '<p>Isolation: namespace 1, none 2</p>' in page
    assert '<p class="warning">2 of 4: NO ISOLATION: the programs can read and change everything' in page
    alone = Class('', ['anna'], ['x'], results[:1])
    assert 'class="warning"' not in class_page.of_class(alone, '.')


def test_notes_are_on_the_pages():
    noted = graded('anna', 'x', 100.0)._replace(notes=('the lines of /home/class/anna/x.py end with CR LF <Windows>',))
    for page in (class_page.of_class(Class('', ['anna'], ['x'], [noted]), '.'), class_page.of_student('anna', [noted])):
        assert '<p class="soft">Note: the lines of x.py end with CR LF &lt;Windows&gt;</p>' in page


WIDE = [['student', *(f'exercise_{letter}' for letter in 'abcdefghijkl'), 'mean'],
        ['Annabel Long-Name', *['12.5'] * 11, 'undecided', ''], ['\u7532\u4e59', *['100'] * 12, '100.0']]


@pytest.mark.parametrize('width', [30, 60, 80, 120, 200])
def test_a_table_fits_the_terminal(width):
    lines = terminal.table(WIDE, width)
    assert max(map(terminal.cells, lines)) <= width
    text = ' '.join(' '.join(lines).split())
    assert all(f'exercise_{letter}' in text for letter in 'abcdefghijkl')
    assert text.count('12.5') == 11 and '100.0' in text


def test_a_table_in_a_log_is_complete():
    lines = terminal.table(WIDE)
    assert lines[1].startswith('Annabel Long-Name  ') and 'undecided' in lines[1] and len(lines) == 3
    assert len({terminal.cells(line) for line in lines[::2]}) == 1


def test_the_line_of_a_grading_has_the_reason_that_cost_most():
    reasons = [scoring.Reason('moves', 20.0, 20.0, 'a path', '9 m'), scoring.Reason('stops', 8.0, 80.0, 'a stop', '11')]
    one = graded('anna', 'x', 28.0, 'failed', reasons=reasons)
    assert grade_all.progress(one, 2, 9) == ('[2/9] anna x: failed, 28 of 100, 1.5 s: '
                                             '8 of 80: asked: a stop; seen: 11')


def test_similar_programs_have_a_table_and_pages_that_an_old_run_leaves_none_of(tmp_path):
    results = [graded('anna', 'x', 90.0), graded('ben', 'x', 90.0)]
    pair = Pair('x', 'anna', 'ben', 0.934, ('print(1)\n', 'print(2)\n'))
    class_results.write(str(tmp_path), Class('', ['anna', 'ben'], ['x'], results, similar=[pair, pair]))
    rows = list(csv.reader(io.StringIO((tmp_path / 'similar.csv').read_text())))
    assert rows[1] == ['x', 'anna', 'ben', '93%', 'similar/1.html'] and len(rows) == 3
    assert '<a href="similar/1.html">x: anna and ben have 93% in common</a>' in (tmp_path / 'index.html').read_text()
    assert (tmp_path / 'similar' / '2.html').exists()
    class_results.write(str(tmp_path), Class('', ['anna', 'ben'], ['x'], results, similar=[pair]))
    assert not (tmp_path / 'similar' / '2.html').exists()


def test_the_page_counts_what_goes_wrong_in_each_exercise():
    def wrong(student, hint):
        one = graded(student, 'x', 40.0, 'failed', reasons=[Reason('draws', 0.0, 60.0, 'a circle', 'a path')])
        return one._replace(verdict=one.verdict._replace(hints=(hint, 'a second one')))
    results = [graded('anna', 'x', 100.0), wrong('ben', 'turn left'), wrong('carl', 'turn left'),
               wrong('dora', 'call spin'), graded('emil', 'x', 0.0, 'undecided')]
    page = class_page.of_class(Class('', ['anna', 'ben', 'carl', 'dora', 'emil'], ['x'], results), '.')
    row = ' '.join(page.partition('most frequent mistakes')[2].partition('</tbody>')[0].split())
    assert '<td>5</td><td>1</td><td>55.0</td>' in row  # (100 + 3 * 40) / 4; emil is undecided
    assert '2 × turn left<br> 1 × call spin<br> 3 × a circle' in row.replace('<br>', '<br> ').replace('  ', ' ')
