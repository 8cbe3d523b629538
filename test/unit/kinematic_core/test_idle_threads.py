"""kinematic_core.timing.idle_threads: what Linux says of the threads of real processes."""
import subprocess
import sys
import threading
import time

import pytest

from kinematic_core.timing.idle_threads import Gone, ProcessThreads

DEADLINE = 10.0  # [s] for a Python to start on a busy machine
SLEEPER = 'import sys, time, threading; threading.Thread(target=time.sleep, args=(60,), daemon=True).start(); ' \
          'print("ready", flush=True); sys.stdin.readline(); print("again", flush=True); sys.stdin.readline()'
SPINNER = 'print("ready", flush=True)\nwhile True: pass'


@pytest.fixture
def run():
    children = []

    def start(program):
        child = subprocess.Popen([sys.executable, '-c', program], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        children.append(child)
        assert child.stdout.readline() == b'ready\n'
        return child
    yield start
    for child in children:
        child.kill()
        child.communicate()


def until(condition):
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.001)


def rests(threads):
    looked = threads.runs()
    return looked is not None and looked == threads.runs() and looked


def test_sleeping_threads_are_seen_one_by_one(run):
    threads = ProcessThreads(run(SLEEPER).pid)
    until(lambda: rests(threads))
    assert len(threads.runs()) == 2
    threads.close()


def test_a_process_that_has_run_and_sleeps_again_is_told_by_its_count(run):
    child = run(SLEEPER)
    threads = ProcessThreads(child.pid)
    until(lambda: rests(threads))
    before = threads.runs()
    child.stdin.write(b'\n')
    child.stdin.flush()
    assert child.stdout.readline() == b'again\n'
    until(lambda: rests(threads))
    assert threads.runs() != before


def test_a_busy_process_never_rests(run):
    threads = ProcessThreads(run(SPINNER).pid)
    end = time.monotonic() + 0.1
    while time.monotonic() < end:
        assert not rests(threads)


def test_an_ended_process_is_gone(run):
    child = run(SLEEPER)
    threads = ProcessThreads(child.pid)
    until(lambda: rests(threads))
    child.kill()
    child.wait()
    with pytest.raises(Gone):
        threads.runs()
    with pytest.raises(Gone):
        threads.ids()


def test_threads_come_and_go_and_some_do_not_count():
    threads = ProcessThreads('self', without=[threading.get_native_id()])
    first = len(threads.runs() or {})
    end = threading.Event()
    more = threading.Thread(target=end.wait)
    more.start()
    until(lambda: rests(threads) and len(threads.runs()) == first + 1)
    end.set()
    more.join()
    until(lambda: len(threads.runs() or ()) == first)
    assert str(threading.get_native_id()) not in (threads.runs() or {})
    threads.close()


def test_a_name_with_brackets_does_not_hide_the_state(run):
    program = 'open("/proc/self/comm", "w").write("a) R (b"); ' + SLEEPER
    threads = ProcessThreads(run(program).pid)
    until(lambda: rests(threads))
