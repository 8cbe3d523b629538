"""The grader's command line, and attempts that fail before or beside ROS."""
import csv
import json
import sys

import pytest

from course_grader import cli
from course_grader.attempt import attempt
from course_grader.formats import exit_codes
from course_grader.rules import exercise
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import Supervisor
from process_support import processes

OF_ROSTEST = ['--gtest_output=xml:/r/x.xml', '__name:=stop', '__log:=/r/stop.log']


@pytest.fixture(autouse=True)
def signals_stay(monkeypatch):
    """Leave the signals to pytest."""
    monkeypatch.setattr(processes, 'make_interruptible', lambda: None)


@pytest.mark.parametrize('arguments, rest, junit', [
    (['stop_at_x', '--', 'a.py', '_x:=3'], ['stop_at_x', '--', 'a.py', '_x:=3'], None),
    (['stop_at_x', '--', 'a.py', '_x:=3', *OF_ROSTEST], ['stop_at_x', '--', 'a.py', '_x:=3'], '/r/x.xml'),
    (['stop_at_x', '--', 'a.py', '__name:=mine', 'last', *OF_ROSTEST],
     ['stop_at_x', '--', 'a.py', '__name:=mine', 'last'], '/r/x.xml'),
    (['stop_at_x', '--', 'rosrun', 'a', 'b', '__name:=mine'], ['stop_at_x', '--', 'rosrun', 'a', 'b', '__name:=mine'],
     None),
    ([], [], None),
])
def test_what_rostest_adds_is_not_the_programs(arguments, rest, junit):
    assert cli._without_rostest(arguments) == (rest, junit)


@pytest.mark.parametrize('arguments, said', [
    (['no_such_exercise', '--', 'a.py'], "there is no exercise 'no_such_exercise'; give the path of an exercise file"),
    (['stop_at_x', '--format', 'classroom50', '--', 'a.py'], '--format classroom50 needs CLASSROOM, ASSIGNMENT'),
    (['stop_at_x', '--seed', 'x', '--', 'a.py'], "--seed: invalid int value: 'x'"),
])
def test_wrong_usage_is_explained(monkeypatch, capsys, arguments, said):
    monkeypatch.setattr(sys, 'argv', ['grade.py', *arguments])
    try:
        code = cli.main()
    except SystemExit as end:
        code = end.code
    assert code == exit_codes.USAGE and said in capsys.readouterr().err


@pytest.mark.parametrize('program, said', [
    (['none.py'], 'none.py does not exist'), ([], 'the command is missing'),
    (['broken.py'], 'broken.py, line 1: SyntaxError'),
])
def test_a_program_that_cannot_run_fails_with_the_reason(tmp_path, monkeypatch, capsys, program, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'broken.py').write_text('print 1\n')
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--junit', 'second.xml', '--', *program])
    assert cli.main() == 1
    result = json.loads((tmp_path / 'output' / 'grades' / 'stop_at_x' / 'result.json').read_text())
    assert result['outcome'] == 'failed' and said in result['objections'][0]
    assert said.replace("'", '') in capsys.readouterr().out
    assert (tmp_path / 'second.xml').read_bytes() == \
        (tmp_path / 'output' / 'grades' / 'stop_at_x' / 'junit.xml').read_bytes()


def test_a_format_has_standard_output_for_itself(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'broken.py').write_text('print 1\n')
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--format', 'csv', '--', 'broken.py'])
    assert cli.main() == 1
    rows = list(csv.DictReader(capsys.readouterr().out.splitlines()))
    assert [(row['program'], row['score'], row['verdict']) for row in rows] == [('broken.py', '0', 'failed')]


def test_a_system_is_recognized_by_its_environment(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'broken.py').write_text('print 1\n')
    for name, value in (('VPL_GRADEMIN', '0'), ('VPL_GRADEMAX', '10')):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--', 'broken.py'])
    assert cli.main() == 0
    assert capsys.readouterr().out.endswith('--|>\nGrade :=>> 0\n')


@pytest.mark.parametrize('error, said', [
    (RuntimeError('out of luck'), 'the grader itself failed: RuntimeError: out of luck'),
    (attempt.AttemptError('no port'), 'no port'),
])
def test_an_attempt_that_fails_decides_nothing(tmp_path, monkeypatch, error, said):
    def crash(_):
        raise error
    (tmp_path / 'a.py').write_text('')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(attempt, '_set_environment', lambda environment: None)
    monkeypatch.setattr(attempt.Attempt, 'run', crash)
    chosen = exercise.load(cli.exercises()['stop_at_x'])
    got = attempt.run(Job(chosen, ('a.py',), str(tmp_path), str(tmp_path / 'out'), 1))
    assert (got.verdict.outcome, got.verdict.objections) == ('undecided', [said])


def test_an_interruption_is_said(tmp_path, monkeypatch, capsys):
    def interrupt(*_, **__):
        raise KeyboardInterrupt
    monkeypatch.setattr(Supervisor, 'grade', interrupt)
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--output', str(tmp_path), '--', 'a.py'])
    assert cli.main() == exit_codes.INTERRUPTED
    assert 'interrupted; all its processes have ended' in capsys.readouterr().err


def test_output_that_cannot_be_written_is_named(tmp_path, monkeypatch, capsys):
    (tmp_path / 'file').write_text('')
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--output', f'{tmp_path}/file/x', '--', 'none.py'])
    assert cli.main() == exit_codes.USAGE
    assert 'file/x cannot be written: Not a directory. Choose another folder with --output' in capsys.readouterr().err


@pytest.mark.parametrize('after, flooded', [
    ({'1': (0.5, 0.0), '2': (0.1, 3.0)}, False),  # ran for 5 % of 10 s; the machine was busy
    ({'1': (6.0, 0.0)}, True), ({'1': (2.0, 7.0)}, True),  # 2 of the 3 s for which it got a core
    ({'1': (9.0, 0.0), '2': (0.0, 0.0)}, True), ({'3': (7.0, 0.0)}, True),  # a thread that is new
])
def test_a_simulator_is_flooded_when_it_runs_whenever_it_can(after, flooded):
    assert attempt._flooded({'1': (0.0, 0.0), '2': (0.0, 0.0)}, after, 10.0) is flooded
