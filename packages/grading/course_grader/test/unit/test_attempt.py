"""How far an attempt lets time pass at once, and whose fault it is if time passes slowly."""
import math
import os
import subprocess
import time
import types

import pytest

from course_grader.attempt import attempt
from course_grader.rules.observation import Observed
from course_grader.supervision import policy

DT = 1.0 / 120.0  # [s]


@pytest.mark.parametrize('seconds, steps', [
    (1.0, 120), (0.5 * DT, 1), (1.5 * DT, 2),
    (DT + 1e-12, 1),  # rounding is no step more
    (1e-9 * DT, 1),  # nor none: the attempt would wait for the end of its time in vain
])
def test_steps_for(seconds, steps):
    assert attempt.steps_for(seconds, DT) == steps


@pytest.mark.parametrize('used, wall, expected', [
    (0.5, 0.2, False), (1.0, 0.0, False), (26.0, 25.0, False), (50.0, 25.0, True), (8.0, 4.0, True)])
def test_a_program_holds_the_simulation_up_by_more_than_one_core(used, wall, expected):
    """And not by its imports, just before it is watched."""
    assert attempt.hogs(used, wall) is expected


@pytest.mark.parametrize('ran, waited, used, expected', [
    (4.0, 90.0, 4.0, False),  # of 100 s: on a loaded machine it got no core, whatever it would have done
    (60.0, 10.0, 60.0, True), (30.0, 60.0, 30.0, True),  # most of the time for which it had one
    (5.0, 0.0, 5.0, False), (1.0, 10.0, 60.0, True)])  # undisturbed; in threads that have ended, one for each call
def test_a_simulator_is_flooded_if_it_is_busy_and_not_if_it_waits(ran, waited, used, expected):
    assert attempt._flooded({'7': (1.0, 2.0)}, {'7': (1.0 + ran, 2.0 + waited)}, 100.0, used) is expected


@pytest.fixture
def server():
    """A process in place of master and simulator: the memory of pytest itself grows with each test."""
    with subprocess.Popen(['sleep', '60']) as process:
        yield process
        process.kill()


def an_attempt(deadline=math.inf):
    made = object.__new__(attempt.Attempt)
    made.observed, made._deadline, made._beside = Observed(kept_up=False), deadline, {}
    return made


@pytest.mark.parametrize('used, served, deadline, said', [
    (10.0, 8.0, 0.0, ''),  # of 200 s: the machine
    (110.0, 8.0, 0.0, 'the program took 110 s of processor time in 200 s'),
    (110.0, 8.0, math.inf, ''),  # in real time, where the limit was not met, a busy loop may take a core
    (300.0, 8.0, math.inf, 'the program took 300 s of processor time in 200 s'),
    (10.0, 70.0, 0.0, 'the program kept master, simulator and grader busy, for 70 s of processor time in 200 s'),
    (10.0, 70.0, math.inf, ''),
])
def test_who_takes_the_time_is_named(used, served, deadline, said):
    made = an_attempt(deadline)
    made._note_hog(used, served, 200.0)
    assert made.observed.trouble.startswith(said) and bool(made.observed.trouble) == bool(said)


@pytest.mark.parametrize('served, said', [(3.0, ''), (60.0, 'for 60 s of processor time in 150 s')])
def test_who_took_the_time_until_the_program_started_is_named(monkeypatch, served, said):
    """The limit may be met before it is watched: it was said to keep the grader busy "for 0 s in 0 s", and failed."""
    made = an_attempt(deadline=0.0)
    made.observed.kept_up, made._policy, made._late_before, made.busy = True, policy.decide(), 0, ''
    made._link = types.SimpleNamespace(step=lambda *_: time.sleep(0.01), late=0)
    made._guard = types.SimpleNamespace(refused=lambda: '')
    made._state = made._navigation = types.SimpleNamespace(read=lambda: None)
    made.exercise = types.SimpleNamespace(time=30.0)
    made._master_process = own = types.SimpleNamespace(pid=os.getpid())
    monkeypatch.setattr(attempt, '_cpu_time', lambda _: served / 3.0)
    monkeypatch.setattr(made, '_runs', lambda _: True)
    student = types.SimpleNamespace(cpu=lambda: 1.0, greedy=lambda: False, exit_code=lambda: None)
    made._spent_before = 0.0, 0.0, time.monotonic() - 150.0
    made._watch(types.SimpleNamespace(now=0.0, dt=0.016, read=lambda: None), student, own, None)
    assert not made.observed.kept_up and said in made.observed.trouble and bool(said) == bool(made.observed.trouble)


@pytest.mark.parametrize('log, size, said', [
    ('_master_log', attempt.MAX_LOG + 1, 'the program filled the log of the master: 16 MB, at most 16 MB, by what it'),
    ('_simulator_log', attempt.MAX_LOG + 1, 'the program filled the log of the simulator: 16 MB'),
    ('_master_log', attempt.MAX_LOG, ''),
])
def test_a_log_that_grows_without_bound_is_the_programs(tmp_path, server, log, size, said):
    made = an_attempt()
    made._master_process = server
    for name in ('_master_log', '_simulator_log'):
        setattr(made, name, str(tmp_path / name))
        (tmp_path / name).write_bytes(b'')
    os.truncate(tmp_path / log, size)
    made._check_servers(server)
    assert made.observed.trouble.startswith(said) and bool(made.observed.trouble) == bool(said)


def test_memory_that_grows_without_bound_is_the_programs(monkeypatch, server):
    made = an_attempt()
    made._master_process, made._master_log, made._simulator_log = server, os.devnull, os.devnull
    monkeypatch.setattr(attempt, 'MAX_SERVER_MEMORY', 1)
    made._check_servers(server)
    assert made.observed.trouble.startswith('the program filled the memory of the ')


def test_time_starts_with_a_node_that_has_ended_already():
    """A script of rosservice calls: on a busy machine its first node was over between two polls, and time stood on."""
    made = an_attempt()
    made._policy, made._student_is_there, made._was_there = types.SimpleNamespace(lockstep=False), bool, lambda: True
    made._link = types.SimpleNamespace(step=lambda _count: pytest.fail('it waits on'))
    made._wait_for_student(types.SimpleNamespace(exit_code=lambda: None, cpu=lambda: 0.0, has_children=lambda: True),
                           None)


def test_connections_without_bound_are_the_programs(monkeypatch, server):
    """The master has a thread for each: 20,000 of them took all processes of the machine from the gradings beside."""
    made = an_attempt()
    made._master_process, made._master_log, made._simulator_log = server, os.devnull, os.devnull
    made._check_servers(server)
    assert made.observed.trouble == ''
    monkeypatch.setattr(attempt, 'MAX_SERVER_THREADS', 0)
    made._check_servers(server)
    assert made.observed.trouble.startswith('the program opened too many connections to the ')


def test_who_wants_many_cores_and_is_late_gets_the_reason():
    made = an_attempt()
    made._note_hog(10.0, 8.0, 200.0, greedy=True)
    assert 'kept 8 or more threads busy' in made.observed.trouble
    made = an_attempt()
    made.observed.kept_up = True
    made._note_hog(10.0, 8.0, 200.0, greedy=True)
    assert made.observed.trouble == ''


def test_names_that_are_too_long_to_read_are_the_programs():
    """The answer of the master is then longer than what xmlrpc.client reads, and the grader broke down each time."""
    made = an_attempt()
    made.observed.kept_up = True

    def refuse():
        raise ValueError('max gzipped payload length exceeded')
    made._master, made._node, made._simulator = types.SimpleNamespace(getSystemState=refuse), '/grader', '/turtlesim'
    assert made._student_is_there()  # it is not waited for any longer
    assert 'so long names' in made.observed.trouble


@pytest.mark.parametrize('busy, trouble, waited', [
    (False, '', attempt.IDLE_START), (True, '', attempt.BUSY_IDLE_START), (False, 'too many connections', 1)])
def test_an_idle_program_has_more_time_to_start_on_a_busy_machine(monkeypatch, busy, trouble, waited):
    """Two of 100 right programs, at a load of 30 to 100, were idle for 10 s before their first call was answered."""
    made, idle = an_attempt(), iter(range(1000))
    made._policy = types.SimpleNamespace(lockstep=False)
    made._link = types.SimpleNamespace(step=lambda _count: None)
    made._student_is_there = lambda: False
    polled = []
    monkeypatch.setattr(attempt, 'POLL', 0.0)
    monkeypatch.setattr(attempt, 'Machine', lambda: types.SimpleNamespace(is_busy=lambda: busy))
    monkeypatch.setattr(attempt.sandbox, 'ProgramIdleTimer', lambda _student: types.SimpleNamespace(
        poll=lambda: polled.append(next(idle)) or polled[-1]))
    made._was_there = lambda: False
    made._check_servers = lambda _simulator: setattr(made.observed, 'trouble', trouble)
    made._wait_for_student(types.SimpleNamespace(exit_code=lambda: None, cpu=lambda: 0.0, has_children=lambda: False),
                           None)
    assert polled[-1] == waited
