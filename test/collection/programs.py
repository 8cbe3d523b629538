"""Tests that are programs: each runs in a folder of its own, and its left-over processes are killed.

All processes inherit two variables of the environment: TURTLE_ROBOTONT_CASE is the folder, and ends with a slash;
TURTLE_ROBOTONT_TESTS is the id of the process of pytest. So left-over processes are found, even detached ones.
"""
import os
import signal
import subprocess
from contextlib import suppress
from pathlib import Path

CASE, TESTS = 'TURTLE_ROBOTONT_CASE', 'TURTLE_ROBOTONT_TESTS'
ENDING = 20  # [s] between SIGINT and SIGKILL
LAST_LINES = 25


class ProgramFailed(Exception):
    """A program ended with an exit code, or with a result, that means failure."""


def run(command, folder, environment=None, start=subprocess.Popen):
    """Run a command; return its exit code and output. Kill the processes that it leaves, also on an interrupt.

    ``start`` starts the process, and takes the arguments of Popen.
    """
    folder.mkdir(parents=True, exist_ok=True)
    output, case = folder / 'output.txt', f'{folder}/'
    variables = {**os.environ, CASE: case, 'ROS_HOME': f'{folder}/ros_home', **(environment or {})}
    with open(output, 'wb') as file:
        process = start([str(part) for part in command], stdin=subprocess.DEVNULL, stdout=file,
                        stderr=subprocess.STDOUT, env=variables, start_new_session=True)
        try:
            process.wait()
        except BaseException:
            os.killpg(process.pid, signal.SIGINT)
            with suppress(subprocess.TimeoutExpired):
                process.wait(ENDING)
            raise
        finally:
            ended = end_leftovers(CASE, case)
            process.wait()
    text = output.read_text(encoding='utf-8', errors='replace')
    return process.returncode, text + ''.join(f'ended left-over process {number}\n' for number in ended)


def last_lines(output):
    """Return the end of an output."""
    return '\n'.join(output.splitlines()[-LAST_LINES:])


def end_leftovers(variable, value):
    """Kill all processes in whose environment the variable has this value; return their ids."""
    mark, ended = f'{variable}={value}'.encode(), []
    for file in Path('/proc').glob('[0-9]*/environ'):
        with suppress(OSError):  # it has ended, or belongs to another user
            if mark in file.read_bytes().split(b'\0'):
                os.kill(int(file.parent.name), signal.SIGKILL)
                ended.append(int(file.parent.name))
    return ended
