"""What ./run shell starts: a bash that stays one, whatever the user's ~/.bashrc does."""
import os
import socket
import subprocess

import pytest

from unit_support import REPOSITORY

pytestmark = pytest.mark.slow
WRITE = '. "$0/tools/environment.bash"; ws=$1; mkdir -p "$ws"; write_shell_files'


@pytest.fixture
def workspace(tmp_path):
    folder = tmp_path / 'ws'
    subprocess.run(['bash', '-euc', WRITE, REPOSITORY, folder], check=True)
    return folder


def shell(workspace, bashrc, typed, folder=None, **environment):
    """Return (output, errors) of the shell for a user with this ~/.bashrc who types a line."""
    (workspace.parent / '.bashrc').write_text(bashrc)
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(workspace.parent), 'LANG': 'C.UTF-8', **environment}
    done = subprocess.run(['bash', '--rcfile', workspace / 'shell.bash', '-i'], input=typed, text=True,
                          capture_output=True, env=environment, cwd=folder or workspace.parent, check=False)
    return done.stdout, done.stderr


@pytest.mark.parametrize('bashrc, message', [
    ('', ''), ('return', ''), ('exec 3>&1\nunset undefined\n', ''), ('set -e\nfalse\nset -u\n', ''),
    ('exec zsh -l\n', 'Left out of your ~/.bashrc: exec zsh -l.'), ('exit 3\n', 'Left out of your ~/.bashrc: exit.'),
    ('[ -t 99 ] || exec /bin/false\n', 'exec /bin/false'), ('cd /\n', ''),
])
def test_the_shell_goes_on_in_the_folder_where_it_was_typed(workspace, bashrc, message):
    typed = 'false; echo "in $PWD, $ROS_HOSTNAME"; exec echo "it was $BASH_VERSION"\n'
    printed, errors = shell(workspace, bashrc, typed)
    assert 'ROS is ready' in printed and f'in {workspace.parent}, localhost' in printed and 'it was 5' in printed
    assert message in errors and ('Left out' in errors) is bool(message)


def test_what_a_bashrc_sets_stays(workspace):
    assert 'mine: 5\n' in shell(workspace, 'export MINE=5\nalias mine="echo mine:"\nset -e\n', 'mine $MINE\n')[0]


@pytest.mark.parametrize('typed', ['run help', './run help', 'bash -c "run help"',
                                   'bash -c ". $1/env.bash; ./run help"'])
def test_run_works_in_every_folder_and_is_that_of_the_checkout(workspace, tmp_path, typed):
    printed, errors = shell(workspace, '', typed.replace('$1', str(workspace)) + '\n', folder=tmp_path)
    assert 'usage: ./run COMMAND' in printed, errors


def test_a_run_of_the_folder_itself_comes_first(workspace, tmp_path):
    (tmp_path / 'run').write_text('#!/bin/sh\necho "it is mine: $*"\n')
    (tmp_path / 'run').chmod(0o755)
    assert 'it is mine: help' in shell(workspace, '', './run help\n', folder=tmp_path)[0]


def test_no_library_is_preloaded_in_a_shell(workspace):
    assert '[]' in shell(workspace, '', 'echo "[$LD_PRELOAD]"\n')[0]


def port(workspace, user, before=''):
    """Return the port of the master of the user with this number in a workspace."""
    script = f'{before}id() {{ echo {user}; }}; . "$0/tools/environment.bash"; ws=$1; master_port'
    return int(subprocess.run(['bash', '-euc', script, REPOSITORY, workspace], capture_output=True, text=True,
                              check=True).stdout)


@pytest.fixture
def workspaces(tmp_path):
    folders = [tmp_path / 'a', tmp_path / 'b']
    for folder in folders:
        folder.mkdir()
    return folders


def test_every_user_and_every_workspace_has_a_port_of_its_own_and_keeps_it(workspaces):
    pairs = [(folder, user) for folder in workspaces for user in (1000, 1001, 0, 123456)]
    ports = [port(*pair) for pair in pairs]
    assert len(set(ports)) == len(pairs) and all(12000 <= number < 20000 for number in ports)
    assert [port(*pair) for pair in pairs] == ports


def test_a_port_that_is_taken_is_left_to_whoever_has_it(workspaces):
    first = port(workspaces[0], 1003)
    (workspaces[0] / '.master_port.1003').unlink()
    with socket.socket() as other:
        other.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        other.bind(('127.0.0.1', first))
        other.listen()
        assert port(workspaces[0], 1003) != first


def test_a_workspace_that_cannot_be_written_has_a_port_too(tmp_path):
    assert 12000 <= port(tmp_path / 'missing', 1000) < 20000


@pytest.mark.parametrize('uri, arguments', [
    ('http://localhost:12345', '-p 12345 -v'), ('http://robot:12345/', '-p 12345 -v'), ('http://localhost', '-v'),
])
def test_roscore_takes_the_port_of_the_master_uri(workspace, tmp_path, uri, arguments):
    (tmp_path / 'roscore').write_text('#!/bin/sh\necho "$@"\n')
    (tmp_path / 'roscore').chmod(0o755)
    path = f'{workspace}/bin:{tmp_path}:/usr/bin:/bin'
    done = subprocess.run([workspace / 'bin' / 'roscore', '-v'], env={'PATH': path, 'ROS_MASTER_URI': uri},
                          capture_output=True, text=True, check=True)
    assert done.stdout == arguments + '\n'


def test_the_master_of_the_user_is_shown_and_a_given_one_stays(workspace):
    printed = shell(workspace, '', 'echo "[$ROS_MASTER_URI]"\n')[0]
    own = f'http://localhost:{port(workspace, os.getuid())}'
    assert f'Your ROS master is {own};' in printed and f'[{own}]' in printed
    given = shell(workspace, '', 'echo "[$ROS_MASTER_URI]"\n', ROS_MASTER_URI='http://robot:11311')[0]
    assert 'The ROS master is http://robot:11311: ROS_MASTER_URI was set before' in given and 'other users' not in given
    assert '[http://robot:11311]' in given


SETUP = '''# in short what catkin writes: without --extend it forgets the others, with --local it is alone
case "$*" in *--extend*) ;; *) CMAKE_PREFIX_PATH= ROS_PACKAGE_PATH= ;; esac
below=$folder/../below
case "$*" in *--local*) below= ;; esac
export CMAKE_PREFIX_PATH=$folder/devel:$below:$CMAKE_PREFIX_PATH ROS_PACKAGE_PATH=$folder/src:$ROS_PACKAGE_PATH
export ROS_DISTRO=Debian ROS_MASTER_URI=${ROS_MASTER_URI:-http://localhost:11311}
'''
DEFAULT = 'http://localhost:11311'  # of every setup.bash


def catkin_workspace(folder):
    for name in ('src', 'devel'):
        (folder / name).mkdir(parents=True)
    (folder / 'devel' / '.catkin').write_text(f'{folder}/src')
    (folder / 'devel' / 'setup.bash').write_text(f'folder={folder}\n{SETUP}')
    return folder


@pytest.mark.parametrize('bashrc, found', [
    ('source ~/a/devel/setup.bash', 'a'), ('. ~/a/devel/setup.bash; . ~/b/devel/setup.bash --extend', 'b a'),
    ('. ~/a/devel/setup.bash; . ~/b/devel/setup.bash', 'b'), ('. ~/missing/devel/setup.bash', ''),
    ('export ROS_PACKAGE_PATH=~/a/src:~/missing/src:$ROS_PACKAGE_PATH', 'a'), ('. ~/other/devel/setup.bash', ''),
    ('export CMAKE_PREFIX_PATH=/opt/ros/noetic ROS_PACKAGE_PATH=/opt/ros/noetic/share', ''),
])
def test_the_workspaces_that_a_bashrc_sources_stay(workspace, bashrc, found):
    """... but neither what they were built on, nor another ROS, nor the workspace of another checkout."""
    home = workspace.parent
    for name in ('a', 'b', 'other'):
        catkin_workspace(home / name)
    (home / 'other' / 'env.bash').write_text((workspace / 'env.bash').read_text())
    printed = shell(workspace, bashrc, 'echo "[$ROS_PACKAGE_PATH] ($CMAKE_PREFIX_PATH)"\n')[0]
    packages = printed.split('[')[1].split(']')[0]
    assert [path for path in packages.split(':') if path] == [f'{home}/{name}/src' for name in found.split()]
    assert 'below' not in printed


def test_a_workspace_that_the_terminal_has_sourced_stays_in_a_script_too(workspace):
    home = catkin_workspace(workspace.parent / 'a').parent
    script = f'. {home}/a/devel/setup.bash; {{}}. {workspace}/env.bash; echo "[$ROS_PACKAGE_PATH]"'
    kept, left = (subprocess.run(['bash', '-c', script.format(before)], capture_output=True, text=True, check=True,
                                 env={'PATH': '/usr/bin:/bin', 'HOME': str(home), 'CMAKE_PREFIX_PATH': ''}).stdout
                  for before in ('', 'turtle_robotont_alone=1; '))
    assert kept.startswith(f'[{home}/a/src') and left == '[]\n'


@pytest.mark.parametrize('bashrc, before, master', [
    ('. ~/a/devel/setup.bash', {}, ''),
    ('', {'ROS_MASTER_URI': DEFAULT, 'ROS_DISTRO': 'Debian'}, ''),  # the terminal before ./run shell has sourced it
    ('. ~/a/devel/setup.bash  # instead of ROS_MASTER_URI', {}, ''),
    ('export ROS_MASTER_URI=http://localhost:11311\n. ~/a/devel/setup.bash', {}, DEFAULT),
    ('. ~/a/devel/setup.bash', {'ROS_MASTER_URI': 'http://robot:11311'}, 'http://robot:11311'),
    ('', {'ROS_MASTER_URI': DEFAULT}, DEFAULT),
])
def test_a_setup_file_does_not_choose_the_master(workspace, bashrc, before, master):
    catkin_workspace(workspace.parent / 'a')
    printed = shell(workspace, bashrc, 'echo "[$ROS_MASTER_URI]"\n', **before)[0]
    assert f'[{master or "http://localhost:" + str(port(workspace, os.getuid()))}]' in printed


def test_in_a_shell_of_this_workspace_the_usual_master_may_be_chosen(workspace):
    assert f'[{DEFAULT}]' in shell(workspace, '', 'echo "[$ROS_MASTER_URI]"\n', ROS_MASTER_URI=DEFAULT,
                                   ROS_DISTRO='Debian', VIRTUAL_ENV=f'{workspace}/venv')[0]
