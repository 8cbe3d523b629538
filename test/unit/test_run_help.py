"""./run COMMAND --help in a clone that has installed nothing: an answer at once, and nothing is made."""
import os
import re
import subprocess

import pytest

from unit_support import REPOSITORY

pytestmark = pytest.mark.slow
FILES = [REPOSITORY / 'run', *(REPOSITORY / 'tools').glob('*.bash')]
COMMANDS = re.findall(r'^describe (\w+) ', (REPOSITORY / 'run').read_text(encoding='utf-8'), re.MULTILINE)


def run(home, *arguments):
    """Return what ./run prints, for a user with this home folder and no workspace; it ends with code 0."""
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(home), 'LANG': 'C.UTF-8'}
    return subprocess.run([REPOSITORY / 'run', *arguments], env=environment, stdin=subprocess.DEVNULL, text=True,
                          capture_output=True, check=True, cwd=home).stdout


@pytest.mark.parametrize('command', COMMANDS)
@pytest.mark.parametrize('arguments', [('--help',), ('-h',), ('word', '--help')], ids=' '.join)
def test_help_needs_no_installation(tmp_path, command, arguments):
    message = run(tmp_path, command, *arguments)
    assert f'./run {command}' in message or command == 'help'
    assert message.startswith('usage: ./run')
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize('arguments, message', [
    (['link'], 'usage: ./run link [--without-solutions] FOLDER\n  links all packages into your own catkin workspace'),
    (['link', 'a', 'b'], 'usage: ./run link [--without-solutions] FOLDER\n'),
    (['build', '--rvizz'], 'usage: ./run build [--rviz]\n'),
    (['shell', '-c'], 'usage: ./run shell [-c COMMAND]\n'), (['shell', 'ls'], 'usage: ./run shell [-c COMMAND]\n'),
    (['demmo'], "there is no command 'demmo'. Did you mean ./run demo? The commands are:\n\nLearning:\n  shell "),
    (['stress', 'web'], './run stress is gone; its attacks are tests: ./run test attacks\n'),
    (['zzzz'], "there is no command 'zzzz'. The commands are:\n\nLearning:\n  shell "),
])
def test_wrong_usage_gets_the_usage_of_the_command(tmp_path, arguments, message):
    environment = {'PATH': '/usr/bin:/bin', 'HOME': str(tmp_path), 'LANG': 'C.UTF-8'}
    done = subprocess.run([REPOSITORY / 'run', *arguments], env=environment, stdin=subprocess.DEVNULL, text=True,
                          capture_output=True, check=False, cwd=tmp_path)
    assert done.returncode == 2 and message in done.stderr
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize('file', FILES, ids=lambda path: path.name)
def test_paths_that_a_command_names_exist(file):
    named = set(re.findall(r'(?:\bin_copy |\$repo"?/)([\w./-]*\w)', file.read_text(encoding='utf-8')))
    assert {path for path in named - {'output', 'PATH'} if not (REPOSITORY / path).exists()} == set()


def test_the_commands_were_found():
    assert {'demo', 'grade', 'shell'} < set(COMMANDS)
