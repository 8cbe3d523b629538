"""plain_support.processes: real processes are found, told apart when numbers come again, and ended."""
import os
import signal
import subprocess
import sys
import threading
import time

import psutil
import pytest

from plain_support import processes
from plain_support.processes import BackgroundProcess
from rostest_support.waiting import until

SOON = 5.0  # [s] deadline of what takes well under one
QUICK = ((signal.SIGINT, 0.3), (signal.SIGTERM, 0.3), (signal.SIGKILL, SOON))
DEAF = 'import signal, time; signal.signal(signal.SIGINT, signal.SIG_IGN); print("deaf", flush=True); time.sleep(60)'
PARENT = ('import subprocess, sys, time\n'
          'child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])\n'
          'print(child.pid, flush=True)\n')


def gone(pid):
    """Whether a process has ended, reaped by its parent or not."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


@pytest.fixture
def start(tmp_path):
    """Return a function that runs Python code in the background; all of it ends with the test."""
    started = []

    def run(code, **options):
        log = str(tmp_path / f'{len(started)}.log')
        started.append(BackgroundProcess([sys.executable, '-c', code], log, **options))
        return started[-1]
    yield run
    for process in started:
        process.stop(QUICK)


def first_line(process):
    until(lambda: '\n' in process.output())
    return process.output().split()[0]


def other_with_number(pid):
    """Return a psutil.Process with the number of a living process that started at another time."""
    process = psutil.Process(pid)
    process._ident = (pid, process.create_time() - 100.0)
    return process


def test_the_end_of_a_long_output(start):
    process = start('print("a" * 9); print("end")')
    process.process.wait()
    assert (process.output(4), process.output(6), process.output(99)) == ('end\n', 'a\nend\n', 'a' * 9 + '\nend\n')


def test_output_and_end_of_a_background_process(start):
    process = start('import sys; print("one"); print("two", file=sys.stderr); sys.exit(3)')
    until(lambda: not process.runs())
    assert process.output() == 'one\ntwo\n' or process.output() == 'two\none\n'  # two streams
    assert process.process.returncode == 3 and process.last_line() in ('one', 'two')
    process.signal(signal.SIGTERM)  # without effect
    process.stop()


@pytest.mark.parametrize('code, ended_by', [
    ('import time; print("kind", flush=True); time.sleep(60)', signal.SIGINT),
    (DEAF, signal.SIGTERM),
    (DEAF.replace('print', 'signal.signal(signal.SIGTERM, signal.SIG_IGN); print'), signal.SIGKILL),
])
def test_stages_of_stop(start, code, ended_by):
    process = start(code)
    first_line(process)
    process.stop([(number, SOON if number == ended_by else patience) for number, patience in QUICK])
    assert process.process.returncode in (-ended_by, 1)  # 1: KeyboardInterrupt
    assert (process.process.returncode == 1) <= (ended_by == signal.SIGINT)


@pytest.mark.parametrize('then', ['time.sleep(60)', ''])
def test_the_group_ends_with_it_also_when_it_has_ended_before(start, then):
    process = start(PARENT + then)
    child = int(first_line(process))
    if not then:
        until(lambda: not process.runs())
        assert not gone(child)
    process.stop(QUICK)
    until(lambda: gone(child))


@pytest.mark.parametrize('ends_first', [False, True])
def test_the_program_of_a_wrapper_that_ends_at_once_has_the_time_to_write_its_file(start, tmp_path, ends_first):
    """As the recorder below ``rosbag record``, which closes its bag after a SIGINT."""
    file = tmp_path / 'written'
    program = ('import sys, time\ntry:\n    print("runs", flush=True); time.sleep(60)\nexcept KeyboardInterrupt:\n'
               f'    time.sleep(0.5); open({str(file)!r}, "w").close()')
    process = start(f'import subprocess, sys, time\nsubprocess.Popen([sys.executable, "-c", {program!r}])\n'
                    + 'time.sleep(60)' * (not ends_first))
    first_line(process)
    if ends_first:
        until(lambda: not process.runs())
    process.stop(((signal.SIGINT, SOON), (signal.SIGKILL, SOON)))
    assert file.exists() and not process.members()


def test_without_a_group_of_its_own_others_are_left_alone(start):
    process = start(PARENT + 'time.sleep(60)', own_group=False)
    child = int(first_line(process))
    assert os.getpgid(child) == os.getpgid(0)
    process.stop(QUICK)
    assert not process.runs() and not gone(child)
    psutil.Process(child).kill()


def test_a_group_whose_number_is_another_processs_is_empty(start):
    process = start(PARENT + 'time.sleep(60)')
    child = int(first_line(process))
    assert {member.pid for member in processes.group(psutil.Process(process.pid))} == {process.pid, child}
    assert processes.group(other_with_number(process.pid)) == set()


def test_a_process_with_the_number_of_another_is_not_ended(start):
    process = start('import time; print(1, flush=True); time.sleep(60)')
    first_line(process)
    processes.end(lambda: {other_with_number(process.pid)}, ((signal.SIGKILL, 0.2),))
    assert process.runs()
    processes.end(lambda: {psutil.Process(process.pid)} if process.runs() else set(), QUICK)
    assert not process.runs()


def test_who_has_ended_but_was_not_reaped_is_not_waited_for(start):
    process = start('')
    identity = psutil.Process(process.pid)
    until(lambda: gone(process.pid))  # it stays a zombie until poll() or wait()
    looks = []
    processes.end(lambda: looks.append(1) or {identity}, ((signal.SIGKILL, SOON),))
    assert len(looks) == 1
    assert processes.runs(psutil.Process()) and not processes.runs(identity)
    process.stop()
    assert not processes.runs(identity)


def test_processes_that_are_slow_to_find_are_killed_to_the_last(start):
    """Of thousands, some were not even found within the time of the signal, and went on."""
    process = start('import subprocess, time\nwhile True:\n    subprocess.Popen(["sleep", "10"])\n'
                    '    print(1, flush=True)\n    time.sleep(0.05)')
    first_line(process)
    identity = psutil.Process(process.pid)

    def find():
        found = processes.group(identity)
        time.sleep(0.3)
        return found
    processes.end(find, ((signal.SIGKILL, 0.2),))
    until(lambda: not processes.group(identity))


def test_tree_and_descendants(start):
    process = start(PARENT + 'time.sleep(60)')
    child = int(first_line(process))
    assert [member.pid for member in processes.tree(psutil.Process(process.pid))] == [process.pid, child]
    assert processes.descendant_ids(process.pid) == {child}
    identity = psutil.Process(process.pid)
    process.stop(QUICK)
    assert processes.tree(identity) == [] and processes.descendant_ids(process.pid) == set()


def test_marked_processes_are_found_and_this_one_is_not(start, monkeypatch):
    monkeypatch.setenv('TURTLE_ROBOTONT_TEST_MARK', 'x')
    process = start(PARENT + 'time.sleep(60)', env={**os.environ, 'TURTLE_ROBOTONT_TEST_MARK': 'own'})
    child = int(first_line(process))
    nobody = start('')
    until(lambda: not nobody.runs())
    found = processes.related('TURTLE_ROBOTONT_TEST_MARK=own', nobody._identity)
    assert {member.pid for member in found} == {process.pid, child}
    below = {member.pid for member in processes.related('TURTLE_ROBOTONT_TEST_MARK=none', psutil.Process())}
    assert {process.pid, child} <= below and os.getpid() not in below


def test_thread_times_grow_and_end_with_the_process(start):
    def work():
        end = time.thread_time() + 0.05
        while time.thread_time() < end:
            pass
        times.update(processes.thread_times(os.getpid()))
    times = {}
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    ran, waited = times[str(thread.native_id)]
    assert 0.05 <= ran < 1.0 and waited >= 0.0
    process = start('')
    until(lambda: not process.runs())
    assert processes.thread_times(process.pid) == {}


def test_cpu_time_grows_and_ends_with_the_process(start):
    before = processes.cpu_time(os.getpid())
    sum(range(300_000))
    assert processes.cpu_time(os.getpid()) > before
    process = start('')
    until(lambda: not process.runs())
    with pytest.raises(OSError):
        processes.cpu_time(process.pid)


def test_a_process_ends_with_its_parent(start):
    code = ('import subprocess, sys, time\nfrom plain_support.processes import end_with_parent\n'
            'child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"], '
            'start_new_session=True, preexec_fn=end_with_parent)\nprint(child.pid, flush=True)\ntime.sleep(60)')
    process = start(code)
    child = int(first_line(process))
    process.process.kill()
    until(lambda: gone(child))


@pytest.mark.parametrize('number', processes.END_SIGNALS)
def test_interruptible_once(number):
    code = ('import os, time\nfrom plain_support.processes import make_interruptible\nmake_interruptible()\n'
            f'try:\n    os.kill(os.getpid(), {int(number)})\n    time.sleep(5)\nexcept KeyboardInterrupt:\n'
            f'    os.kill(os.getpid(), {int(number)})\n    print("cleaned up")\n')
    done = subprocess.run([sys.executable, '-c', code], stdout=subprocess.PIPE, timeout=30, check=False)
    assert done.stdout == b'cleaned up\n'
