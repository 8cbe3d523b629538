"""course_grader.supervision.supervisor: when an attempt is repeated, and what the last one says."""
import os
import threading
import time
import types

import pytest

from course_grader.rules import exercise, scoring
from course_grader.rules.observation import Observed, Sample
from course_grader.supervision import supervisor
from course_grader.supervision.job import Attempted, Job
from course_grader.supervision.supervisor import MAX_REPEATED, Supervisor
from rostest_support.waiting import until


def attempted(outcome, kept_up=True, lockstep=True, busy='', flooded=False, broken=False):
    verdict = scoring.Verdict(outcome, 0.0, [], ['it was slow'])
    return Attempted(verdict, Observed(kept_up=kept_up), (), lockstep, busy, flooded, broken)


SLOW = attempted('undecided', kept_up=False)
BUSY = attempted('undecided', kept_up=False, busy='/student')


@pytest.mark.parametrize('got, used, seconds, name, real_time', [
    (attempted('passed'), [], 1.0, None, None),
    (attempted('failed'), [], 1.0, None, None),
    (attempted('undecided'), [], 1.0, None, None),  # the grader failed: another time would, too
    (attempted('undecided', broken=True), [], 1.0, 'broken', False),
    (attempted('undecided', broken=True), ['broken'], 1.0, None, None),
    (SLOW, [], 1.0, 'slow', False),
    (SLOW, ['slow'], 1.0, 'slow again', True),  # should it be the lockstep
    (SLOW, ['slow', 'slow again'], 1.0, 'alone', False),
    (SLOW, [], MAX_REPEATED + 1.0, 'alone', False),
    (SLOW, ['alone'], MAX_REPEATED + 1.0, None, None),
    (attempted('failed', kept_up=False), [], 1.0, None, None),
    (BUSY, [], 1.0, 'busy', True),
    (BUSY, [], MAX_REPEATED + 1.0, 'busy', True),  # a program that never sleeps has a right to real time
    (BUSY._replace(lockstep=False), ['busy'], 1.0, 'slow', False),
    (attempted('passed', kept_up=False, busy='/student'), [], 1.0, 'busy', True),
])
def test_an_attempt_is_repeated_when_it_decides_nothing(got, used, seconds, name, real_time):
    retry = supervisor.next_try(got, used, seconds)
    assert (retry and retry.name, retry and retry.real_time) == (name, real_time)


@pytest.mark.parametrize('got, busy, outcome', [
    (attempted('undecided', lockstep=False, flooded=True), '/student', 'failed'),
    (attempted('undecided', lockstep=False, flooded=True), '', 'undecided'),  # nobody was busy: the machine was slow
    (attempted('undecided', lockstep=False), '/student', 'undecided'),
    (attempted('passed', lockstep=False, flooded=True), '/student', 'passed'),
])
def test_who_floods_the_simulator_fails(got, busy, outcome):
    said = supervisor.final(got, busy).verdict
    assert said.outcome == outcome
    assert outcome != 'failed' or said.objections[0].startswith('/student never sleeps')


def test_who_breaks_the_grading_each_time_fails():
    said = supervisor.final(attempted('undecided', broken=True), '', again=True).verdict
    assert (said.outcome, said.score) == ('failed', 0.0)
    assert said.objections == ['the grading broke down while this program ran, each time: it was slow']


def test_who_breaks_the_grading_once_is_undecided():
    assert supervisor.final(attempted('undecided', broken=True), '').verdict.outcome == 'undecided'


def test_the_texts_of_repeats_name_node_and_reason():
    texts = [retry.text.format(busy='/student', reason='it was slow') for retry in supervisor.RETRIES]
    assert texts[0].startswith('/student never sleeps')
    assert set(texts[1:]) == {'Grading again, because it was slow',
                              'Grading again, alone and with more time, because it was slow'}


class Attempts:
    """The part of a Supervisor that makes attempts; they return ``results`` one after the other."""

    def __init__(self, *results):
        self._gate, self.results, self.limits = supervisor._Gate(), list(results), []

    def _attempt(self, job, deadline):
        self.limits.append(round(deadline - time.monotonic()))
        return self.results.pop(0)


def graded(attempts, limit=None):
    job = Job(types.SimpleNamespace(time=10.0), (), '', '', 1)
    return Supervisor._grade(attempts, job, limit, lambda text: None).verdict.outcome


MANY_SLOW = SLOW, SLOW, SLOW
BROKEN = attempted('undecided', broken=True)


@pytest.mark.parametrize('results, limit, outcome, limits', [
    ([attempted('passed')], None, 'passed', [130]),
    ([*MANY_SLOW, attempted('passed')], None, 'passed', [130, 130, 130, 390]),
    ([*MANY_SLOW, SLOW], None, 'undecided', [130, 130, 130, 390]),  # never a score of 0
    ([*MANY_SLOW, SLOW], 60.0, 'undecided', [60, 60, 60, 60]),  # who asks for a limit gets it
    ([BROKEN, BROKEN], None, 'failed', [130, 390]),
    ([BROKEN], -1.0, 'undecided', [-1]),  # its time is over
])
def test_an_attempt_for_which_the_machine_was_slow_is_made_again_with_more_time(results, limit, outcome, limits):
    attempts = Attempts(*results)
    assert graded(attempts, limit) == outcome
    assert attempts.limits == limits


@pytest.mark.parametrize('scores, score, counts, made', [
    ([90.0, 85.0, 100.0], 85.0, 2, 3), ([100.0, 40.0, 0.0], 40.0, 2, 2), ([30.0], 30.0, 1, 1)])
def test_of_several_starts_the_worst_counts(scores, score, counts, made):
    results = [Attempted(scoring.Verdict('passed' if one >= 80.0 else 'failed', one, [], []), Observed())
               for one in scores]
    attempts, seeds = Attempts(*results), []
    attempts._grade = lambda job, limit, say: seeds.append(job.seed) or Supervisor._grade(attempts, job, limit, say)
    job = Job(types.SimpleNamespace(time=10.0, starts=3, shift={}, solution=''), (), '', '', 7)
    got = Supervisor._starts(attempts, job, None, lambda text: None)[1]
    assert (got.verdict.score, seeds) == (score, [7, 10_007, 20_007][:made])
    assert got.remarks[0].startswith(f'start {counts} of 3 counts')


SAME_PATH = exercise.parse({'title': 'T', 'asks': 'Drive.', 'time': '9 s', 'solution': 'pass',
                            'checks': [{'check': 'same_path', 'points': 100}]})
DRIVEN = [Sample(0.1 * tick, 0.1 * tick, 0.0, 0.0) for tick in range(30)]


@pytest.mark.parametrize('track, outcome, reason', [
    (DRIVEN, 'passed', ''),
    ([], 'undecided', 'the solution in the exercise file does not pass: 0 of 100: asked: the path of the solution, ')])
def test_the_solution_is_graded_once_for_each_start(monkeypatch, track, outcome, reason):
    graded = []

    def grade(job, limit, say):
        graded.append(job)
        observed = Observed(track=list(track), solution=list(job.solution))
        return Attempted(scoring.decide(job.exercise, observed), observed)
    attempts = Attempts()
    attempts._grade, attempts._solving, attempts._solutions = grade, threading.Lock(), {}
    attempts._solution = lambda job, limit: Supervisor._solution(attempts, job, limit)
    job = Job(SAME_PATH, ('student.py',), 'theirs', 'results', 1, packages='theirs')
    found = [Supervisor._starts(attempts, job._replace(seed=seed), None, lambda text: None)[1].verdict
             for seed in (1, 1, 2)]
    assert {one.outcome for one in found} == {outcome}
    assert all(''.join(one.objections).startswith(reason) for one in found)
    students = [one for one in graded if one.command == ('student.py',)]
    solutions = [one for one in graded if one not in students]
    assert [one.seed for one in solutions] == ([1, 2] if track else [1, 1, 2])
    assert len(students) == (3 if track else 0)
    assert not any(one.packages or one.isolation.own or os.path.exists(one.command[0]) for one in solutions)


def test_an_attempt_alone_waits_for_the_others_which_then_wait_for_it():
    gate, events = supervisor._Gate(), []

    def attempt(name, alone):
        with gate.passed(alone):
            events.append(name)
    with gate.passed(alone=False):
        alone = threading.Thread(target=attempt, args=('alone', True))
        alone.start()
        until(lambda: gate._closed)
        other = threading.Thread(target=attempt, args=('other', False))
        other.start()
        assert not events
    alone.join()
    other.join()
    assert events == ['alone', 'other']


@pytest.mark.parametrize('ran, waited, starved', [
    (5.0, 90.0, True),  # of 100 s: an honest program at a load of 20
    (5.0, 10.0, False),  # it hung for another reason than a core
    (60.0, 90.0, False),  # it is the load
])
def test_who_waits_for_a_core_is_not_who_takes_it(monkeypatch, ran, waited, starved):
    process = types.SimpleNamespace(pid=1, cpu_times=lambda: types.SimpleNamespace(
        user=ran, system=0.0, children_user=0.0, children_system=0.0))
    monkeypatch.setattr(supervisor.processes, 'tree', lambda child: [child])
    monkeypatch.setattr(supervisor.processes, 'thread_times', lambda pid: {'1': (ran, waited)})
    assert supervisor._starved(process, 100.0) == starved


def test_of_a_log_that_a_program_has_filled_only_the_start_is_kept(tmp_path):
    for name, size in (('master.txt', supervisor.MAX_KEPT + 9), ('simulator.txt', 5)):
        (tmp_path / name).write_bytes(b'x' * size)
    supervisor._shorten(str(tmp_path))
    kept = (tmp_path / 'master.txt').read_text()
    assert kept[:supervisor.MAX_KEPT] == 'x' * supervisor.MAX_KEPT
    assert kept[supervisor.MAX_KEPT:] == '\n... only the first 1 MB are kept\n'
    assert (tmp_path / 'simulator.txt').read_text() == 'xxxxx'
