"""course_grader.isolation.limits: what is counted, and how a limit that was met is named."""
import argparse
import os
import subprocess
import sys
import time

import pytest

from course_grader.isolation import limits
from course_grader.isolation.limits import Limits, Meter
from rostest_support.waiting import until

pytestmark = pytest.mark.slow

DEADLINE = 200.0  # [s] of wall time, for one of processor time on a loaded machine


def test_the_options_give_the_limits_and_refuse_nonsense(capsys):
    parser = argparse.ArgumentParser()
    limits.add_options(parser)
    assert limits.chosen(parser.parse_args([])) == Limits()
    assert limits.chosen(parser.parse_args(['--max-memory', '100', '--max-cpu', '5'])) == Limits(memory=100, cpu=5)
    for text in ('0', '-1', 'many', '1e9', '1000001'):
        with pytest.raises(SystemExit):
            parser.parse_args(['--max-disk', text])
        assert f'it is {text}; it must be a whole number' in capsys.readouterr().err or text == '-1'


@pytest.mark.parametrize('own, inside, release, counted', [
    (True, False, '4.19.0', True), (False, False, '6.1.0', False), (False, True, '5.10.0-28', False),
    (False, True, '5.14', True), (False, True, '6.18.44-fc', True), (False, True, 'strange', False),
])
def test_processes_are_counted_where_those_of_the_teacher_are_not(own, inside, release, counted):
    assert limits.counts_processes(own, inside, release) is counted


@pytest.mark.parametrize('program, most, reason', [
    ('while True: pass', Limits(cpu=1), 'processor time: 1 s (--max-cpu)'),
    ('import subprocess, sys\nwhile True: subprocess.run([sys.executable, "-S", "-c", "sum(range(10**6))"])',
     Limits(cpu=1), 'processor time: 1 s (--max-cpu)'),
    ('import time; b = bytearray(60 << 20); time.sleep(60)', Limits(memory=50),
     'memory of all its processes: 50 MB (--max-memory)'),
    ('import threading, time\nfor _ in range(9): threading.Thread(target=time.sleep, args=[60]).start()',
     Limits(processes=8), 'processes and threads at a time: 8 (--max-processes)'),
])
def test_what_all_processes_use_together_is_counted(program, most, reason):
    with subprocess.Popen([sys.executable, '-c', program]) as process:
        try:
            met = until(Meter(most, lambda: [process.pid], lambda _: 0.0).poll)
        finally:
            process.kill()
    assert met == f'the program exceeded a limit: {reason}'


@pytest.mark.parametrize('count, greedy', [(limits.MANY_BUSY + 2, True), (2, False)])
def test_program_that_wants_many_cores_gets_only_idle_ones(count, greedy):
    busy = [subprocess.Popen([sys.executable, '-S', '-c', 'while True: pass']) for _ in range(count)]
    try:
        meter = Meter(Limits(), lambda: [process.pid for process in busy], lambda _: 0.0)
        end = time.monotonic() + (DEADLINE if greedy else 1.0)
        while not meter.greedy and time.monotonic() < end:
            assert meter.poll() is None
            time.sleep(0.05)
        assert meter.greedy is greedy
        classes = {os.sched_getscheduler(process.pid) for process in busy}
        assert classes == {os.SCHED_IDLE if greedy else os.SCHED_OTHER}
    finally:
        for process in busy:
            process.kill()
            process.wait()


def test_what_ends_between_two_looks_is_nothing():
    with subprocess.Popen(['true']) as process:
        pass
    meter = Meter(Limits(), lambda: [process.pid], lambda _: 0.0)
    assert meter.poll() is None and meter.cpu() == 0.0


@pytest.mark.parametrize('code, name', [(-24, 'cpu'), (128 + 25, 'file_size'), (-9, None), (1, None), (137, None)])
def test_the_signal_of_a_limit(code, name):
    assert limits.of_signal(code) == name
