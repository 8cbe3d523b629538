"""The grader's command line and the small parts of a session that need no ROS to run."""
import json
import sys

import pytest

from course_grader import cli
from course_grader.attempt import session
from course_grader.attempt.stimuli import take_line
from course_grader.formats import exit_codes
from course_grader.rules.observation import Call, Observed, ShownMarkers
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


@pytest.mark.parametrize('error, code, said', [
    (RuntimeError('out of luck'), 3, 'UNDECIDED'), (session.SessionError('no port'), 3, 'UNDECIDED'),
    (KeyboardInterrupt(), 130, 'interrupted; all its processes have ended'),
])
def test_a_grader_that_fails_decides_nothing(tmp_path, monkeypatch, capsys, error, code, said):
    def crash(_):
        raise error
    (tmp_path / 'a.py').write_text('')
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(session.Session, 'run', crash)
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--', 'a.py'])
    assert cli.main() == code
    assert said in ''.join(capsys.readouterr())


def test_output_that_cannot_be_written_is_named(tmp_path, monkeypatch, capsys):
    (tmp_path / 'file').write_text('')
    monkeypatch.setattr(sys, 'argv', ['grade.py', 'stop_at_x', '--output', f'{tmp_path}/file/x', '--', 'none.py'])
    assert cli.main() == exit_codes.USAGE
    assert 'file/x cannot be written: Not a directory. Choose another folder with --output' in capsys.readouterr().err


def test_stimuli_are_told_and_what_rospy_logs_is_left_out():
    observed = Observed()
    for line in ('{"ready": true}', '[ERROR] [12.5]: md5sum mismatch', '["Call", 1.5, "/s", [1.0, 2.0], true, ""]',
                 '["ShownMarkers", 2.0, {"7": [0.1, 0.2, 0.3]}]', ''):
        take_line(line, observed)
    assert observed.calls == [Call(1.5, '/s', (1.0, 2.0), True, '')]
    assert observed.shown == [ShownMarkers(2.0, {7: (0.1, 0.2, 0.3)})]
