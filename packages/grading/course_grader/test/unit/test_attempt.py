"""course_grader.attempt.attempt: when time starts, and whose fault it is if it passes slowly."""
import os
import time
import types

import pytest

from course_grader.attempt import attempt
from course_grader.attempt.faults import ProgramFault
from course_grader.attempt.graph import Graph
from course_grader.attempt.load import Flood, Load, Pace
from course_grader.rules.observation import Observed, Problem
from course_grader.supervision import policy


def an_attempt(**parts):
    """Return an Attempt with ``parts`` in place of its own."""
    made = object.__new__(attempt.Attempt)
    made.observed, made._deadline, made._policy = Observed(), float('inf'), policy.decide()
    for name, part in parts.items():
        setattr(made, name, part)
    return made


def a_program(**parts):
    """Return a Student that runs, and needs next to nothing."""
    return types.SimpleNamespace(**{'cpu': lambda: 0.0, 'greedy': lambda: False, 'exit_code': lambda: None,
                                    'has_children': lambda: False, **parts})


@pytest.mark.parametrize('served, text', [(3.0, None), (60.0, 'for 60 s of processor time in 150 s')])
def test_who_took_the_time_until_the_program_started_is_named(monkeypatch, served, text):
    """The limit may be met before it is watched: it was said to keep the grader busy "for 0 s in 0 s", and failed."""
    reads_nothing = types.SimpleNamespace(read=lambda: None)
    made = an_attempt(
        busy='', _late_before=0, _deadline=0.0, exercise=types.SimpleNamespace(time=30.0), _state=reads_nothing,
        _navigation=reads_nothing, _guard=types.SimpleNamespace(refused=lambda: None),
        _graph=types.SimpleNamespace(had_nodes=lambda: True), _simulation=types.SimpleNamespace(
            check_runs=lambda: None, link=types.SimpleNamespace(step=lambda *_: time.sleep(0.01), late=0)))
    monkeypatch.setattr('course_grader.attempt.load.cpu_time', lambda _: served / 3.0)
    load = Load(a_program(), (1, 2))
    load._before = 0.0, 0.0, time.monotonic() - 150.0
    reader, pace = types.SimpleNamespace(now=0.0, dt=0.016, read=lambda: None), Pace()
    made._watch(reader, a_program(), None, pace)
    made._conclude(reader, pace, Flood(os.getpid()), load)
    assert not made.observed.kept_up
    assert text in made.observed.problem.text if text else made.observed.problem is None


def test_time_starts_with_a_node_that_has_ended_already():
    """A script of rosservice calls: on a busy machine its first node was over between two polls, and time stood on."""
    made = an_attempt(
        _graph=types.SimpleNamespace(has_nodes=lambda: False, had_nodes=lambda: True),
        _policy=types.SimpleNamespace(lockstep=False), _simulation=types.SimpleNamespace(
            link=types.SimpleNamespace(step=lambda _count: pytest.fail('it waits on'))))
    made._wait_for_nodes(a_program(has_children=lambda: True))


def test_names_that_are_too_long_to_read_are_the_programs():
    """The answer of the master is then longer than what xmlrpc.client reads, and the grader broke down each time."""
    def refuse():
        raise ValueError('max gzipped payload length exceeded')
    graph = Graph(types.SimpleNamespace(beside=(), robots=()), types.SimpleNamespace(getSystemState=refuse), '',
                  {'/grader'}, Observed())
    with pytest.raises(ProgramFault, match='so long names'):
        graph.has_nodes()


@pytest.mark.parametrize('busy, problem, waited', [
    (False, None, attempt.IDLE_START), (True, None, attempt.BUSY_IDLE_START),
    (False, Problem('too many connections'), 0)])
def test_an_idle_program_has_more_time_to_start_on_a_busy_machine(monkeypatch, busy, problem, waited):
    """Two of 100 right programs, at a load of 30 to 100, were idle for 10 s before their first call was answered."""
    made = an_attempt(
        _graph=types.SimpleNamespace(has_nodes=lambda: False, had_nodes=lambda: False),
        _policy=types.SimpleNamespace(lockstep=False), _simulation=types.SimpleNamespace(
            link=types.SimpleNamespace(step=lambda _count: None), overloaded=lambda: problem))
    polled = []
    monkeypatch.setattr(attempt, 'POLL', 0.0)
    monkeypatch.setattr(attempt, 'Machine', lambda: types.SimpleNamespace(is_busy=lambda: busy))
    monkeypatch.setattr(attempt.sandbox, 'ProgramIdleTimer', lambda _student: types.SimpleNamespace(
        poll=lambda: polled.append(len(polled)) or polled[-1]))
    if problem:
        with pytest.raises(ProgramFault, match='too many connections'):
            made._wait_for_nodes(a_program())
    else:
        made._wait_for_nodes(a_program())
    assert polled[-1] == waited
