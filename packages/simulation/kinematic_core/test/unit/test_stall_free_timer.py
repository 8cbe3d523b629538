"""kinematic_core.timing.stall_free_timer: time in which this process ran."""
import pytest

from kinematic_core.timing.stall_free_timer import MAX_GAP, ActiveTimer


def test_a_machine_that_stands_still_uses_up_one_look_only():
    clock = iter([10.0, 10.02, 10.05, 15.05, 15.06])
    timer = ActiveTimer(monotonic=lambda: next(clock))
    assert [timer.elapsed() for _ in range(4)] == pytest.approx([0.02, 0.05, 0.05 + MAX_GAP, 0.06 + MAX_GAP])
    assert timer.lost == pytest.approx(5.0 - MAX_GAP)
