"""course_grader.isolation.trial: what a machine lacks is no fault of a program, and what a program lacks is one."""
import os
import subprocess
import sys
import types

import pytest

from course_grader.attempt import attempt
from course_grader.isolation import levels, limits, sandbox, trial, view
from course_grader.isolation.confinement import Isolation
from course_grader.rules.observation import Observed, OutputLine
from rostest_support.waiting import until

ROOT = pytest.mark.skipif(os.geteuid() != 0, reason='only root gives programs another user')
POSE = 'turtlesim', 'turtlesim.msg', 'turtlesim.srv'


@pytest.mark.parametrize('said, modules, scarce', [
    ("ImportError: cannot import name 'Pose' from 'turtlesim.msg' (unknown location)", POSE, False),
    ("ModuleNotFoundError: No module named 'turtlesim'", POSE, False),
    ("ImportError: cannot import name 'Poes' from 'turtlesim.msg' (/ws/msg/__init__.py)", POSE, False),  # works there,
    ("ModuleNotFoundError: No module named 'turtlesim.msgs'", POSE, False),  # and this, too
    ("ModuleNotFoundError: No module named 'cv2'", ('cv2',), False),
    ("ModuleNotFoundError: No module named 'cv3'", (), False),
    ("ModuleNotFoundError: No module named 'kinematic_core'", (), False),  # hidden from programs
    ("RuntimeError: can't start new thread", (), True),
    ("OSError: [Errno 24] Too many open files: '/a'", (), True),
    ('OSError: [Errno 28] No space left on device', (), True),
    ('MemoryError', (), True),
    ("NameError: name 'Twist' is not defined", (), False), ('', (), False)])
def test_what_is_tried_after_a_failure(said, modules, scarce):
    assert trial.suspected(said) == (list(modules), scarce)


def tried(command, *, before=(), **environment):
    ended = subprocess.run([*before, *command], stdout=subprocess.PIPE, text=True, timeout=60, check=False,
                           env={**os.environ, **environment})
    return ended.returncode, ended.stdout.strip()


def test_a_machine_that_has_everything():
    assert tried(trial.command([*trial.first_modules(), 'cv2'], limits.Limits()), HOME='/tmp') == (0, '')
    assert set(POSE) <= set(trial.first_modules())


@pytest.mark.parametrize('before, environment, said', [
    (['prlimit', '--nofile=24'], {}, 'OSError: [Errno 24] Too many open files'),
    (['prlimit', f'--data={32 << 20}'], {}, "can't start new thread"),
    (['prlimit', '--fsize=1000'], {}, 'OSError: [Errno 27] File too large'),
    ([], {'HOME': '/proc/none'}, 'FileNotFoundError')])
def test_a_machine_that_lacks_something(before, environment, said):
    code, text = tried(trial.command((), limits.Limits()), before=before, **environment)
    assert code and said in text
    code, text = tried(trial.command(['rospy', 'no_such_module']))
    assert (code, text) == (1, "import no_such_module: ModuleNotFoundError: No module named 'no_such_module'")


def test_small_limits_of_a_program_are_no_lack_of_the_machine():
    most = limits.Limits(processes=16, file_size=1, disk=1, memory=64)
    few = ['prlimit', f'--fsize={1 << 20}', f'--data={64 << 20}']
    code, said = tried(trial.command((), most), before=few, HOME='/tmp')
    assert (code, said) == (0, '')


def test_what_others_cannot_read_is_named(tmp_path):
    for folder in ('open', 'open/in', 'closed'):
        (tmp_path / folder).mkdir()
        (tmp_path / folder).chmod(0o755)
    (tmp_path / 'open' / 'in' / 'a.py').write_text('')
    (tmp_path / 'open' / 'in' / 'a.py').chmod(0o644)
    assert view.unreadable(str(tmp_path / 'open')) == ''
    (tmp_path / 'open' / 'in' / 'a.py').chmod(0o600)
    assert view.unreadable(str(tmp_path / 'open')) == str(tmp_path / 'open' / 'in' / 'a.py')
    assert view.unreadable(str(tmp_path / 'open'), [str(tmp_path / 'open' / 'in')]) == ''
    (tmp_path / 'closed').chmod(0o700)
    said = trial.cause('import a: PermissionError', 60710, [(str(tmp_path / 'closed'), '/ws/a')])
    assert said.endswith(f'{tmp_path / "closed"} cannot be read by others; type: chmod -R go+rX {tmp_path / "closed"}')
    assert './run doctor' in trial.cause('import a: ImportError', None, [])
    (tmp_path / 'closed' / 'ws').mkdir()
    (tmp_path / 'closed' / 'ws').chmod(0o755)
    said = trial.cause('import a: ImportError', 60710, [(str(tmp_path / 'closed' / 'ws'), '/ws')])
    assert 'TURTLE_ROBOTONT_WS' in said


@pytest.fixture
def umask_after():
    before = os.umask(0)
    yield
    os.umask(before)


@ROOT
@pytest.mark.parametrize('level', [levels.NAMESPACE, levels.UID])
@pytest.mark.parametrize('umask', [0o022, 0o077])
@pytest.mark.usefixtures('umask_after')
def test_what_only_root_can_read_runs_as_another_user(tmp_path, level, umask):
    """A program that root had unpacked with a umask of 077 could not be read, which counted as its own failure."""
    if getattr(levels.machine(), level):
        pytest.skip(f'the level {level} is not possible here')
    own = tmp_path / 'own'
    (own / 'out').mkdir(parents=True)
    (own / 'part.py').write_text('WORD = "read"\n')
    (own / 'program.py').write_text('import part\nprint(part.WORD)\n')
    for path in (own / 'part.py', own / 'program.py'):
        path.chmod(0o600)
    own.chmod(0o700)
    isolation = Isolation(level, limits.Limits(), (str(own),))
    os.umask(umask)
    with sandbox.Sandbox(str(own / 'out'), os.environ, '', isolation, [str(own / 'out')]) as box:
        student = sandbox.Student(box, [sys.executable, str(own / 'program.py')], lambda: 0.0)
        until(lambda: student.exit_code() is not None)
        student.drain()
        assert [line.text for line in student.lines] == ['read'] and student.exit_code() == 0
    assert sorted(os.listdir(own / 'out')) == []


def an_attempt(tmp_path, trouble, answer, level=levels.NAMESPACE):
    """Return an Attempt whose trials end with an (exit code, output), a Student that has failed, and what was tried."""
    made = object.__new__(attempt.Attempt)
    asked = []
    box = types.SimpleNamespace(user=60710, seen=lambda: [], disk_used=lambda: 0.0)
    made.observed, made._deadline, made._box = Observed(trouble=trouble), float('inf'), box
    made._job = types.SimpleNamespace(isolation=Isolation(level), output=str(tmp_path))
    made._kills_before = 0

    def start(_box, modules, most=None):
        asked.append((modules, most is not None))
        return types.SimpleNamespace(exit_code=lambda: answer[0], end=lambda: None, drain=lambda: None,
                                     last_output=lambda: answer[1])
    made._start_trial = start
    student = types.SimpleNamespace(exceeded_limit=lambda: '', lines=[OutputLine(0.0, trouble)], end=lambda: None,
                                    exit_code=lambda: 1, memory=lambda: 100.0)
    return made, student, asked


@pytest.mark.parametrize('trouble, asked', [
    ("exit code 1: ImportError: cannot import name 'Pose' from 'turtlesim.msg' (unknown location)", [([*POSE], False)]),
    ("exit code 1: RuntimeError: can't start new thread", [([], True)])])
def test_the_machine_is_blamed_only_if_a_program_of_the_grader_fails_too(tmp_path, trouble, asked):
    made, student, done = an_attempt(tmp_path, trouble, (0, ''))
    made._blame_machine(made._box, student)
    assert done == asked
    made, student, _ = an_attempt(tmp_path, trouble, (1, 'import turtlesim.msg: ImportError: no'))
    with pytest.raises(attempt.MachineError, match='this machine is the cause, and not the program'):
        made._blame_machine(made._box, student)


@pytest.mark.parametrize('trouble, limit', [
    ('', ''), ("exit code 1: NameError: name 'cv2' is not defined", ''),
    ("exit code 1: RuntimeError: can't start new thread", 'the program exceeded a limit: processes')])
def test_other_failures_are_not_tried(tmp_path, trouble, limit):
    made, student, asked = an_attempt(tmp_path, trouble, (1, 'no'))
    student.exceeded_limit = lambda: limit
    made._blame_machine(made._box, student)
    assert asked == []


@pytest.mark.parametrize('code, kills, memory, blamed', [
    (-9, 1, 100.0, True), (137, 1, 100.0, True), (-9, 0, 100.0, False), (-9, 1, 1500.0, False), (1, 1, 100.0, False)])
def test_a_machine_without_memory(tmp_path, monkeypatch, code, kills, memory, blamed):
    made, student, _ = an_attempt(tmp_path, f'the program ended with exit code {code}', (0, ''))
    student.exit_code, student.memory = lambda: code, lambda: memory
    monkeypatch.setattr(attempt, '_kills_for_memory', lambda: kills)
    if blamed:
        with pytest.raises(attempt.MachineError, match='has no memory left: its kernel ended the program'):
            made._blame_machine(made._box, student)
    else:
        made._blame_machine(made._box, student)


@pytest.mark.parametrize('level, free, written, said', [
    (levels.NAMESPACE, 10 ** 9, 0.0, ''), (levels.NAMESPACE, 0, 0.0, 'is full: make room there, or choose'),
    (levels.UID, 0, 1.0, 'is full: make room there'), (levels.UID, 0, 90.0, 'the program filled the disk')])
def test_a_full_disk(tmp_path, monkeypatch, level, free, written, said):
    made, _, _ = an_attempt(tmp_path, '', (0, ''), level)
    made._box.disk_used = lambda: written
    monkeypatch.setattr(attempt.shutil, 'disk_usage', lambda path: types.SimpleNamespace(free=free))
    try:
        made._check_disk()
    except attempt.MachineError as error:
        assert said and said in str(error) and 'program' not in said
    else:
        assert made.observed.trouble.startswith(said) and bool(made.observed.trouble) == bool(said)


@pytest.mark.parametrize('most, said', [(100, 'a process may open only 100 files here'), (2000, '')])
def test_few_files(most, said):
    program = ('import resource\nfrom course_grader.attempt import attempt\n'
               'try:\n    attempt._allow_files()\n    print(resource.getrlimit(resource.RLIMIT_NOFILE)[0])\n'
               'except attempt.MachineError as error:\n    print(error)\n')
    ended = subprocess.run(['prlimit', f'--nofile=60:{most}', sys.executable, '-c', program], stdout=subprocess.PIPE,
                           text=True, check=True)
    assert ended.stdout.startswith(said or str(attempt.MANY_FILES))


def test_the_reason_of_a_simulator_that_does_not_start_is_told(tmp_path):
    made, _, _ = an_attempt(tmp_path, '', (0, ''))
    (tmp_path / 'simulator.txt').write_text('Starting\n[ERROR] parameter /turtlesim/start is [20, 5, 0]\n\n')
    with pytest.raises(attempt.AttemptError, match=r'code 2, see simulator.txt: \[ERROR\] parameter /turtlesim/start'):
        made._until(lambda: False, types.SimpleNamespace(poll=lambda: 2), 'simulator')
