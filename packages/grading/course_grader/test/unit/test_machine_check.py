"""course_grader.attempt.machine_check: what a machine lacks is no fault of a program, what a program takes is one."""
import subprocess
import sys
import types

import pytest

from course_grader.attempt import machine_check
from course_grader.attempt.faults import MachineError, ProgramFault
from course_grader.isolation import levels
from course_grader.isolation.confinement import Isolation
from course_grader.rules.observation import OutputLine, Problem

POSE = 'turtlesim', 'turtlesim.msg', 'turtlesim.srv'


def a_check(tmp_path, answer=(0, ''), level=levels.NAMESPACE):
    """Return a MachineCheck whose trials end with an (exit code, output), and a list of what was tried."""
    box = types.SimpleNamespace(user=60710, seen=lambda: [], disk_used=lambda: 0.0)
    made = machine_check.MachineCheck(types.SimpleNamespace(isolation=Isolation(level), output=str(tmp_path)), box,
                                      float('inf'))
    asked = []

    def start(modules, most=None):
        asked.append((modules, most is not None))
        return types.SimpleNamespace(exit_code=lambda: answer[0], end=lambda: None, drain=lambda: None,
                                     last_output=lambda: answer[1])
    made._trial = start
    return made, asked


def a_student(text, **parts):
    """Return a Student that has failed and printed a text."""
    return types.SimpleNamespace(**{
        'exceeded_limit': lambda: None, 'lines': [OutputLine(0.0, text)], 'end': lambda: None, 'exit_code': lambda: 1,
        'memory': lambda: 100.0, **parts})


@pytest.mark.parametrize('text, asked', [
    ("exit code 1: ImportError: cannot import name 'Pose' from 'turtlesim.msg' (unknown location)", [([*POSE], False)]),
    ("exit code 1: RuntimeError: can't start new thread", [([], True)])])
def test_the_machine_is_blamed_only_if_a_program_of_the_grader_fails_too(tmp_path, text, asked):
    check, done = a_check(tmp_path)
    check.blame(a_student(text), Problem(text))
    assert done == asked
    check, _ = a_check(tmp_path, (1, 'import turtlesim.msg: ImportError: no'))
    with pytest.raises(MachineError, match='this machine is the cause, and not the program'):
        check.blame(a_student(text), Problem(text))


@pytest.mark.parametrize('problem, limit', [
    (None, None), (Problem("exit code 1: NameError: name 'cv2' is not defined"), None),
    (Problem("exit code 1: RuntimeError: can't start new thread"), Problem('the program exceeded a limit: processes'))])
def test_other_failures_are_not_tried(tmp_path, problem, limit):
    check, asked = a_check(tmp_path, (1, 'no'))
    check.blame(a_student('', exceeded_limit=lambda: limit), problem)
    assert asked == []


@pytest.mark.parametrize('code, kills, memory, blamed', [
    (-9, 1, 100.0, True), (137, 1, 100.0, True), (-9, 0, 100.0, False), (-9, 1, 1500.0, False), (1, 1, 100.0, False)])
def test_a_machine_without_memory(tmp_path, monkeypatch, code, kills, memory, blamed):
    check, _ = a_check(tmp_path)
    student = a_student('', exit_code=lambda: code, memory=lambda: memory)
    monkeypatch.setattr(machine_check, 'kills_for_memory', lambda: kills)
    try:
        check.blame(student, Problem(f'the program ended with exit code {code}'))
    except MachineError as error:
        assert blamed and 'has no memory left: its kernel ended the program' in str(error)
    else:
        assert not blamed


@pytest.mark.parametrize('level, free, written, kind, text', [
    (levels.NAMESPACE, 10 ** 9, 0.0, None, ''),
    (levels.NAMESPACE, 0, 0.0, MachineError, 'is full: make room there, or choose'),
    (levels.UID, 0, 1.0, MachineError, 'is full: make room there'),
    (levels.UID, 0, 90.0, ProgramFault, 'the program filled the disk')])
def test_a_full_disk(tmp_path, monkeypatch, level, free, written, kind, text):
    check, _ = a_check(tmp_path, level=level)
    check._box.disk_used = lambda: written
    monkeypatch.setattr(machine_check.shutil, 'disk_usage', lambda path: types.SimpleNamespace(free=free))
    if kind:
        with pytest.raises(kind, match=text):
            check.check_disk()
    else:
        check.check_disk()


@pytest.mark.parametrize('most, text', [(100, 'a process may open only 100 files here'), (2000, '')])
def test_few_files(most, text):
    program = ('import resource\nfrom course_grader.attempt import machine_check\n'
               'try:\n    machine_check.allow_files()\n    print(resource.getrlimit(resource.RLIMIT_NOFILE)[0])\n'
               'except machine_check.MachineError as error:\n    print(error)\n')
    ended = subprocess.run(['prlimit', f'--nofile=60:{most}', sys.executable, '-c', program], stdout=subprocess.PIPE,
                           text=True, check=True)
    assert ended.stdout.startswith(text or str(machine_check.MANY_FILES))
