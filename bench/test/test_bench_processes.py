"""Processes of bench/processes.py: CPU time and memory, deadlines, and that nothing is left behind."""
import os
import sys
import time

import psutil
import pytest

from processes import BenchError, Child, cpu_between, stop_all, tree, tree_cpu, tree_memory

SOON = 5.0  # [s] deadline of what takes well under one


def python(code):
    return [sys.executable, '-c', code]


def gone(pid):
    """Whether a process has ended, reaped by its parent or not."""
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_cpu_between_counts_newcomers_and_forgets_the_ended():
    assert cpu_between({1: 1.0, 2: 5.0}, {1: 1.5, 3: 0.25}) == 0.75


def test_own_cpu_and_memory():
    before = tree_cpu(os.getpid())
    sum(range(300000))
    assert 0.0 < cpu_between(before, tree_cpu(os.getpid())) < SOON
    memory, peak = tree_memory(os.getpid())
    assert 1.0 < memory <= peak * 1.01


def test_lines_come_one_by_one(tmp_path):
    with Child('talker', python('print("one\\ntwo")'), None, str(tmp_path), lines=True) as child:
        assert [child.next_line(time.monotonic() + SOON) for _ in range(2)] == ['one', 'two']


def test_early_end_tells_the_last_lines(tmp_path):
    code = 'import sys; print("no such thing", file=sys.stderr); sys.exit(3)'
    with Child('node', python(code), None, str(tmp_path)) as child:
        child.process.wait(SOON)
        with pytest.raises(BenchError, match='(?s)exit code 3.*no such thing'):
            child.require_alive()


def test_end_of_a_watched_child_ends_the_waiting(tmp_path):
    with Child('probe', python('import time; time.sleep(60)'), None, str(tmp_path), lines=True) as probe:
        with Child('node', python('raise SystemExit("broken")'), None, str(tmp_path)) as node:
            with pytest.raises(BenchError, match='(?s)node ended early.*broken'):
                probe.next_line(time.monotonic() + SOON, [node])


def test_silence_ends_at_the_deadline(tmp_path):
    with Child('probe', python('import time; time.sleep(60)'), None, str(tmp_path), lines=True) as probe:
        begun = time.monotonic()
        with pytest.raises(BenchError, match='did not answer'):
            probe.next_line(begun + 0.3)
        assert time.monotonic() - begun < SOON


def test_missing_command(tmp_path):
    with pytest.raises(BenchError, match='cannot be started'):
        Child('node', [str(tmp_path / 'absent')], None, str(tmp_path))


def test_stop_takes_descendants_along(tmp_path):
    code = ('import subprocess, sys, time; '
            'print(subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"]).pid, flush=True); '
            'time.sleep(60)')
    with Child('parent', python(code), None, str(tmp_path), lines=True) as child:
        below = int(child.next_line(time.monotonic() + SOON))
        assert below in {process.pid for process in tree(child.pid)}
    deadline = time.monotonic() + SOON
    while not gone(below) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert gone(below)


def test_stop_all_ends_what_is_left(tmp_path):
    child = Child('left', python('import time; time.sleep(60)'), None, str(tmp_path))
    stop_all()
    assert child.process.poll() is not None
    assert child not in Child.alive
    child.stop()  # harmless


def test_a_probe_that_gives_up_shows_the_nodes_last_lines(tmp_path):
    with Child('node', python('print("waiting for a master", flush=True); import time; time.sleep(60)'), None,
               str(tmp_path)) as node:
        time.sleep(0.3)
        with Child('probe', python('raise SystemExit("no pose")'), None, str(tmp_path), lines=True) as probe:
            with pytest.raises(BenchError, match='(?s)no pose.*waiting for a master'):
                probe.next_line(time.monotonic() + SOON, [node])
