"""The workspace of ./run: files that a rebuild keeps, waiting for other builds, and the progress display."""
import os
import signal
import subprocess
import sys

import pytest

from rostest_support.waiting import until
from unit_support import REPOSITORY

pytestmark = pytest.mark.slow
SOURCE = '. "$0/tools/environment.bash"; . "$0/tools/workspace.bash"; '
STEP = f'{SOURCE} repo=$0 ws=$1 log=$1/run.log; step 3 "Building the workspace" '
DEADLINE = 30.0  # [s] for what takes less than one


@pytest.fixture
def small(tmp_path):
    """Return (run(script), folder): bash with the functions of ./run, for a repository of two packages.

    catkin_make is one that writes what it would build; /opt/ros is a folder of the test.
    """
    repository, ros, programs = tmp_path / 'repository', tmp_path / 'ros', tmp_path / 'bin'
    for package in ('', 'packages/vision/cv_bridge', 'packages/vision/alvar'):
        (repository / package).mkdir(parents=True, exist_ok=True)
        (repository / package / 'package.xml').write_text('<package/>')
    (repository / 'packages' / 'vision' / 'alvar' / 'scripts').mkdir()
    (repository / 'packages' / 'vision' / 'alvar' / 'scripts' / 'node').write_text('')
    for folder in (ros / 'share', tmp_path / 'ws' / 'src', programs):
        folder.mkdir(parents=True)
    (ros / 'setup.bash').write_text(f'PATH={programs}:$PATH\n')
    (programs / 'catkin_make').write_text('''#!/bin/bash
[ ! -e "$2/../broken" ] || exit 1
for package in "$2"/src/*; do
  modules=$2/devel/lib/python3/dist-packages/${package##*/}
  mkdir -p "$2/build/${package##*/}" "$modules"
  touch "$modules/module.py"
done
touch "$2/devel/setup.bash"
''')
    (programs / 'catkin_make').chmod(0o755)

    def run(script):
        script = f'{SOURCE} repo={repository} ws={tmp_path}/ws ros_dir={ros} log=/dev/null; {script}'
        return subprocess.run(['bash', '-euc', script, REPOSITORY], capture_output=True, text=True, check=False,
                              env={'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)})
    return run, tmp_path


def built(folder):
    return sorted(os.listdir(folder / 'ws' / 'devel' / 'lib' / 'python3' / 'dist-packages'))


def test_a_package_that_ros_gets_later_leaves_the_build_of_the_others_alone(small):
    run, folder = small
    assert run('build_workspace; is_built').returncode == 0
    assert built(folder) == ['alvar', 'cv_bridge', 'turtle_robotont']
    kept = folder / 'ws' / 'build' / 'alvar' / 'compiled'
    kept.write_text('')
    (folder / 'ros' / 'share' / 'cv_bridge').mkdir()
    (folder / 'ros' / 'share' / 'cv_bridge' / 'package.xml').write_text('<package/>')
    assert run('is_built').returncode == 1
    assert run('build_workspace; is_built').returncode == 0
    assert built(folder) == ['alvar', 'turtle_robotont'] and kept.exists()
    assert not (folder / 'ws' / 'src' / 'cv_bridge').exists() and not (folder / 'ws' / 'build' / 'cv_bridge').exists()
    (folder / 'ros' / 'share' / 'cv_bridge' / 'package.xml').unlink()
    assert run('build_workspace; is_built').returncode == 0
    assert built(folder) == ['alvar', 'cv_bridge', 'turtle_robotont'] and kept.exists()


@pytest.mark.parametrize('name, left_out', [('cv_bridge', False), ('alvar', True)])
def test_cv_bridge_stays_beside_debians_which_has_no_python_part(small, name, left_out):
    run, folder = small
    (folder / 'debian' / 'share' / name).mkdir(parents=True)
    (folder / 'debian' / 'share' / name / 'package.xml').write_text('<package/>')
    result = run(f'ros_dir= debian_prefix={folder}/debian; our_packages {folder}/ws/src')
    assert result.returncode == 0
    assert (f'{name} {folder}' not in result.stdout) is left_out is ('Left out' in result.stderr)


def test_a_script_that_is_gone_takes_only_its_package_along(small):
    run, folder = small
    run('build_workspace')
    others = [folder / 'ws' / 'build' / name / 'compiled' for name in ('alvar', 'cv_bridge', 'turtle_robotont')]
    for path in others:
        path.write_text('')
    (folder / 'repository' / 'packages' / 'vision' / 'alvar' / 'scripts' / 'node').unlink()
    assert run('build_workspace; is_built').returncode == 0
    assert [path.exists() for path in others] == [False, True, True]


def test_what_was_built_with_another_umask_can_be_read_by_the_users_of_graded_programs(small):
    run, folder = small
    assert run('umask 077; build_workspace').returncode == 0
    modules = folder / 'ws' / 'devel' / 'lib' / 'python3' / 'dist-packages' / 'alvar'
    assert [path.stat().st_mode & 0o777 for path in (modules, modules / 'module.py')] == [0o755, 0o644]


@pytest.mark.parametrize('umask, mode', [('077', 0o644), ('027', 0o644), ('002', 0o664)])
def test_a_step_makes_files_that_other_users_can_read(tmp_path, umask, mode):
    subprocess.run(['bash', '-euc', f'umask {umask}; {STEP} touch $1/made', REPOSITORY, tmp_path], check=True,
                   env={'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)}, stderr=subprocess.DEVNULL)
    assert (tmp_path / 'made').stat().st_mode & 0o777 == mode


@pytest.mark.parametrize('change, kept', [('', True), ('ros_dir=$ros_dir/../ros;', False)])
def test_a_build_that_failed_continues_where_it_stopped(small, change, kept):
    run, folder = small
    (folder / 'broken').write_text('')
    half = folder / 'ws' / 'build' / 'alvar'
    assert run('build_workspace').returncode != 0
    half.mkdir(parents=True)
    assert run('is_built').returncode == 1
    (folder / 'broken').unlink()
    assert run(f'{change} find() {{ command find "$@"; }}; build_workspace; is_built').returncode == 0
    assert built(folder) == ['alvar', 'cv_bridge', 'turtle_robotont']


def test_who_waits_is_told_for_whom(tmp_path):
    lock = f'{SOURCE} repo=$0 ws={tmp_path} typed=$1; lock "$2"; echo locked; '
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)}
    with subprocess.Popen(['bash', '-euc', lock + 'exec cat', REPOSITORY, './run demo maze', '-s'], env=environment,
                          stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as demo:
        assert demo.stdout.readline() == 'locked\n'
        shared = subprocess.run(['bash', '-euc', lock, REPOSITORY, './run shell', '-s'], env=environment, text=True,
                                capture_output=True, check=True)
        assert (shared.stdout, shared.stderr) == ('locked\n', '')
        with subprocess.Popen(['bash', '-euc', lock, REPOSITORY, './run build', '-x'], env=environment, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE) as build:
            assert build.stderr.readline() == 'Waiting until another terminal is done:\n'
            message = build.stderr.readline()
            assert message.startswith('  ./run demo maze, which has run for ')
            assert message.endswith(f'(process {demo.pid})\n')
            demo.stdin.close()
            assert build.stdout.readline() == 'locked\n'
            assert build.wait() == 0


def test_a_step_that_is_interrupted_has_not_failed(tmp_path):
    stubborn = r'bash -c "trap \"exit 1\" INT; echo begun; while :; do read -t 1; done"'
    with subprocess.Popen(['bash', '-euc', STEP + stubborn, REPOSITORY, tmp_path], stderr=subprocess.PIPE, text=True,
                          start_new_session=True,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
                          env={'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)}) as process:
        until(lambda: (tmp_path / 'run.log').exists() and 'begun' in (tmp_path / 'run.log').read_text())
        os.killpg(process.pid, signal.SIGINT)
        message = process.communicate(timeout=DEADLINE)[1]
    assert process.returncode == 130, message
    assert 'interrupted after' in message and 'Type ./run build to continue' in message and 'FAILED' not in message


@pytest.mark.parametrize('command, code, message', [
    ('true', 0, '[3/3] Building the workspace ...\n[3/3] done in '), ('false', 1, '[3/3] FAILED after ')])
def test_a_step_says_how_it_ended_and_leaves_nothing_running(tmp_path, command, code, message):
    done = subprocess.run(['bash', '-euc', STEP + command, REPOSITORY, tmp_path], capture_output=True, text=True,
                          env={'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)}, timeout=DEADLINE, check=False)
    assert done.returncode == code and message in done.stderr


@pytest.mark.parametrize('folder, runs', [('devel/lib/turtlesim', True), ('venv/bin', True), ('src/own', False)])
def test_programs_of_the_workspace_are_found(small, folder, runs):
    run, path = small
    program = path / 'ws' / folder / 'node'
    program.parent.mkdir(parents=True, exist_ok=True)
    program.write_text('#!/bin/sh\nread -r line\n')
    program.chmod(0o755)
    with subprocess.Popen([program], stdin=subprocess.PIPE) as process:
        found = run('programs_of_workspace').stdout
        process.stdin.close()
    shown = f'{process.pid:>7} /bin/sh {program}'[:110]  # ps aligns the numbers, so a line ends after fewer characters
    assert (shown in found) is runs


def test_clean_takes_no_argument_and_spares_a_workspace_in_use(tmp_path):
    workspace = tmp_path / 'ws'
    program = workspace / 'devel' / 'node'
    program.parent.mkdir(parents=True)
    (workspace / 'src').mkdir()
    program.write_text('#!/bin/sh\nread -r line\n')
    program.chmod(0o755)
    (workspace / '.checkout').write_text(f'{REPOSITORY}\n')
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path)}

    def clean(*arguments):
        done = subprocess.run([REPOSITORY / 'run', 'clean', *arguments], capture_output=True, text=True, check=False,
                              env={**environment, 'TURTLE_ROBOTONT_WS': str(workspace)})
        return done.returncode, done.stderr
    for argument in ('--dry-run', str(tmp_path), 'now'):
        assert clean(argument) == (2, f'{clean_usage()}\n') and program.exists()
    with subprocess.Popen([program], stdin=subprocess.PIPE) as process:
        code, message = clean()
        process.stdin.close()
    assert code == 1 and 'programs of this workspace are running' in message
    assert program.name in message and program.exists()
    assert clean()[0] == 0 and not workspace.exists()


def clean_usage():
    return subprocess.run([REPOSITORY / 'run', 'clean', '--help'], capture_output=True, text=True, check=True,
                          env={'PATH': '/usr/bin:/bin', 'HOME': '/nonexistent'}).stdout.strip()


def test_compiled_modules_are_kept_whatever_the_shell_says(small):
    run, folder = small
    (folder / 'ws' / 'venv' / 'bin').mkdir(parents=True)
    (folder / 'ws' / 'venv' / 'bin' / 'python3').symlink_to(sys.executable)
    result = run('export PYTHONDONTWRITEBYTECODE=1; build_workspace; . "$ws/env.bash"; '
                 'echo "${PYTHONDONTWRITEBYTECODE-unset}"')
    assert result.stdout.splitlines()[-1] == 'unset', result.stderr
    assert list((folder / 'ws' / 'devel').glob('lib/python3/dist-packages/alvar/__pycache__/module.*.pyc'))


@pytest.mark.parametrize('release', ['ID=debian\nVERSION_CODENAME=forky\n', 'ID=debian\nVERSION_CODENAME=bookworm\n'])
def test_a_workspace_of_another_system_is_built_anew_beside_the_packages_in_it(small, release):
    """A new image, or a Debian that was upgraded, gets a workspace whose compiled modules its Python cannot import."""
    run, folder = small
    (folder / 'os-release').write_text('ID=debian\nVERSION_CODENAME=trixie\n')
    elsewhere = f'eval "$(declare -f system_stamp | sed s#/etc/os-release#{folder}/os-release#)"; '
    assert run(f'{elsewhere} build_workspace; is_built').returncode == 0
    compiled = folder / 'ws' / 'build' / 'alvar' / 'compiled'
    compiled.write_text('')
    (folder / 'ws' / 'src' / 'topic_demo').mkdir()
    assert run(f'{elsewhere} build_workspace; is_built').returncode == 0 and compiled.exists()
    (folder / 'os-release').write_text(release)
    assert run(f'{elsewhere} is_built').returncode == 1
    assert run(f'{elsewhere} build_workspace; is_built').returncode == 0
    assert not compiled.exists() and (folder / 'ws' / 'src' / 'topic_demo').is_dir()


def test_a_workspace_of_another_python_is_built_anew(small):
    run, folder = small
    assert run('build_workspace; is_built').returncode == 0
    other = 'readlink() { [ "$2" = /usr/bin/python3 ] && echo /usr/bin/python3.99 || command readlink "$@"; }; '
    compiled = folder / 'ws' / 'build' / 'alvar' / 'compiled'
    compiled.write_text('')
    assert run(f'{other} build_workspace; is_built').returncode == 0 and not compiled.exists()


def test_a_workspace_of_an_earlier_release_is_not_thrown_away(small):
    run, folder = small
    assert run('build_workspace').returncode == 0
    built_file = folder / 'ws' / '.built'
    built_file.write_text(''.join(line for line in built_file.open() if not line.startswith('system  ')))
    compiled = folder / 'ws' / 'build' / 'alvar' / 'compiled'
    compiled.write_text('')
    assert run('is_built').returncode == 1
    assert run('build_workspace; is_built').returncode == 0 and compiled.exists()


STUDENTS = 'mymap.yaml', 'drive.bag', 'output/circle.png', '.git/HEAD', 'src/topic_demo/package.xml'


def test_clean_removes_what_was_made_and_nothing_else(tmp_path):
    workspace = tmp_path / 'ws'
    made = ('build/x', 'devel/setup.bash', 'venv/bin/python3', 'env.bash', 'run.log', '.built', '.master_port.0',
            '.users/1', 'ros_home/log/x', 'test_results/x', 'tmp/x', 'terminal/x', 'bin/roscore')
    for name in (*made, *STUDENTS):
        (workspace / name).parent.mkdir(parents=True, exist_ok=True)
        (workspace / name).write_text('x')
    (workspace / 'src' / 'turtle_robotont').symlink_to(REPOSITORY)
    (workspace / '.checkout').write_text(f'{REPOSITORY}\n')

    def clean():
        return subprocess.run([REPOSITORY / 'run', 'clean'], capture_output=True, text=True, check=False, env={
            'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path), 'TURTLE_ROBOTONT_WS': str(workspace)})
    done = clean()
    assert done.returncode == 0, done.stderr
    assert {str(path.relative_to(workspace)) for path in workspace.rglob('*') if path.is_file()} == {
        *STUDENTS, '.checkout', '.lock'}
    assert list((workspace / 'src').iterdir()) == [workspace / 'src' / 'topic_demo']
    assert f'Your own packages are still in {workspace}/src: topic_demo' in done.stderr
    kept = done.stderr.partition(f'Your own files are still in {workspace}: ')[2].partition('\n')[0]
    assert set(kept.split()) == {'mymap.yaml', 'drive.bag', 'output', '.git'}
    subprocess.run(['rm', '-r', *(workspace / name.partition('/')[0] for name in STUDENTS)], check=True)
    assert clean().returncode == 0 and not workspace.exists()


def test_a_checkout_that_is_gone_takes_no_file_of_the_user_along(small):
    run, folder = small
    lost = folder / '.cache' / 'turtle_robotont' / 'lost'
    for name in ('build/x', *STUDENTS):
        (lost / name).parent.mkdir(parents=True, exist_ok=True)
        (lost / name).write_text('x')
    (lost / '.checkout').write_text(str(folder / 'gone'))
    assert run('forget_lost_workspaces').returncode == 0
    assert not (lost / 'build').exists() and all((lost / name).exists() for name in STUDENTS)
