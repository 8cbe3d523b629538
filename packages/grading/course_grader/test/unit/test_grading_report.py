"""course_grader.formats.report: the printed and written forms of a verdict."""
import json
import os
from xml.etree import ElementTree

from course_grader.formats import report
from course_grader.rules import exercise, scoring
from course_grader.rules.observation import OutputLine
from unit_support.course_files import EXERCISES
from unit_support.graded_turtle import GradedTurtle

CIRCLE = exercise.load(EXERCISES['publish_circle'])
COMMAND = ['rosrun', 'a', 'b.py']


def graded(**drive):
    turtle = GradedTurtle(4.5, 3.0)
    turtle.drive(**{'seconds': 33.0, 'linear': 0.5, 'angular': 0.2, 'say': lambda pose: 'v 0.5', **drive})
    return turtle.observed, scoring.decide(CIRCLE, turtle.observed)


def test_the_text_says_what_was_asked_and_seen():
    text = report.text(CIRCLE, graded(angular=-0.2)[1])
    assert 'A publisher that drives a circle: FAILED' in text
    assert 'asked: velocity commands: linear.x 0.45 to 0.55 m/s' in text and 'angular.z -0.20 rad/s' in text
    assert max(map(len, text.splitlines())) <= report.WIDTH


def test_all_files_are_written(tmp_path):
    observed, decided = graded()
    report.write(tmp_path / 'new', CIRCLE, observed, decided, COMMAND, 7)
    assert sorted(os.listdir(tmp_path / 'new')) == ['junit.xml', 'output.txt', 'path.png', 'path.svg',
                                                       'result.json']
    result = json.loads((tmp_path / 'new' / 'result.json').read_text())
    assert (result['outcome'], result['score'], result['seed'], result['command']) == ('passed', 100.0, 7, COMMAND)
    assert [reason['points'] for reason in result['reasons']] == [40.0, 40.0, 10.0, 10.0]
    suite = ElementTree.parse(tmp_path / 'new' / 'junit.xml').getroot().find('testsuite')
    assert suite.get('name') == 'rosrun a b.py' and (suite.get('tests'), suite.get('failures')) == ('5', '0')
    assert (tmp_path / 'new' / 'output.txt').read_text().splitlines()[0].endswith('v 0.5')


def test_any_output_can_be_written(tmp_path):
    observed, decided = graded(seconds=1.0)
    observed.lines.append(OutputLine(0.5, 'bytes \udcff'))
    report.write(tmp_path, CIRCLE, observed, decided, COMMAND, 0)
    assert 'bytes ?' in (tmp_path / 'output.txt').read_text()
