"""course_grader.supervision.warm_start: processes that are forked from one that has imported a module."""
import concurrent.futures
import importlib
import os
import signal
import sys
import time

import pytest

from course_grader.supervision import warm_start
from course_grader.supervision.warm_start import WarmStart
from plain_support import processes
from unit_support.warm_work import report, work

pytestmark = pytest.mark.slow

DEADLINE = 10.0  # [s] for what takes well under one


@pytest.fixture
def warm():
    made = WarmStart('json', work)
    yield made
    made.close()


def result(warm, argument):
    """Return what a process for ``argument`` sends."""
    process, receiver = warm.start(argument)
    with receiver:
        assert receiver.poll(DEADLINE)
        argument, pid, session = eval(receiver.recv())
    assert pid == session == process.pid != os.getpid()
    process.wait(DEADLINE)
    return argument


def test_each_request_gets_a_process_of_its_own(warm):
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda number: result(warm, number), range(12))) == list(range(12))


@pytest.mark.parametrize('how', ['crash', 'kill'])
def test_who_crashes_closes_its_pipe_and_harms_no_other(warm, how):
    process, receiver = warm.start(how)
    with receiver, pytest.raises(EOFError):
        receiver.recv()
    process.wait(DEADLINE)
    assert result(warm, 'next') == 'next'


def test_the_server_prepares_for_each_request_and_keeps_it():
    warm = WarmStart('unit_support.warm_work', report)
    try:
        for expected in ['one'], ['one', 'two']:
            _, receiver = warm.start(expected[-1])
            with receiver:
                assert receiver.poll(DEADLINE) and receiver.recv() == expected
    finally:
        warm.close()


def test_a_new_server_finds_messages_that_were_imported_before(tmp_path, monkeypatch):
    """A package in the devel space of catkin puts the folder of its source first, which has no messages."""
    devel, source = tmp_path / 'devel', tmp_path / 'source'
    for folder in devel, source:
        (folder / 'a_package').mkdir(parents=True)
        (folder / 'a_package' / '__init__.py').touch()
    (devel / 'a_package' / '__init__.py').write_text(f'import sys\nsys.path.insert(0, {str(source)!r})\n')
    (devel / 'a_package' / 'msg.py').write_text('from json import dumps\n')
    monkeypatch.syspath_prepend(str(devel))
    monkeypatch.setenv('PYTHONPATH', str(devel), prepend=os.pathsep)
    monkeypatch.delitem(sys.modules, 'a_package', raising=False)
    importlib.import_module('a_package.msg')
    warm = WarmStart('a_package.msg', work)
    try:
        warm._identity.kill()
        assert result(warm, 'next') == 'next'
    finally:
        warm.close()


def test_all_end_with_the_server():
    warm = WarmStart('json', work)
    process, receiver = warm.start('sleep')
    with receiver:
        assert process.is_running() and not receiver.poll(0)
        warm.close()
        end = time.monotonic() + DEADLINE
        while processes.runs(process):  # not a zombie: in some containers nobody reaps it
            assert time.monotonic() < end
            time.sleep(0.01)


@pytest.mark.parametrize('number', [signal.SIGKILL, signal.SIGSTOP])
def test_a_server_that_is_ended_or_stopped_is_replaced(warm, monkeypatch, number):
    assert result(warm, 'before') == 'before'
    start = warm._start_server

    def start_and_be_patient(kind):  # only the stopped one is given up soon: a new one may start slowly
        monkeypatch.setattr(warm_start, 'IMPORT_TIMEOUT', DEADLINE)
        start(kind)
    monkeypatch.setattr(warm, '_start_server', start_and_be_patient)
    monkeypatch.setattr(warm_start, 'IMPORT_TIMEOUT', DEADLINE if number == signal.SIGKILL else 1.0)
    os.kill(warm._server.pid, number)
    with concurrent.futures.ThreadPoolExecutor(4) as pool:  # it has several threads when the next server starts
        assert list(pool.map(lambda text: result(warm, text), range(4))) == list(range(4))


def test_where_no_server_lives_that_is_said(monkeypatch):
    warm = WarmStart('no_such_module', work)
    with pytest.raises(ChildProcessError, match='was ended or stopped again and again'):
        warm.start('never')
    warm.close()
