"""How far an attempt lets time pass at once."""
import pytest

from course_grader.attempt import attempt

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
