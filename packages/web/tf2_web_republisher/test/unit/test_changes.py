"""When a transform is sent again."""
import math

import pytest

from tf2_web_republisher.core.changes import MAX_FRAMES, InvalidRequest, Thresholds, Transform, angle, check, distance

UPRIGHT = 0.0, 0.0, 0.0, 1.0
THRESHOLDS = Thresholds(0.1, 0.2)


def turned(heading):
    """Return the quaternion of a heading [rad]."""
    return 0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2)


@pytest.mark.parametrize('first, second, expected', [
    (UPRIGHT, UPRIGHT, 0.0), (UPRIGHT, turned(0.5), 0.5), (turned(-0.5), turned(0.5), 1.0),
    (UPRIGHT, tuple(-part for part in UPRIGHT), 0.0), (UPRIGHT, turned(math.pi), math.pi), ((0, 0, 0, 0), UPRIGHT, 0.0),
])
def test_angle_between_rotations(first, second, expected):
    assert angle(first, second) == pytest.approx(expected, abs=1e-7)


def test_distance_of_points():
    assert distance((1, 2, 3), (1, 5, 7)) == 5.0


@pytest.mark.parametrize('moved, heading, sent', [
    (0.0, 0.0, False), (0.09, 0.19, False), (0.11, 0.0, True), (0.0, 0.21, True),
])
def test_transform_is_sent_once_it_has_changed_enough(moved, heading, sent):
    before, now = Transform((1.0, 2.0, 0.0), UPRIGHT), Transform((1.0, 2.0 + moved, 0.0), turned(heading))
    assert THRESHOLDS.passed(before, now) is sent
    assert THRESHOLDS.passed(None, now)
    assert Thresholds(0.0, 0.2).passed(before, before) and Thresholds(0.1, 0.0).passed(before, before)


@pytest.mark.parametrize('frames, target, thresholds, rate, error', [
    (['a'], '/', THRESHOLDS, 10.0, 'target_frame is empty'), (['a', ''], 'w', THRESHOLDS, 10.0, 'an empty name'),
    (['a'] * (MAX_FRAMES + 1), 'w', THRESHOLDS, 10.0, '1001 names'), (['a'], 'w', THRESHOLDS, 0.0, 'rate is 0 Hz'),
    (['a'], 'w', THRESHOLDS, math.nan, 'rate is nan'), (['a'], 'w', Thresholds(-1.0, 0.0), 1.0, 'trans_thres is -1'),
    (['a'], 'w', Thresholds(0.0, math.nan), 1.0, 'angular_thres nan'),
])
def test_request_that_cannot_be_served_is_refused(frames, target, thresholds, rate, error):
    with pytest.raises(InvalidRequest, match=error):
        check(frames, target, thresholds, rate)


@pytest.mark.parametrize('frames', [[], ['a']])
def test_other_requests_are_served(frames):
    check(frames, 'world', THRESHOLDS, 10.0)
