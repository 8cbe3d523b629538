"""course_grader.supervision.warm_start: processes that are forked from one that has imported a module."""
import concurrent.futures
import os
import signal
import time

import pytest

from course_grader.supervision.warm_start import WarmStart

DEADLINE = 10.0  # [s] for what takes well under one


def work(module, argument):
    """Do what the argument says; the module is json."""
    if argument == 'crash':
        raise RuntimeError('as asked')
    if argument == 'kill':
        os.kill(os.getpid(), signal.SIGKILL)
    if argument == 'sleep':
        time.sleep(1000.0)
    return module.dumps([argument, os.getpid(), os.getsid(0)])


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


def test_all_end_with_the_server():
    warm = WarmStart('json', work)
    process, receiver = warm.start('sleep')
    with receiver:
        assert process.is_running() and not receiver.poll(0)
        warm.close()
        process.wait(DEADLINE)
