"""course_grader.attempt.simulation: how far time passes at once, what a program may make of the servers."""
import os
import subprocess
import types

import pytest

from course_grader.attempt import simulation
from course_grader.attempt.faults import AttemptError
from course_grader.attempt.simulation import Simulation

DT = 1.0 / 120.0  # [s]


@pytest.mark.parametrize('seconds, steps', [
    (1.0, 120), (0.5 * DT, 1), (1.5 * DT, 2),
    (DT + 1e-12, 1),  # rounding is no step more
    (1e-9 * DT, 1),  # nor none: the attempt would wait for the end of its time in vain
])
def test_steps_for(seconds, steps):
    assert simulation.steps_for(seconds, DT) == steps


@pytest.fixture
def started(tmp_path):
    """Return a Simulation with a process of its own for master and simulator: pytest itself may be large."""
    made = object.__new__(Simulation)
    made.master_log, made._simulator_log = str(tmp_path / 'master.txt'), str(tmp_path / 'simulator.txt')
    for log in (made.master_log, made._simulator_log):
        with open(log, 'wb'):
            pass
    with subprocess.Popen(['sleep', '60']) as process:
        made._master_process = made._simulator = process
        yield made
        process.kill()


@pytest.mark.parametrize('log, size, text', [
    ('master_log', simulation.MAX_LOG + 1, 'the program filled the log of the master: 16 MB, at most 16 MB, by'),
    ('_simulator_log', simulation.MAX_LOG + 1, 'the program filled the log of the simulator: 16 MB'),
    ('master_log', simulation.MAX_LOG, None),
])
def test_a_log_that_grows_without_bound_is_the_programs(started, log, size, text):
    os.truncate(getattr(started, log), size)
    problem = started.overloaded()
    assert problem.text.startswith(text) if text else problem is None


@pytest.mark.parametrize('limit, text', [
    ('MAX_SERVER_MEMORY', 'the program filled the memory of the '),
    ('MAX_SERVER_THREADS', 'the program opened too many connections to the ')])
def test_memory_and_connections_without_bound_are_the_programs(monkeypatch, started, limit, text):
    """The master has a thread for each: 20,000 of them took all processes of the machine from the gradings beside."""
    assert started.overloaded() is None
    monkeypatch.setattr(simulation, limit, 0)
    assert started.overloaded().text.startswith(text)


def test_the_reason_of_a_simulator_that_does_not_start_is_told(started):
    with open(started._simulator_log, 'w', encoding='utf-8') as log:
        log.write('Starting\n[ERROR] parameter /turtlesim/start is [20, 5, 0]\n\n')
    started._simulator = types.SimpleNamespace(poll=lambda: 2)
    with pytest.raises(AttemptError, match=r'code 2, see simulator.txt: \[ERROR\] parameter /turtlesim/start'):
        started._wait_for_start(lambda: False)
