"""kinematic_core.worlds.omni: wheels, limits, odometry."""
import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.omni import Limits, Odometry, body_twist, wheel_speeds
from kinematic_core.worlds.planar import STILL, Pose2D, Twist2D, advance

SPEED_TOLERANCE = 1e-9  # [m/s, rad/s]
HALF_ROOT_3 = math.sqrt(3.0) / 2.0
speeds = st.floats(-5.0, 5.0)
twists = st.builds(Twist2D, speeds, speeds, speeds)


@pytest.mark.parametrize('twist, rims', [  # rims: speed of each wheel's rim [m/s], in the order back, right, left
    (STILL, (0.0, 0.0, 0.0)),
    # turning: all rims go round at 0.146 m from the middle
    (Twist2D(0.0, 0.0, 1.0), (0.146, 0.146, 0.146)),
    # forward: the back wheel rolls on its rollers; the front ones stand at 60 degrees, so take sin 60 of it: the right
    # one drives counter-clockwise round the robot, the left one clockwise
    (Twist2D(1.0, 0.0, 0.0), (0.0, HALF_ROOT_3, -HALF_ROOT_3)),
    # to the left: clockwise for the back wheel, the front ones with cos 60
    (Twist2D(0.0, 1.0, 0.0), (-1.0, 0.5, 0.5)),
    (Twist2D(0.5, -0.2, 2.0), (0.2 + 0.292, 0.5 * HALF_ROOT_3 - 0.1 + 0.292, -0.5 * HALF_ROOT_3 - 0.1 + 0.292)),
])
def test_wheels_by_hand(twist, rims):
    assert wheel_speeds(twist) == pytest.approx([rim / 0.035 for rim in rims], abs=SPEED_TOLERANCE)


@given(twist=twists)
def test_wheels_and_body_are_inverse(twist):
    assert body_twist(wheel_speeds(twist)) == pytest.approx(twist, abs=SPEED_TOLERANCE)


@given(twist=twists, limits=st.builds(Limits, st.floats(0.1, 3.0), st.floats(0.1, 3.0), st.floats(1.0, 50.0)))
def test_limits_keep_the_direction_and_are_used_up(twist, limits):
    slower = limits.limited(twist)
    shares = [math.hypot(slower.linear_x, slower.linear_y) / limits.speed, abs(slower.angular_z) / limits.turn_speed,
              max(map(abs, wheel_speeds(slower))) / limits.wheel_speed]
    assert max(shares) <= 1.0 + SPEED_TOLERANCE
    if slower != twist:
        assert max(shares) == pytest.approx(1.0)
    for a, b in ((0, 1), (1, 2), (0, 2)):  # parallel
        assert slower[a] * twist[b] == pytest.approx(slower[b] * twist[a], abs=1e-6)


@pytest.mark.parametrize('limits, twist, target, reached', [
    (Limits(), STILL, Twist2D(5.0, 0.0, 9.0), Twist2D(5.0, 0.0, 9.0)),
    # 0.1 s at 1 m/s^2
    (Limits(acceleration=1.0), STILL, Twist2D(5.0, 0.0, 0.0), Twist2D(0.1, 0.0, 0.0)),
    (Limits(acceleration=1.0), Twist2D(0.5, 0.0, 0.0), STILL, Twist2D(0.4, 0.0, 0.0)),
    (Limits(acceleration=1.0), Twist2D(0.05, 0.0, 0.0), STILL, STILL),
    # forward to sideways: the change is (-3, 4), 5 m/s long, of which 0.1 m/s
    (Limits(acceleration=1.0), Twist2D(3.0, 0.0, 0.0), Twist2D(0.0, 4.0, 0.0), Twist2D(2.94, 0.08, 0.0)),
    (Limits(turn_acceleration=2.0), STILL, Twist2D(1.0, 0.0, 1.0), Twist2D(0.2, 0.0, 0.2)),
    (Limits(wheel_acceleration=10.0), STILL, Twist2D(0.0, 0.0, 1.0), Twist2D(0.0, 0.0, 0.035 / 0.146)),
])
def test_acceleration_by_hand(limits, twist, target, reached):
    assert limits.approached(twist, target, 0.1) == pytest.approx(reached, abs=SPEED_TOLERANCE)


@given(twist=twists, target=twists)
def test_every_target_is_reached_in_the_time_that_the_limit_allows(twist, target):
    limits, dt = Limits(acceleration=2.0, turn_acceleration=3.0), 0.01
    longest = max(math.hypot(target.linear_x - twist.linear_x, target.linear_y - twist.linear_y) / 2.0,
                  abs(target.angular_z - twist.angular_z) / 3.0)
    for _ in range(math.ceil(longest / dt) + 1):
        twist = limits.approached(twist, target, dt)
    assert twist == pytest.approx(target, abs=1e-9)


def rolled(odometry, twist, seconds, dt=0.01):
    for _ in range(round(seconds / dt)):
        odometry.roll(twist, dt)
    return odometry


@given(twist=twists)
def test_odometry_without_errors_is_the_true_way(twist):
    odometry = rolled(Odometry(Pose2D(1.0, 2.0, 3.0)), twist, 0.2)
    true = advance(Pose2D(1.0, 2.0, 3.0), twist, 0.2)
    assert odometry.pose[:2] == pytest.approx(true[:2], abs=1e-9)
    assert math.remainder(odometry.pose.yaw - true.yaw, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert odometry.distance == pytest.approx(0.2 * math.hypot(twist.linear_x, twist.linear_y))


def test_slip_makes_it_believe_to_be_farther():
    # 1 m really; 20 % of the wheels' turning is lost, so they have turned for 1 / 0.8 = 1.25 m
    odometry = rolled(Odometry(slip=0.2), Twist2D(1.0, 0.0, 0.0), 1.0)
    assert odometry.pose.x == pytest.approx(1.25)
    assert odometry.twist.linear_x == pytest.approx(1.25)
    assert odometry.distance == pytest.approx(1.25)


def test_noise_has_the_deviation_asked_for_whatever_the_step():
    # forward at 1 m/s for 1 s: the rims of right and left make sin 60 = 0.866 m each, so each is off by
    # 0.05 * sqrt(0.866) m (one sigma); x is the third of sqrt(3) times their difference, so off by
    # 0.05 * sqrt(0.866) * sqrt(2) / sqrt(3) = 0.0380 m
    for dt in (0.1, 0.01):
        ends = [rolled(Odometry(noise=0.05, random=random.Random(seed)), Twist2D(1.0, 0.0, 0.0), 1.0, dt).pose.x
                for seed in range(300)]
        mean = sum(ends) / len(ends)
        deviation = math.sqrt(sum((end - mean) ** 2 for end in ends) / len(ends))
        assert mean == pytest.approx(1.0, abs=0.02)
        assert deviation == pytest.approx(0.0380, rel=0.2)  # 300 samples: 4 % one sigma


def test_standing_wheels_make_no_noise():
    assert rolled(Odometry(noise=0.05, random=random.Random(7)), STILL, 1.0).pose == Pose2D()
