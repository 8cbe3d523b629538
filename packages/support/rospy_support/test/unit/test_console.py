"""rospy_support.console: output that is closed, unread or full, and a log file that cannot be written, end nothing."""
import io
import logging
import os
import subprocess
import sys

import pytest
import rosgraph.roslogging

from rospy_support import console
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

DEADLINE = 30.0  # [s] for a process that only prints, on a busy machine
FULL = '/dev/full'  # a file on a full disk


@pytest.fixture
def unread_pipe():
    """The writing end, as text, of a pipe whose reader has gone."""
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, 'w', closefd=False) as stream:
        yield stream
    os.close(writer)


def test_text_is_written_a_line_at_a_time(tmp_path):
    with open(tmp_path / 'output', 'w') as stream:
        output = console.Console(stream)
        assert output.write('one\ntwo') == 7
        assert (tmp_path / 'output').read_text() == 'one\ntwo'
        output.flush()


@pytest.fixture
def full_disk():
    with open(FULL, 'w') as stream:
        yield stream


@pytest.mark.parametrize('stream', ['unread_pipe', 'full_disk'])
def test_a_stream_that_cannot_be_written_is_no_error(request, stream):
    output = console.Console(request.getfixturevalue(stream))
    for _ in range(3):
        output.write('x' * 10000 + '\n')
        output.flush()


def test_a_stream_that_was_closed_is_no_error(tmp_path):
    with open(tmp_path / 'output', 'w') as stream:
        output = console.Console(stream)
    output.write('late\n')
    output.flush()


def test_characters_that_the_locale_has_not_are_written_as_escapes():
    stream = io.TextIOWrapper(io.BytesIO(), encoding='ascii')
    console.Console(stream).write('grün 🐢\n')
    assert stream.buffer.getvalue() == b'gr\\xfcn \\U0001f422\n'


PROGRAM = """
import logging, os, sys, socket
from rospy_support import console
console.guard()
connection = socket.socket()
print('to stdout'); print('to stderr', file=sys.stderr)
os.write(1, b'by C'); os.write(2, b'by C')
print(sys.stdout.isatty(), file=sys.stderr)
sys.exit(0 if connection.fileno() > 2 else 'a connection has the number of a standard stream')
"""


@pytest.mark.parametrize('redirection', ['', '<&- >&- 2>&-', '>/dev/full 2>/dev/full',
                                         *nightly('>&-', '2>&-', '<&-', '>&- 2>&-')])
def test_standard_streams_may_be_closed(redirection):
    command = ['bash', '-c', f'exec "$0" -c "$1" {redirection}', sys.executable, PROGRAM]
    done = subprocess.run(command, capture_output=True, timeout=DEADLINE)
    if 'full' not in redirection:  # os.write of the program itself fails there
        assert done.returncode == 0, done.stderr
    assert (b'to stdout' in done.stdout) == ('>&-' not in redirection.replace('2>&-', '') and 'full' not in redirection)


def test_a_file_with_the_number_of_a_closed_stream_is_not_printed_into(tmp_path):
    """As the script that catkin makes for a node has one open."""
    (tmp_path / 'script').write_text('as it was')
    program = ('import os, sys\nkept = open(sys.argv[1], "r+")\nassert kept.fileno() < 3\n'
               'from rospy_support import console\n'
               'console.guard()\nprint("x"); print("y", file=sys.stderr)')
    command = ['bash', '-c', 'exec "$0" -c "$1" "$2" >&- 2>&-', sys.executable, program, tmp_path / 'script']
    assert subprocess.run(command, timeout=DEADLINE).returncode == 0
    assert (tmp_path / 'script').read_text() == 'as it was'


@pytest.fixture
def restored_logging(monkeypatch):
    """The loggers of rospy as they were, after the test."""
    loggers = [logging.getLogger(), logging.getLogger('rosout')]
    before = [(logger, list(logger.handlers), logger.level) for logger in loggers]
    monkeypatch.delenv('ROS_LOG_FILENAME', raising=False)
    yield
    for logger, handlers, level in before:
        for handler in set(logger.handlers) - set(handlers):
            handler.close()
        logger.handlers[:], logger.level = handlers, level


def configure_and_log(monkeypatch, folder, filename='node.log'):
    """Configure logging as rospy.init_node does, and log two lines."""
    monkeypatch.setenv('ROS_LOG_DIR', str(folder))
    with console.log_file_guarded():
        rosgraph.roslogging.configure_logging('rospy', logging.INFO, filename=filename)
    for number in range(2):
        logging.getLogger('rosout').warning('line %d', number)
    return logging.handlers.RotatingFileHandler


def test_a_log_file_is_written_where_it_can_be(monkeypatch, restored_logging, tmp_path, capsys):
    original = logging.handlers.RotatingFileHandler
    assert configure_and_log(monkeypatch, tmp_path / 'new') is original
    said = (tmp_path / 'new' / 'node.log').read_text()
    assert 'line 0' in said and 'line 1' in said
    assert 'no log file' not in capsys.readouterr().err


def folder_without_log(case, folder):
    """Return a log folder in which node.log cannot be written."""
    if case == 'a full disk':
        (folder / 'node.log').symlink_to(FULL)
    elif case == 'a folder in its place':
        (folder / 'node.log').mkdir()
    elif case == 'a file in the way':
        (folder / 'log').write_text('')
        return folder / 'log'
    else:
        return '/dev/null/log'
    return folder


@pytest.mark.parametrize('case', ['a full disk', 'a folder in its place', 'a file in the way', 'no folder'])
def test_without_a_log_file_lines_go_to_the_console_and_it_is_said_once(monkeypatch, restored_logging, tmp_path, capsys,
                                                                      case):
    configure_and_log(monkeypatch, folder_without_log(case, tmp_path))
    said = capsys.readouterr().err
    assert said.count('no log file') == 1 and 'ROS_LOG_DIR' in said, said
    assert 'line 0' in said and 'line 1' in said
    assert 'Traceback' not in said and 'Logging error' not in said
    assert os.environ.get('ROS_LOG_DIR', '') != console.NOWHERE
