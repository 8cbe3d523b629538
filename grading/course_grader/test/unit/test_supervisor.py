"""course_grader.supervision.supervisor: when an attempt is repeated, and what the last one says."""
import pytest

from course_grader.rules import scoring
from course_grader.rules.observation import Observed
from course_grader.supervision import supervisor
from course_grader.supervision.job import Attempted
from course_grader.supervision.supervisor import MAX_REPEATED


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
    (SLOW, ['slow', 'slow again'], 1.0, None, None),
    (SLOW, [], MAX_REPEATED + 1.0, None, None),
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
    said = supervisor.final(attempted('undecided', broken=True), '').verdict
    assert (said.outcome, said.score) == ('failed', 0.0)
    assert said.objections == ['the grading broke down while this program ran, each time: it was slow']


def test_the_texts_of_repeats_name_node_and_reason():
    texts = [retry.text.format(busy='/student', reason='it was slow') for retry in supervisor.RETRIES]
    assert texts[0].startswith('/student never sleeps')
    assert set(texts[1:]) == {'Grading again, because it was slow'}
