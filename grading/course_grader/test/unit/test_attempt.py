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
