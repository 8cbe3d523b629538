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
