"""course_grader.isolation.trial: what a machine lacks is no fault of a program, and what a program lacks is one."""
import os
import subprocess
import sys

import pytest

from course_grader.isolation import levels, limits, sandbox, trial, view
from course_grader.isolation.confinement import Isolation
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
