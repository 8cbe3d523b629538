"""The grader's command line, and attempts that fail before or beside ROS."""
import csv
import json
import os
import re
import sys

import pytest
import yaml

from course_grader import cli
from course_grader.attempt import attempt
from course_grader.classes import live
from course_grader.formats import exit_codes
from course_grader.rules import exercise, registry
from course_grader.supervision import supervisor
from course_grader.supervision.job import Job
from course_grader.supervision.supervisor import Supervisor
from plain_support import processes

OF_ROSTEST = ['--gtest_output=xml:/r/x.xml', '__name:=stop', '__log:=/r/stop.log']


CALLING = """
title: T
time: 10 s
stimuli:
  - {do: call, service: /s, type: TYPE, request: [2 m, 3 m]}
checks:
  - {check: answers, points: 100, service: /s}
"""


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
    (['stop_at_y', '--', 'a.py'], 'robot_square, robot_circle, robot_triangle, '),
    (['stop_at_y', '--', 'a.py'], 'Did you mean stop_at_x?'),
    (['stop_at_x', 'a.py'], 'two dashes are missing between the exercise and the program; type:\n'
     '  ./run grade stop_at_x -- a.py'),
    (['stop_at_x', '--seed', '5', 'a b.py', '--fast'], "  ./run grade stop_at_x --seed 5 -- 'a b.py' --fast"),
    (['stop_at_x', 'stop_at_x'], '  ./run grade stop_at_x -- stop_at_x\n'),
    (['stop_at_x', '--fast', '--', 'a.py'], 'there is no option --fast; options of the program come after the two '
     'dashes:\n  ./run grade stop_at_x -- a.py --fast'),
    (['stop_at_x'], 'the program is missing; type, for example:\n  ./run grade stop_at_x -- stop_at_x.py'),
    (['/a/mine.yaml', '--seed', '5', '--'], '  ./run grade /a/mine.yaml --seed 5 -- mine.py'),
    (['stop_at_x', '--', 'a.py', '_x:=3'], 'a.py does not exist (current folder: '),
    (['stop_at_x', '--', 'python3', 'a.py'], 'a.py does not exist (current folder: '),
    (['stop_at_x', '--', 'no_such_program'], 'no_such_program does not exist (current folder: '),
    (['stop_at_x', '--', './stop.pi'], 'Did you mean ./stop.py? Name the file as seen from here'),
    (['stop_at_x', '--', 'python3', './stp.py'], 'Did you mean ./stop.py? Name the file as seen from here'),
    (['stop_at_x', '--', 'python3', './stp.py'], '-- python3 /FULL/PATH/stp.py'),
    ([], 'the following arguments are required: exercise'),
    (['--new', 'stop.py'], 'stop.py exists already; choose another name'),
    (['--new', 'none/x.yaml'], 'none/x.yaml cannot be written: No such file or directory'),
    (['typo.yaml', '--', 'stop.py'], 'typo: stimulus 1 (call): type: there is no service type turtlesim/Teleport here'),
    (['--all', '.', '--output', 'out'], 'typo: stimulus 1 (call): type: there is no service type'),
    (['stop_at_x', '--seed', 'x', '--', 'a.py'], "--seed: invalid int value: 'x'"),
    (['none', '--all', '--fast'], './run grade --all: error: unrecognized arguments: --fast'),
    (['--list', 'yaml'], "./run grade --list: error: argument format: invalid choice: 'yaml'"),
    (['--new'], './run grade --new: error: the following arguments are required: FILE'),
    (['--sheet', 'Anna'], './run grade --sheet: error: the exercises are missing, such as: ./run grade --sheet'),
])
def test_wrong_usage_is_explained(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / 'stop.py').write_text('')
    (tmp_path / 'typo.yaml').write_text(CALLING.replace('TYPE', 'turtlesim/Teleport'))
    (tmp_path / 'anna').mkdir()
    (tmp_path / 'anna' / 'typo.py').write_text('')
    monkeypatch.setattr(sys, 'argv', ['grade.py', *arguments])
    try:
        code = cli.main()
    except SystemExit as end:
        code = end.code
    assert code == exit_codes.USAGE and said in capsys.readouterr().err


@pytest.mark.parametrize('name, said', [
    ('turtlesim/TeleportRelative', None), ('turtlesim/TeleportAbsolute', 'request has 2 numbers, but turtlesim/Teleport'
                                           'Absolute takes 3: x, y, theta'),
    ('std_srvs/Empty', 'request has 2 numbers, but std_srvs/Empty takes 0: none'),
    ('turtlesim/Kill', 'type: turtlesim/Kill has name (string), but the grader sends numbers only'),
    ('no_such_package/Go', 'type: there is no service type no_such_package/Go here'),
])
def test_the_services_of_an_exercise_are_checked(tmp_path, name, said):
    (tmp_path / 'mine.yaml').write_text(CALLING.replace('TYPE', name))
    if said is None:
        assert cli.load(tmp_path / 'mine.yaml').name == 'mine'
    else:
        with pytest.raises(exercise.ExerciseError, match='mine: stimulus 1 .call.: ' + re.escape(said)):
            cli.load(tmp_path / 'mine.yaml')


def test_a_new_exercise_can_be_graded_as_it_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(['--new', 'mine.yaml']) == 0 and 'Wrote mine.yaml. Edit it' in capsys.readouterr().out
    made = cli.load('mine.yaml')
    assert made.name == 'mine' and made.asks and made.rules
    text = (tmp_path / 'mine.yaml').read_text()
    assert all(f'\n{key}: ' in text or f'\n# {key}:' in text or f'\n{key}:\n' in text for key in exercise.KEYS)
    assert exercise.parse(yaml.safe_load(re.sub(r'(?m)^# (stimuli:|  - )', r'\1', text))).stimuli  # as a teacher would
    assert max(map(len, text.splitlines())) <= 120


def test_checks_are_listed_with_their_parameters(capsys):
    assert cli.main(['--checks']) == 0
    printed = capsys.readouterr().out
    words = set(re.findall(r'^ *(\w+)', printed, re.MULTILINE))
    assert {*registry.RULES, *exercise.STIMULI, *exercise.KEYS}.issubset(words)
    assert {name for rule in registry.RULES.values() for name in rule.parameters()} <= words
    assert max(map(len, printed.splitlines())) <= 120


def test_a_program_that_was_not_handed_in_scores_0_in_a_system(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(['stop_at_x', '--format', 'autolab', '--', 'none.py']) == 0
    said = capsys.readouterr().out
    assert 'none.py does not exist' in said and said.endswith('{"scores": {"stop_at_x": 0.0}}\n')


@pytest.mark.parametrize('program, said', [
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
    (tmp_path / 'a.py').write_text('')
    monkeypatch.setattr(Supervisor, 'grade', interrupt)
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--output', str(tmp_path), '--', f'{tmp_path}/a.py'])
    assert cli.main() == exit_codes.INTERRUPTED
    assert 'interrupted; all its processes have ended' in capsys.readouterr().err


@pytest.mark.parametrize('there, refused', [
    (['output.txt'], 'output.txt'), (['path.png', 'stop.py', 'junit.xml'], 'junit.xml, path.png'), (['stop.py'], ''),
    (['result.json', 'output.txt'], ''), (['grader.txt', 'path.png'], ''), ([], '')])
def test_files_that_no_grading_has_written_are_not_replaced(tmp_path, monkeypatch, capsys, there, refused):
    (tmp_path / 'program.py').write_text('')
    folder = tmp_path / 'results'
    folder.mkdir()
    for name in there:
        (folder / name).write_text('mine')

    def interrupt(*_):
        raise KeyboardInterrupt
    monkeypatch.setattr(Supervisor, 'grade', interrupt)
    code = cli.main(['stop_at_x', '--output', str(folder), '--', f'{tmp_path}/program.py'])
    said = capsys.readouterr().err
    assert code == (exit_codes.USAGE if refused else exit_codes.INTERRUPTED)
    assert (f'{folder} has {refused}, which this would replace' in said) is bool(refused)
    assert sorted(path.name for path in folder.iterdir()) == sorted(there)


def test_results_that_are_being_removed_are_still_known_as_results(tmp_path, monkeypatch):
    for name in supervisor.RESULTS:
        (tmp_path / name).write_text('')
    removed = os.remove

    def remove(path):
        removed(path)
        assert supervisor.others_of(str(tmp_path)) == []
    monkeypatch.setattr(supervisor.os, 'remove', remove)
    supervisor.remove_results(str(tmp_path))
    assert list(tmp_path.iterdir()) == []


def test_output_that_cannot_be_written_is_named(tmp_path, monkeypatch, capsys):
    (tmp_path / 'file').write_text('')
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--output', f'{tmp_path}/file/x', '--', 'true'])
    assert cli.main() == exit_codes.USAGE
    assert 'file/x cannot be written: Not a directory. Choose another folder with --output' in capsys.readouterr().err


@pytest.mark.parametrize('arguments, variable, address', [
    ([], None, None), (['--report', 'http://a/b'], None, 'http://a/b'), ([], 'http://a/c', 'http://a/c')])
def test_nothing_is_reported_unless_the_student_asks_for_it(monkeypatch, arguments, variable, address):
    monkeypatch.delenv(live.VARIABLE, raising=False)
    if variable:
        monkeypatch.setenv(live.VARIABLE, variable)
    assert cli.parse(['stop_at_x', *arguments, '--', 'a.py']).report == address


def test_a_wrong_address_is_refused_before_the_grading(capsys):
    assert cli.main(['stop_at_x', '--report', '192.168.1.5:8130', '--', 'true']) == 2
    assert "the address to report to is '192.168.1.5:8130'; copy it whole" in capsys.readouterr().err


@pytest.mark.parametrize('typed, name, rest', [
    ([], cli.GRADE, []), (['x', '--seed', '3'], cli.GRADE, ['x', '--seed', '3']), (['--all', 'f'], '--all', ['f']),
    (['f', '--best', '--all'], '--all', ['f', '--best']), (['--new=x.yaml'], '--new', ['x.yaml'])])
def test_a_command_may_stand_anywhere(typed, name, rest):
    assert cli._command(typed) == (name, rest)


def test_exercises_are_listed_that_need_no_more_options(capsys):
    assert cli.main(['--list']) == cli.main(['--list', 'json']) == 0
    lines = capsys.readouterr().out.splitlines()
    listed = json.loads(lines[-1])
    assert [line.split(None, 1) for line in lines[:-1]] == [[one['name'], one['title']] for one in listed]
    assert len(listed) > 20 and all(one['asks'] for one in listed)


@pytest.mark.parametrize('command, words', [
    ([], ['EXERCISE [--seed N]', '--all FOLDER ...', 'Exit code: 0 passed', '--isolation', 'robot_square']),
    (['--all'], ['./run grade --all ', '--exercise NAME', 'output/grades', '--dask']),
    (['--merge'], ['./run grade --merge ', '--weights']), (['--live'], ['./run grade --live ', '--port'])])
def test_help_is_that_of_the_command(capsys, command, words):
    with pytest.raises(SystemExit) as end:
        cli.main([*command, '--help'])
    said = capsys.readouterr().out
    assert end.value.code == 0 and [word for word in words if word not in said] == []
