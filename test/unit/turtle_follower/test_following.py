"""The velocity of a turtle that follows, and the notice of a frame that is no longer sent."""
import math

import pytest

from turtle_follower.core.following import Freshness, moving_carrot, velocity_towards


@pytest.mark.parametrize('x, y, speed, turn', [
    (2.0, 0.0, 1.0, 0.0),  # 0.5 m/s a metre
    (0.0, 2.0, 1.0, 2.0 * math.pi),  # 4 rad/s a radian; a quarter turn is pi / 2
    (0.0, -2.0, 1.0, -2.0 * math.pi),
    (3.0, -4.0, 2.5, 4.0 * math.atan2(-4.0, 3.0)),
    (0.0, 0.0, 0.0, 0.0),
])
def test_velocity_leads_to_the_point(x, y, speed, turn):
    assert velocity_towards(x, y) == pytest.approx((speed, 0.0, turn))


@pytest.mark.parametrize('time, place', [(0.0, (0.0, 10.0)), (0.5, (10.0, 0.0)), (1.0, (0.0, -10.0)),
                                         (1795370000.0, (0.0, 10.0))])
def test_carrot_goes_round_once_in_two_seconds(time, place):
    assert moving_carrot(time) == pytest.approx(place, abs=1e-5)


@pytest.mark.parametrize('seen, fresh', [
    ([(1, 0.0), (2, 5.0)], True),  # a new stamp, however late
    ([(1, 0.0), (1, 0.9)], True),
    ([(1, 0.0), (1, 1.1)], False),
    ([(1, 0.0), (1, 1.1), (2, 1.2)], True),  # it comes again
    ([(1, 9.0), (1, 0.5), (1, 1.4)], True),  # time has jumped back
    ([(0, 0.0), (0, 99.0)], True),  # a static transform
])
def test_a_transform_that_is_no_longer_sent_is_noticed(seen, fresh):
    freshness = Freshness()
    assert [freshness.is_fresh(*one) for one in seen][-1] is fresh
