"""kinematic_core.timing.pacing: when steps are due, on a wall clock that only the pacer's sleep or the test moves."""
import math
import threading

import pytest

from kinematic_core.timing import pacing
from kinematic_core.timing.pacing import Pacer

STEP = 0.016  # [s]


class Wall:
    """A wall clock; whoever sleeps on it wakes ``overshoot`` [s] late."""

    def __init__(self):
        self.now, self.overshoot, self.slept = 100.0, 0.0, []

    def monotonic(self):
        return self.now

    def sleep(self, seconds):
        assert seconds > 0.0
        self.slept.append(seconds)
        self.now += seconds + self.overshoot


@pytest.fixture
def wall():
    return Wall()


def pacer(wall, rate=1.0, bounded=False):
    return Pacer(STEP, rate, bounded, monotonic=wall.monotonic, sleep=wall.sleep)


def times(wall, paced, number):
    """Return when [s] the next steps begin."""
    begun = []
    while len(begun) < number:
        if paced.wait() is not None:
            begun.append(wall.now)
    return begun


@pytest.mark.parametrize('rate', [0.5, 1.0, 10.0, 1000.0])
@pytest.mark.parametrize('bounded', [False, True])
@pytest.mark.parametrize('overshoot', [0.0, 0.00001])
def test_steps_keep_the_pace_without_drift(wall, rate, bounded, overshoot):
    paced = pacer(wall, rate, bounded)
    wall.overshoot = overshoot / rate
    begun = times(wall, paced, 1000)
    assert begun[0] - 100.0 == pytest.approx(STEP / rate, abs=1e-4)
    assert begun[-1] - 100.0 == pytest.approx(1000 * STEP / rate, abs=1e-4)  # a drift would be 10 ms
    assert paced.steps == 1000


def test_simulated_time_is_counted_in_nanoseconds(wall):
    paced = pacer(wall, math.inf)
    assert paced.nanoseconds == 1_000_000_000  # not 0, which ROS takes for no time
    times(wall, paced, 100)
    assert paced.nanoseconds == 2_600_000_000  # 1 s + 100 * 16 ms, exactly


def test_as_fast_as_possible_never_sleeps_nor_gives_up(wall):
    paced = pacer(wall, math.inf, bounded=True)
    for _ in range(100):
        assert paced.wait() == 0.0
        wall.now += 60.0  # a step that takes a minute
    assert wall.slept == []


def test_late_steps_of_wall_time_come_soon(wall):
    paced = pacer(wall)
    paced.wait()
    wall.now += 1.0
    begun = times(wall, paced, 100)
    gaps = [after - before for before, after in zip(begun, begun[1:])]
    # 1 s / 16 ms = 62.5 are late; at 3 times the pace each step makes up for two thirds of one: 93 of them
    assert gaps[:92] == pytest.approx([STEP / pacing.FASTER] * 92)
    assert begun[99] == pytest.approx(100.0 + 101 * STEP)  # no ground is lost


def test_steps_that_each_take_long_are_not_slowed_down_more(wall):
    paced = pacer(wall)
    paced.wait()
    wall.now += 1.0
    for _ in range(10):
        assert paced.wait() == 0.0
        wall.now += STEP / 2.0
    assert len(wall.slept) == 1


def test_late_steps_of_bounded_time_come_little_faster_than_the_others(wall):
    paced = pacer(wall, 10.0, bounded=True)
    paced.wait()
    wall.now += 0.1  # 62 steps of 1.6 ms
    begun = times(wall, paced, 500)
    closest = min(after - before for before, after in zip(begun, begun[1:]))
    assert closest == pytest.approx(STEP / 10.0 / pacing.FASTER_BOUNDED)
    assert begun[-1] == pytest.approx(100.0 + 501 * STEP / 10.0)  # made up for after 62 / 0.25 = 250 steps


@pytest.mark.parametrize('bounded, gap', [(False, 5.5), (True, 0.6)])
def test_a_long_gap_is_given_up_once(wall, bounded, gap):
    paced = pacer(wall, 1.0, bounded)
    paced.wait()
    wall.now += gap
    assert paced.wait() == pytest.approx(gap - STEP)
    after = wall.now
    assert times(wall, paced, 10)[-1] == pytest.approx(after + 10 * STEP)


@pytest.mark.parametrize('bounded, gap', [(False, 4.5), (True, 0.4)])
def test_a_shorter_gap_is_not(wall, bounded, gap):
    paced = pacer(wall, 1.0, bounded)
    paced.wait()
    wall.now += gap
    assert paced.wait() == 0.0


def test_a_pause_is_not_made_up_for(wall):
    paced = pacer(wall)
    times(wall, paced, 3)
    paced.pause()
    assert [paced.wait(0.001) for _ in range(3)] == [None] * 3
    wall.now += 3.0
    paced.resume()
    paced.resume()  # a second one changes nothing
    assert paced.wait() in (None, 0.0)
    assert times(wall, paced, 2)[-1] <= 103.0 + 7 * STEP
    assert paced.steps in (5, 6)


@pytest.mark.parametrize('paused', [False, True])
def test_another_rate_counts_from_now(wall, paused):
    """Three steps late, in a pause or not: none is caught up, and the next ones come at the new rate."""
    paced = pacer(wall)
    times(wall, paced, 3)
    wall.now += 3 * STEP
    if paused:
        paced.pause()
    paced.set_rate(0.5, False)
    assert paced.rate == 0.5
    wall.now += paused * 7.0
    begin = wall.now
    if paused:
        paced.resume()
    assert times(wall, paced, 3) == pytest.approx([begin + 2 * STEP * number for number in (1, 2, 3)])


def test_a_faster_rate_ends_the_wait(wall):
    """A step is due in 100 s; after 0.1 s it is due in 0.1 s."""
    paced = pacer(wall, STEP / 100.0)
    assert paced.wait() is None
    paced.set_rate(STEP / 0.1, False)
    assert times(wall, paced, 1) == pytest.approx([100.0 + 0.1 + 0.1])


def test_a_pause_during_the_sleep_holds_the_step(wall):
    paced = Pacer(STEP, monotonic=wall.monotonic, sleep=lambda seconds: paced.pause())
    assert paced.wait() is None
    assert paced.steps == 0


def test_a_pause_that_ends_during_the_sleep_costs_no_step(wall):
    def sleep(seconds):
        paced.pause()
        paced.resume()
        wall.sleep(seconds)

    paced = Pacer(STEP, monotonic=wall.monotonic, sleep=sleep)
    assert times(wall, paced, 10)[-1] == pytest.approx(100.0 + 10 * STEP)


def test_a_sleep_that_ends_early_is_slept_again(wall):
    paced = Pacer(STEP, monotonic=wall.monotonic, sleep=lambda seconds: wall.sleep(min(seconds, STEP / 2.0)))
    assert times(wall, paced, 2) == pytest.approx([100.0 + STEP, 100.0 + 2.0 * STEP])


def test_steps_by_hand_take_no_wall_time_and_leave_a_pause(wall):
    paced = pacer(wall)
    assert paced.request(3).last == 3
    assert paced.request(2).last == 5
    assert [paced.wait(0.001) for _ in range(5)] == [0.0] * 5
    assert (paced.steps, paced.paused, wall.slept) == (5, True, [])
    assert paced.wait(0.001) is None


def test_requests_are_answered_in_their_order_when_their_steps_are_done(wall):
    paced = pacer(wall)
    requests = [paced.request(2), paced.pause(), paced.request(1)]
    seen = []
    for _ in range(4):
        seen.append([request.made for request in requests])
        paced.wait(0.001)
    seen.append([request.made for request in requests])
    assert seen == [[None] * 3, [None] * 3, [None] * 3, [True, True, None], [True] * 3]
    assert paced.pause().made


def test_a_pause_is_answered_when_the_step_in_time_is_done(wall):
    paced = pacer(wall)
    times(wall, paced, 1)
    request = paced.pause()
    assert request.made is None
    paced.wait(0.001)
    assert (request.made, request.last) == (True, 1)


def test_a_resume_gives_up_what_was_not_begun(wall):
    """The first step is being made: who asked for it gets it; who asked for more, or for a pause, does not."""
    paced = pacer(wall)
    requests = [paced.request(1), paced.pause(), paced.request(2)]
    paced.wait()
    assert paced.resume() == 1
    assert [request.made for request in requests] == [None, False, False]
    paced.wait(0.001)
    assert requests[0].made


def test_an_end_gives_up_what_was_requested(wall):
    paced = pacer(wall)
    request = paced.request(3)
    paced.close()
    assert request.wait(0.0) and request.made is False
    assert paced.request(1).made is False
    assert (paced.wait(0.001), paced.steps) == (None, 0)


def test_a_wake_ends_one_wait(wall):
    paced = Pacer(STEP, paused=True, monotonic=wall.monotonic, sleep=lambda seconds: paced.wake())
    assert paced.wait(1e9) is None
    paced.wake()
    assert paced.wait(1e9) is None


def test_wakes_hold_no_step_up(wall):
    paced = pacer(wall)
    paced.wait()
    for number in range(100):
        wall.now += STEP
        paced.wake()
        assert (paced.wait(), paced.steps) == (0.0, number + 2)


@pytest.mark.parametrize('wake', [Pacer.resume, Pacer.close, Pacer.wake, lambda paced: paced.request(1)])
def test_a_pause_ends_at_once(wake):
    paced = Pacer(STEP, paused=True)
    waiting = threading.Thread(target=paced.wait, args=(60.0,), daemon=True)
    waiting.start()
    waiting.join(0.02)
    assert waiting.is_alive()
    wake(paced)
    waiting.join(10.0)
    assert not waiting.is_alive()


def test_a_slow_rate_lets_the_caller_look_around(wall):
    paced = pacer(wall, 0.01)  # a step takes 1.6 s
    answers = [paced.wait() for _ in range(17)]
    assert answers.count(None) >= 15
    assert max(wall.slept) <= pacing.MAX_SLEEP
