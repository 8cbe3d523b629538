"""Deadlines: what late programs lose, whose deadline counts, which dates count, and what students see before and after.
"""
import argparse
import csv
import json
import os
import time

import pytest

from course_grader import cli
from course_grader.classes import class_results, deadlines, grade_all
from course_grader.classes.class_table import Class
from course_grader.classes.deadlines import Deadline
from course_grader.classes.marks import Mark, MarksError
from course_grader.formats import platforms
from course_grader.formats.platforms import Origin
from course_grader.rules.scoring import Reason
from unit_support import course_files, gradings

EXERCISES = {'stop_at_x': str(course_files.EXERCISES['stop_at_x'])}
DUE = time.mktime((2026, 11, 20, 18, 0, 0, 0, 0, -1))  # 2026-11-20 18:00 on this machine
TEN_A_DAY = {('*', '*'): Deadline(DUE, 10.0)}
REASONS = [Reason('moves', 20.0, 20.0, 'a path', '4 m'),
           Reason('stops', 0.0, 50.0, 'a secret stop', 'none', 'after the deadline'),
           Reason('pen', 30.0, 30.0, 'a secret colour', 'red', 'never')]


def graded(handed_in, score=90.0, outcome='passed', student='anna', reasons=()):
    return gradings.graded(student, 'x', score, outcome, reasons, handed_in=handed_in)


@pytest.mark.parametrize('handed_in, score, told', [
    ('2026-11-20 17:59', 90.0, ''), ('2026-11-20 18:00', 90.0, ''), ('', 90.0, ''),
    ('2026-11-20 18:01', 80.0, 'handed in 1 min late, at 2026-11-20 18:01; the deadline was 2026-11-20 18:00: '
                               '10 points less than 90'),
    ('2026-11-21 17:00', 80.0, 'handed in 23 h late, '), ('2026-11-21 20:00', 70.0, 'handed in 1 day 2 h late, '),
    ('2026-12-20 18:00', 0.0, 'handed in 30 days 0 h late, '),
    ('late', 80.0, 'handed in late, as the platform says, which counts as one day; ')])
def test_a_late_program_loses_points_for_each_day(handed_in, score, told):
    (one,), _ = deadlines.apply([graded(handed_in)], TEN_A_DAY, {}, DUE)
    assert (one.score, one.outcome) == (score, 'passed')  # the verdict is about the program
    assert one.verdict.main_reason().startswith(told) and bool(told) == bool(one.verdict.objections)


def test_without_points_a_late_program_is_only_named_and_an_undecided_one_waits():
    late = graded('2026-11-21 17:00')
    (one, other), _ = deadlines.apply([late, late._replace(verdict=late.verdict._replace(outcome='undecided'))],
                                      {('*', 'x'): Deadline(DUE)}, {}, DUE)
    assert one.score == 90.0 and one.verdict.main_reason().endswith('the deadline was 2026-11-20 18:00')
    assert other.verdict.objections == []


@pytest.mark.parametrize('place, expected', [
    (('anna', 'x'), 4.0), (('anna', 'y'), 3.0), (('ben', 'x'), 2.0), (('ben', 'y'), 1.0)])
def test_the_deadline_of_a_student_goes_first(place, expected):
    known = {('*', '*'): Deadline(1.0), ('*', 'x'): Deadline(2.0), ('anna', '*'): Deadline(3.0),
             ('anna', 'x'): Deadline(4.0)}
    assert deadlines.of(place, known).at == expected
    assert deadlines.of(place, {}).at == float('inf')


def test_a_date_by_hand_goes_first_and_unknown_ones_are_counted():
    results = [graded('2026-11-20 18:30'), graded('', student='ben'), graded('', student='carl')]
    given = {('anna', 'x'): Mark(handed_in='2026-11-20 17:00'), ('ben', 'x'): Mark(handed_in='2026-11-20 19:00')}
    applied, notes = deadlines.apply(results, TEN_A_DAY, given, DUE)
    assert [one.score for one in applied] == [90.0, 80.0, 90.0]
    assert len(notes) == 1 and notes[0].startswith('1 of 3 submissions count as in time, because nothing says when')


@pytest.mark.parametrize('text, said', [
    ('exercise\n', 'it lacks deadline'), ('exercise,deadline,points\n', "it has 'points'"),
    ('exercise,deadline\n*,2026-11-20\n', "line 2: the deadline is '2026-11-20'; write date and time, such as "
                                          '2026-11-20 18:00'),
    ('exercise,deadline\n*,soon: now\n', "the deadline is 'soon: now'"),
    ('exercise,deadline,points_per_day\n*,2026-11-20 18:00,-1\n', "line 2: points_per_day is '-1'; it must be a ")])
def test_mistakes_are_named_before_anything_is_graded(tmp_path, text, said):
    (tmp_path / 'deadlines.csv').write_text(text)
    with pytest.raises(MarksError) as error:
        class_results.check_output(str(tmp_path))
    assert said in str(error.value)


def shown(tmp_path, deadline, results, marks=''):
    (tmp_path / 'deadlines.csv').write_text(f'exercise,deadline,points_per_day,student\n*,{deadline},10,\n')
    (tmp_path / 'marks.csv').write_text(marks or 'student,exercise\n')
    options = argparse.Namespace(format='text', output=str(tmp_path), student_pages=True, anonymous=False)
    class_results.show(options, Class('', ['anna'], ['x'], results, origin=Origin('moodle', {'anna': '7'})), results)
    return {name: (tmp_path / name).read_text() for name in ('index.html', 'pages/anna.html', 'moodle.csv')}


@pytest.mark.parametrize('deadline, seen', [('2999-01-01 18:00', 0), ('2001-01-01 18:00', 1)])
def test_students_see_a_check_after_the_deadline(tmp_path, deadline, seen):
    pages = shown(tmp_path, deadline, [graded('', 50.0, 'failed', reasons=REASONS)])
    assert ('a secret stop' in pages['pages/anna.html'], 'a secret stop' in pages['moodle.csv']) == (seen, seen)
    assert ('80 points are for checks' in pages['pages/anna.html']) == (not seen)
    assert all('a secret colour' not in pages[name] for name in ('pages/anna.html', 'moodle.csv'))
    for secret in ('a secret stop', 'a secret colour', 'students see it after the deadline', 'students do not see it'):
        assert secret in pages['index.html']


def test_what_is_given_by_hand_is_not_reduced(tmp_path):
    shown(tmp_path, '2026-11-20 18:00', [graded('2026-11-21 17:00')], 'student,exercise,score\nanna,x,85\n')
    with open(tmp_path / 'grades.csv', newline='') as file:
        anna = next(csv.DictReader(file))
    assert (anna['score'], anna['reason']) == ('85', 'by hand: 85 of 100 instead of 80')


def test_the_dates_of_files_count_only_where_the_teacher_says_so(tmp_path):
    (tmp_path / 'anna').mkdir()
    program = tmp_path / 'anna' / 'stop_at_x.py'
    program.write_text('')
    os.utime(program, (DUE + 60.0, DUE + 60.0))
    for options, expected in (([], ''), (['--file-dates'], '2026-11-20 18:01')):
        parsed = cli.parse(['--all', str(tmp_path), '--output', str(tmp_path / 'out'), *options])
        assert grade_all._class(parsed, EXERCISES).submissions[0].handed_in == expected


WORKSHEET = ('Identifier,"Full name","Email address",Status,Grade,"Last modified (submission)"\n'
             'Participant 11,"Anna Berg",,Submitted,,"Saturday, 21 November 2026, 5:00 PM"\n'
             'Participant 12,"Ben Carl",,"No submission",,-\n')


def moodle_class(tmp_path, worksheet, names=('Anna Berg_11', 'Ben Carl_12')):
    for name in names:
        folder = tmp_path / 'class' / f'{name}_assignsubmission_file_'
        folder.mkdir(parents=True)
        (folder / 'stop_at_x.py').write_text('')
    (tmp_path / 'worksheet.csv').write_text(worksheet)
    options = cli.parse(['--all', str(tmp_path / 'class'), '--output', str(tmp_path / 'out'), '--worksheet',
                         str(tmp_path / 'worksheet.csv')])
    return grade_all._class(options, EXERCISES)


@pytest.mark.parametrize('text, expected', [
    ('Saturday, 21 November 2026, 5:00 PM', '2026-11-21 17:00'),
    ('Saturday, 21 Nov 2026, 12:05 AM', '2026-11-21 00:05'),
    ('21 November 2026, 17:00', '2026-11-21 17:00'), ('2026-11-21 17:00', '2026-11-21 17:00')])
def test_the_worksheet_of_moodle_says_when_a_student_has_handed_in(tmp_path, text, expected):
    found = moodle_class(tmp_path, WORKSHEET.replace('Saturday, 21 November 2026, 5:00 PM', text))
    assert [one.handed_in for one in found.submissions] == [expected, '']


@pytest.mark.parametrize('old, new, said', [
    ('(submission)', '(Abgabe)', "no columns 'Identifier' and 'Last modified .submission.'.*language of Moodle"),
    ('Saturday, 21 November', 'Samstag, 21. November', "line 2: .* is 'Samstag, .*such as Friday, 20 November 2026"),
    ('Participant 11', 'Participant 99', 'none of the students .*worksheet of the same assignment')])
def test_a_worksheet_that_cannot_be_used_is_named(tmp_path, old, new, said):
    with pytest.raises((platforms.WorksheetError, class_results.ClassError), match=f'worksheet.csv.*{said}'):
        moodle_class(tmp_path, WORKSHEET.replace(old, new))


def test_a_worksheet_needs_a_download_of_moodle(tmp_path):
    (tmp_path / 'class' / 'anna').mkdir(parents=True)
    (tmp_path / 'class' / 'anna' / 'stop_at_x.py').write_text('')
    with pytest.raises(class_results.ClassError, match='--worksheet .*what Moodle gives to download'):
        moodle_class(tmp_path, WORKSHEET, names=())


def test_dates_survive_a_merge(tmp_path, capsys):
    shown(tmp_path, '2026-11-20 18:00', [graded('2026-11-21 17:00')])
    assert json.loads((tmp_path / 'class.json').read_text())['submissions'] == [['anna', 'x', '', '2026-11-21 17:00']]
    cli.main(['--merge', str(tmp_path), '--output', str(tmp_path / 'all')])
    assert json.loads((tmp_path / 'all' / 'class.json').read_text())['submissions'][0][3] == '2026-11-21 17:00'
