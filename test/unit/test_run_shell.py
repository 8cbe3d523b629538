"""What ./run shell starts: a bash that stays one, whatever the user's ~/.bashrc does."""
import pathlib
import subprocess

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
WRITE = '. "$0/tools/environment.bash"; ws=$1; mkdir -p "$ws"; write_shell_files'


@pytest.fixture
def workspace(tmp_path):
    folder = tmp_path / 'ws'
    subprocess.run(['bash', '-euc', WRITE, REPOSITORY, folder], check=True)
    return folder


def shell(workspace, bashrc, typed, **environment):
    """Return (what the shell prints, its errors) for a user with this ~/.bashrc who types a line."""
    (workspace.parent / '.bashrc').write_text(bashrc)
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(workspace.parent), 'LANG': 'C.UTF-8', **environment}
    done = subprocess.run(['bash', '--rcfile', workspace / 'shell.bash', '-i'], input=typed, text=True,
                          capture_output=True, env=environment, check=False)
    return done.stdout, done.stderr


@pytest.mark.parametrize('bashrc, said', [
    ('', ''), ('return', ''), ('exec 3>&1\nunset undefined\n', ''), ('set -e\nfalse\nset -u\n', ''),
    ('exec zsh -l\n', 'Left out of your ~/.bashrc: exec zsh -l.'), ('exit 3\n', 'Left out of your ~/.bashrc: exit.'),
    ('[ -t 99 ] || exec /bin/false\n', 'exec /bin/false'),
])
def test_the_shell_goes_on_and_is_in_the_workspace(workspace, bashrc, said):
    typed = 'false; echo "in $PWD, $ROS_HOSTNAME"; exec echo "it was $BASH_VERSION"\n'
    printed, errors = shell(workspace, bashrc, typed)
    assert 'ROS is ready' in printed and f'in {workspace}, localhost' in printed and 'it was 5' in printed
    assert said in errors and ('Left out' in errors) is bool(said)


def test_what_a_bashrc_sets_stays(workspace):
    assert 'mine: 5\n' in shell(workspace, 'export MINE=5\nalias mine="echo mine:"\nset -e\n', 'mine $MINE\n')[0]
