"""kinematic_core.timing.idle_threads: what Linux says of the threads of real processes."""
import os
import subprocess
import sys
import threading
import time

import pytest

from kinematic_core.timing import idle_threads
from kinematic_core.timing.idle_threads import Gone, Machine, ProcessThreads
from rostest_support.waiting import until

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


def rests(threads):
    before = threads.ran()
    return threads.sleeps() and threads.ran() == before


def test_a_process_rests_when_all_its_threads_sleep(run):
    threads = ProcessThreads(run(SLEEPER).pid)
    until(lambda: rests(threads))
    threads.close()
    with pytest.raises(OSError):  # no file is left open
        threads.sleeps()


def test_a_process_that_has_run_and_sleeps_again_is_told_by_its_count(run):
    child = run(SLEEPER)
    threads = ProcessThreads(child.pid)
    until(lambda: rests(threads))
    before = threads.ran()
    child.stdin.write(b'\n')
    child.stdin.flush()
    assert child.stdout.readline() == b'again\n'
    until(lambda: rests(threads))
    assert threads.ran() > before


def test_of_a_process_that_has_not_run_only_threads_outside_of_a_lock_are_checked_again(run):
    child = run('import sys, threading; [threading.Thread(target=threading.Event().wait, daemon=True).start()'
                ' for _ in range(5)]; print("ready", flush=True); sys.stdin.readline(); print("again", flush=True); '
                'sys.stdin.readline()')
    threads = ProcessThreads(child.pid)
    until(lambda: rests(threads))
    checked = []

    def is_checked_once():
        assert threads.sleeps(threads.ran())
        checked.append(len(threads._wakeable))
        return checked[-1] == 1
    until(is_checked_once)  # the main thread, which waits for input
    assert checked[:2] == [6, 1]
    child.stdin.write(b'\n')
    child.stdin.flush()
    assert child.stdout.readline() == b'again\n'
    until(lambda: rests(threads))
    assert threads.sleeps(threads.ran()) and len(threads._wakeable) == 6  # it has run: all of them


def test_a_busy_process_makes_a_busy_machine(run):
    run(SPINNER)
    until(Machine().is_busy)


def test_a_machine_that_does_not_tell_counts_as_busy(monkeypatch):
    monkeypatch.setattr(idle_threads, 'PROC', '/nonexistent')
    assert Machine().is_busy()


def test_an_ended_process_is_gone(run):
    child = run(SLEEPER)
    threads = ProcessThreads(child.pid)
    until(lambda: rests(threads))
    child.kill()
    child.wait()
    with pytest.raises(Gone):
        threads.ran()
    with pytest.raises(Gone):
        threads.sleeps()
    with pytest.raises(Gone):
        ProcessThreads(child.pid)


def test_one_thread_that_works_is_seen_among_many_that_sleep(run):
    program = 'import threading, time\n' \
              'for _ in range(20): threading.Thread(target=time.sleep, args=(60,), daemon=True).start()\n'
    threads = ProcessThreads(run(program + SPINNER).pid)
    end = time.monotonic() + 0.1
    while time.monotonic() < end:
        assert not rests(threads)


def test_threads_come_and_go_and_some_do_not_count():
    threads = ProcessThreads(os.getpid(), without=[threading.get_native_id()])
    until(lambda: rests(threads))
    go, end = threading.Event(), threading.Event()
    more = threading.Thread(target=lambda: go.wait() and work_until(end))
    more.start()
    until(lambda: rests(threads))  # it is a new one, and waits
    go.set()
    for _ in range(20):
        assert not rests(threads)
    end.set()
    more.join()

    def ran_no_more():
        idle = threads.ran()
        work_until(go)
        return threads.ran() == idle
    until(ran_no_more)  # its own work does not count; a thread that another test has left may run now and then
    threads.close()


def work_until(event):
    while not event.is_set():
        pass


def test_a_name_with_brackets_does_not_hide_the_state(run):
    program = 'open("/proc/self/comm", "w").write("a) R (b"); ' + SLEEPER
    threads = ProcessThreads(run(program).pid)
    until(lambda: rests(threads))
