"""Start rostest with its modules imported: a process that has them is forked for each .test file.

Importing them takes 0.9 s of processor time, a third of what a short .test file takes.
"""
import multiprocessing
import os
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

from collection import programs

_CONTEXT = multiprocessing.get_context('forkserver')
_CONTEXT.set_forkserver_preload(['rostest.rostest_main'])
USED = 'processor_time.txt'  # [s]: the process is no child of pytest, whose accounts miss it


class Rostest:
    """A process of rostest, as an object of Popen. ``returncode``: None while it runs."""

    def __init__(self, command, *, stdin, stdout, stderr, env, start_new_session):
        """Start it. Only these values are possible: no input, output and errors in one file, a session of its own."""
        assert (stdin, stderr, start_new_session) == (subprocess.DEVNULL, subprocess.STDOUT, True)
        self._process = _CONTEXT.Process(target=_run, args=(command, stdout.name, env))
        self._process.start()
        self.pid = self._process.pid

    @property
    def returncode(self):
        return self._process.exitcode

    def wait(self, timeout=None):
        """Wait until it ends; raise TimeoutExpired after ``timeout`` [s]."""
        self._process.join(timeout)
        if self.returncode is None:
            raise subprocess.TimeoutExpired('rostest', timeout)
        return self.returncode


def processor_time(folder):
    """Return what rostest and its nodes, which write into a folder, used [s]; 0 if it was killed."""
    file = folder / USED
    return float(file.read_text(encoding='utf-8')) if file.exists() else 0.


def _run(command, output, environment):
    """Run rostest in this process, and note its processor time in the folder of the test."""
    os.setsid()
    for path, flags, numbers in (os.devnull, os.O_RDONLY, [0]), (output, os.O_WRONLY, [1, 2]):
        for number in numbers:
            os.dup2(os.open(path, flags), number)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv[:] = command
    try:
        runpy.run_path(shutil.which(command[0]), run_name='__main__')
    finally:
        times = os.times()
        Path(environment[programs.CASE], USED).write_text(str(sum(times[:4])), encoding='utf-8')
