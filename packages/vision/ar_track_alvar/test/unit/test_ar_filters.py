"""ar_track_alvar.core.filters: the rate of pictures, and which markers fit well enough."""
from types import SimpleNamespace

import numpy as np
import pytest

from ar_track_alvar.core.filters import ErrorFilter, MedianPose, RateLimiter, fit_error

SIDE = 50.0  # px
CORNERS = np.array([[0, 0], [SIDE, 0], [SIDE, SIDE], [0, SIDE]])


def passed(rate, times):
    limiter = RateLimiter(rate)
    return [time for time in times if limiter.accept(time)]


@pytest.mark.parametrize('camera, limit, expected', [
    (30.0, 8.0, 8.0), (30.0, 30.0, 30.0), (15.0, 30.0, 15.0), (25.0, 10.0, 10.0), (8.0, 8.0, 8.0), (60.0, 1.0, 1.0)])
def test_the_mean_rate_is_the_limit_or_what_comes(camera, limit, expected):
    seconds = 20.0
    count = len(passed(limit, 100.0 + np.arange(0, seconds, 1 / camera)))
    assert count / seconds == pytest.approx(expected, abs=1.5 / seconds)


def test_jitter_loses_nothing_when_the_camera_has_the_limits_rate():
    times = 5.0 + np.arange(200) / 8.0 + np.random.default_rng(1).uniform(-0.02, 0.02, 200)
    assert len(passed(8.0, times)) >= 199


def test_after_a_pause_no_more_than_one_is_made_up_for():
    times = [0.0, 10.0, 10.01, 10.02, 10.03]
    assert passed(8.0, times) == [0.0, 10.0, 10.01]


def test_time_that_jumps_back_begins_anew():
    assert passed(1.0, [100.0, 100.1, 100.5, 101.2, 50.0, 50.5, 51.0]) == [100.0, 100.1, 101.2, 50.0, 51.0]


def test_a_new_rate_takes_effect():
    limiter = RateLimiter(1.0)
    assert [limiter.accept(t) for t in (0.0, 0.01, 0.02, 0.5)] == [True, True, False, False]
    limiter.rate = 30.0
    assert [limiter.accept(t) for t in (1.01, 1.05, 1.09)] == [True, True, True]


def marker(marker_id, error):
    """A Detection 50 px wide whose corners are off by ``error`` parts of the side."""
    return SimpleNamespace(id=marker_id, error=error * SIDE, corners=CORNERS)


def test_the_error_is_in_parts_of_the_side():
    assert fit_error(marker(1, 0.02)) == pytest.approx(0.02)


def test_new_markers_have_to_fit_better_than_those_that_were_there():
    filtered = ErrorFilter()
    assert filtered.accepted([marker(1, 0.03), marker(2, 0.01)], 0.02, 0.04)[0].id == 2
    both = filtered.accepted([marker(1, 0.03), marker(2, 0.03)], 0.02, 0.04)
    assert [m.id for m in both] == [2]
    assert filtered.accepted([marker(2, 0.05)], 0.02, 0.04) == []
    assert filtered.accepted([marker(2, 0.03)], 0.02, 0.04) == [], 'it was gone and is new'


def test_a_tracked_marker_never_has_to_fit_better_than_a_new_one():
    filtered = ErrorFilter()
    for _ in range(3):
        assert len(filtered.accepted([marker(1, 0.01)], 0.02, 0.0)) == 1


def test_the_most_central_of_the_last_poses_is_taken():
    median, turn = MedianPose(3), np.eye(3)
    # (last three), the one with the smallest sum of squares: 0; 0 or 1, the newest; 1 of 0 1 9; 1 of 1 9 2 is 2
    for place, expected in ((0.0, 0.0), (1.0, 1.0), (9.0, 1.0), (2.0, 2.0)):
        assert median.add(turn, np.array([place, 0.0, 0.0]))[1][0] == expected


def test_reset_makes_every_marker_new():
    filtered = ErrorFilter()
    filtered.accepted([marker(1, 0.01)], 0.02, 0.04)
    filtered.reset()
    assert filtered.accepted([marker(1, 0.03)], 0.02, 0.04) == []
