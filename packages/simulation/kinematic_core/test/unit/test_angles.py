"""kinematic_core.worlds.angles: wrapping into [-pi, pi)."""
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.turtle_world import TURTLESIM_PI

ROUNDING = 2.3e-16  # relative: half a unit in the last place of a double


@pytest.mark.parametrize('pi', [math.pi, TURTLESIM_PI])
@pytest.mark.parametrize('sign', [1.0, -1.0])
def test_half_a_turn_is_minus_pi_never_pi(pi, sign):
    assert wrap_angle(sign * pi, pi) == -pi


@pytest.mark.parametrize('pi', [math.pi, TURTLESIM_PI])
@given(theta=st.floats(-1e6, 1e6), turns=st.integers(-1000, 1000))
def test_result_lies_in_range_and_turns_do_not_count(pi, theta, turns):
    rounding = 4.0 * ROUNDING * (abs(theta) + abs(turns) * 2.0 * pi + pi)
    wrapped = wrap_angle(theta, pi)
    assert -pi - rounding <= wrapped < pi + rounding
    apart = wrap_angle(theta + turns * 2.0 * pi, pi) - wrapped
    assert min(abs(apart), abs(abs(apart) - 2.0 * pi)) <= rounding


@pytest.mark.parametrize('pi', [math.pi, TURTLESIM_PI])
@given(theta=st.floats(-3.1415926, 3.1415926))
def test_angle_in_range_stays_as_it_is_to_the_last_bit(pi, theta):
    assert wrap_angle(theta, pi) == theta


def test_turtlesims_short_pi_is_used_for_the_range_and_for_the_turn():
    # 3.141592652 lies between TURTLESIM_PI and math.pi: with the literal it is wrapped, with math.pi it is not
    between = 3.141592652
    assert wrap_angle(between) == between
    assert wrap_angle(between, TURTLESIM_PI) == between - 2.0 * TURTLESIM_PI
    assert TURTLESIM_PI == 3.14159265


def test_order_of_operations_is_turtlesims():
    # theta - 2 pi floor((theta + pi) / (2 pi)) by hand for 9.42 (golden/teleports.csv, tick 102):
    # (9.42 + 3.14159265) / 6.2831853 = 1.9992.. -> 1 turn off
    assert wrap_angle(9.42, TURTLESIM_PI) == 9.42 - 6.2831853
