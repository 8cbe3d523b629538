"""usb_cam.core.pace: deadlines on a grid, by a clock that only the test moves."""
import pytest

from usb_cam.core.pace import FrameSchedule

ROUNDING = 1e-9  # [s]


class Clock:
    now = 1000.0

    def __call__(self):
        return self.now


def shown_at(rate, works):
    """Return when each of the pictures was begun, from 0 on, if working on them takes ``works`` [s]."""
    clock, times = Clock(), []
    schedule = FrameSchedule(rate, clock)
    for work in works:
        clock.now += max(0.0, schedule.time_left())
        schedule.advance()
        times.append(clock.now - 1000.0)
        clock.now += work
    return times


def test_pictures_keep_the_rate_whatever_each_takes():
    # 900 pictures at 30 Hz that take from 0 to 32 ms: number k begins at k / 30 s, without drift
    times = shown_at(30.0, [(number * 7 % 33) / 1000.0 for number in range(900)])
    assert times == pytest.approx([number / 30.0 for number in range(900)], abs=ROUNDING)


@pytest.mark.parametrize('late, expected', [
    (0.13, [0.0, 0.13, 0.2, 0.3]),  # a little: the grid is kept
    (0.57, [0.0, 0.57, 0.6, 0.7]),  # more than a period: missed images are skipped, without a burst, and the grid stays
])
def test_a_late_picture_puts_off_no_other(late, expected):
    assert shown_at(10.0, [late, 0.0, 0.0, 0.0]) == pytest.approx(expected, abs=ROUNDING)


def test_too_slow_for_the_rate_means_as_fast_as_it_goes_on_the_grid():
    assert shown_at(10.0, [0.25] * 4) == pytest.approx([0.0, 0.25, 0.5, 0.75], abs=ROUNDING)


def test_after_a_break_the_next_picture_is_due_at_once():
    clock = Clock()
    schedule = FrameSchedule(2.0, clock)
    schedule.advance()
    assert schedule.time_left() == pytest.approx(0.5, abs=ROUNDING)
    clock.now += 60.0
    schedule.restart()
    assert schedule.time_left() == 0.0
    schedule.advance()
    assert schedule.time_left() == pytest.approx(0.5, abs=ROUNDING)
