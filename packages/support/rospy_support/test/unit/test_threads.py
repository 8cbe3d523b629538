"""rospy_support.threads: an error is logged, and ends neither a thread nor a timer."""
import threading
import time

import pytest
import rospy

from rospy_support import rospy_internals, threads

DEADLINE = 20.0  # [s] for what takes milliseconds


@pytest.fixture
def errors(monkeypatch, logged):
    monkeypatch.setattr(threads, 'PAUSE', 0.001)
    return logged


def failing(times, then):
    """Return a function that fails so many times and then calls ``then``."""
    left = [times]

    def function(*_):
        left[0] -= 1
        if left[0] >= 0:
            raise ValueError('mine')
        then()
    return function


def test_a_loop_is_begun_anew_after_an_error_until_it_returns(errors):
    done = threading.Event()
    thread = threads.keep_running('worker', failing(3, done.set))
    assert done.wait(DEADLINE)
    thread.join(DEADLINE)
    assert not thread.is_alive() and thread.daemon and thread.name == 'worker'
    assert len(errors) == 1 and 'ValueError: mine' in errors[0] and 'Traceback' in errors[0]


def test_another_error_is_told_at_once_and_the_same_one_later_again(errors, monkeypatch):
    kinds = [ValueError, ValueError, KeyError, KeyError]

    def fail():
        raise kinds.pop(0)('x')
    function = threads.guarded(fail)
    for _ in range(4):
        function()
    assert [error.rsplit('\n', 2)[-2] for error in errors] == ['ValueError: x', "KeyError: 'x'"]
    kinds += [KeyError] * 2
    moment = time.monotonic() + threads.REMINDER + 1.0
    monkeypatch.setattr(threads.time, 'monotonic', lambda: moment)
    function()
    function()
    assert len(errors) == 3


def test_an_error_of_a_node_that_shuts_down_is_not_told(errors, monkeypatch):
    monkeypatch.setattr(rospy_internals, 'shutting_down', lambda: True)
    thread = threads.keep_running('worker', failing(1, lambda: pytest.fail('begun anew')))
    thread.join(DEADLINE)
    assert not thread.is_alive() and errors == []


def test_a_timer_goes_on(errors):
    done = threading.Event()
    rospy.rostime.set_rostime_initialized(True)
    timer = threads.call_every(0.001, failing(2, done.set))
    assert done.wait(DEADLINE)
    timer.shutdown()
