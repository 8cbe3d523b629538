"""Scores and comments by hand: they count in all tables and survive every run; mistakes are named with their line."""
import argparse
import csv
import json

import pytest

from course_grader.classes import class_results, marks
from course_grader.classes.class_table import Class
from course_grader.classes.marks import Mark, MarksError
from unit_support.gradings import graded

RESULTS = [graded('anna', 'x', 40.0, 'failed'), graded('ben', 'x', 100.0), graded('carl', 'x', 0.0, 'undecided')]


@pytest.mark.parametrize('mark, score, outcome, told', [
    (Mark(85.0, '', 'shown in class'), 85.0, 'passed', 'by hand: 85 of 100 instead of 40: shown in class'),
    (Mark(79.5), 79.5, 'failed', 'by hand: 79.5 of 100 instead of 40'),
    (Mark(60.0, 'passed'), 60.0, 'passed', 'by hand: 60 of 100 instead of 40'),
    (Mark(None, '', 'see line 3'), 40.0, 'failed', 'by hand: see line 3'),
    (Mark(None, 'passed'), 40.0, 'passed', 'by hand: passed')])
def test_what_is_given_counts(mark, score, outcome, told):
    one, other, _ = marks.apply(RESULTS, {('anna', 'x'): mark})[0]
    assert (one.score, one.outcome, one.verdict.main_reason()) == (score, outcome, told) and other == RESULTS[1]


def test_an_undecided_one_can_be_decided_and_a_misspelt_one_is_named():
    given, unknown = marks.apply(RESULTS, {('carl', 'x'): Mark(90.0), ('ana', 'x'): Mark(1.0)})
    assert given[2].outcome == 'passed' and 'instead of undecided' in given[2].verdict.main_reason()
    assert unknown == ['marks.csv: ana/x has not been handed in. Did you mean anna/x?']


def test_the_file_survives_and_is_in_all_tables(tmp_path, capsys):
    text = '\ufeffexercise, student, score, comment\nx, anna, 85, "good, but late"\ny, anna, 5,\n'
    (tmp_path / 'marks.csv').write_text(text, encoding='utf-8')
    options = argparse.Namespace(format='text', output=str(tmp_path), student_pages=True, anonymous=False)
    for _ in range(2):
        class_results.check_output(str(tmp_path))
        class_results.show(options, Class('', ['anna', 'ben', 'carl'], ['x'], RESULTS), RESULTS)
    assert (tmp_path / 'marks.csv').read_text(encoding='utf-8') == text
    assert 'marks.csv: anna/y has not been handed in' in capsys.readouterr().out
    with open(tmp_path / 'grades.csv', encoding='utf-8', newline='') as file:
        anna = next(csv.DictReader(file))
    assert (anna['score'], anna['verdict']) == ('85', 'passed')
    assert anna['reason'] == 'by hand: 85 of 100 instead of 40: good, but late'
    assert 'good, but late' in (tmp_path / 'pages' / 'anna.html').read_text()
    assert json.loads((tmp_path / 'class.json').read_text())['students'] == ['anna', 'ben', 'carl']


@pytest.mark.parametrize('text, said', [
    ('student,exercise,points\n', "it has 'points'"), ('student,score\n', 'it lacks exercise'),
    ('', 'it lacks student'),
    ('student,exercise,score\nanna,x,120\n', "line 2: the score is '120'; it must be a number from 0 to 100"),
    ('student,exercise,score\nanna,x,90\nben,x,"8,5"\n', "line 3: the score is '8,5'"),
    ('student,exercise,score\nanna,x,nan\n', "line 2: the score is 'nan'"),
    ('student,exercise,handed_in\nanna,x,2026-11-20\n', "line 2: handed_in is '2026-11-20'; write date and time"),
    ('student,exercise,verdict\nanna,x,good\n', "line 2: the verdict is 'good'; it must be passed or failed"),
    ('student,exercise,comment\nanna,x,good, but late\n', 'line 2: it has another number of columns'),
    ('student,exercise,comment\nanna\n', 'line 2: it has another number of columns'),
    ('\xe4', 'is not CSV in UTF-8')])
def test_mistakes_are_named_before_anything_is_graded(tmp_path, text, said):
    (tmp_path / 'marks.csv').write_bytes(text.encode('latin-1'))
    with pytest.raises(MarksError) as error:
        class_results.check_output(str(tmp_path))
    assert said in str(error.value)


@pytest.mark.parametrize('name', ['grades.csv', 'scores.csv', 'index.html', 'similar/a.txt', 'pages/anna.html',
                                  'moodle.csv'])
def test_files_of_the_teacher_are_not_replaced_by_those_of_a_class(tmp_path, name):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text('of last year')
    (tmp_path / 'marks.csv').write_text('student,exercise\n')  # is written before the first run
    with pytest.raises(class_results.ClassError, match=f'has {name.partition("/")[0]}, which this would replace'):
        class_results.check_output(str(tmp_path))
    assert (tmp_path / name).read_text() == 'of last year'
    (tmp_path / 'class.json').write_text('{}')
    class_results.check_output(str(tmp_path))
