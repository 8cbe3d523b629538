"""The tables that Moodle and Canvas import, by the columns that their importers look for."""
import csv

import pytest

from course_grader.classes import class_results
from course_grader.classes.class_table import Class
from course_grader.formats.platforms import Origin
from course_grader.rules.scoring import Reason
from unit_support.gradings import graded

RESULTS = [graded('Anna Berg', 'x', 100.0), graded('Anna Berg', 'y', 40.0, 'failed', [
    Reason('stops', 0.0, 60.0, 'a stop at x = 10', '=it never stopped')]), graded('Ben Li', 'x', 0.0, 'undecided')]
STUDENTS = ['Anna Berg', 'Ben Li', 'Carl', 'Nobody']


def rows(folder, origin):
    a_class = Class('', STUDENTS, ['x', 'y'], RESULTS, origin=origin)
    class_results.write(str(folder), a_class)
    with open(folder / f'{origin.platform}.csv', encoding='utf-8', newline='') as file:
        return list(csv.reader(file))


def test_moodle_takes_the_grading_worksheet(tmp_path):
    table = rows(tmp_path, Origin('moodle', {'Anna Berg': '1234', 'Ben Li': '77', 'Carl': '5'}))
    comment = RESULTS[1].verdict.main_reason()
    assert table == [
        ['Identifier', 'Full name', 'Grade', 'Last modified (grade)', 'Feedback comments'],
        ['Participant 1234', 'Anna Berg', '70.0', '', f'x: 100 of 100; y: 40 of 100: {comment}'],
        ['Participant 77', 'Ben Li', '', '', 'x: undecided'],  # an empty grade is not imported
        ['Participant 5', 'Carl', '', '', '']] and '=it never stopped' in comment


def test_canvas_takes_a_gradebook(tmp_path):
    table = rows(tmp_path, Origin('canvas', {'Anna Berg': '1234', 'Ben Li': '77'}))
    assert table == [['Student', 'ID', 'SIS User ID', 'SIS Login ID', 'Section', 'x', 'y'],
                     ['    Points Possible', '', '', '', '', '100', '100'],
                     ['Anna Berg', '1234', '', '', '', '100', '40'], ['Ben Li', '77', '', '', '', '', '']]


@pytest.mark.parametrize('origin', [Origin(), Origin('gradescope', {'Anna Berg': '1'}), Origin('moodle', {})])
def test_others_import_nothing(tmp_path, origin):
    class_results.write(str(tmp_path), Class('', STUDENTS, ['x', 'y'], RESULTS, origin=origin))
    assert not list(tmp_path.glob('moodle.csv')) + list(tmp_path.glob('gradescope.csv'))


def test_merged_parts_keep_the_numbers(tmp_path):
    origin = Origin('canvas', {'Anna Berg': '1234'})
    options = class_results.argparse.Namespace(format='csv', output=str(tmp_path), student_pages=False, anonymous=False)
    class_results.show(options, Class('', STUDENTS, ['x', 'y'], RESULTS, origin=origin), RESULTS)
    assert class_results.read(str(tmp_path))[-1] == origin
