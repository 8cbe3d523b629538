"""kinematic_core.worlds.planar: poses in frames, and exact arcs."""
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.planar import ORIGIN, STILL, Pose2D, Twist2D, advance, compose, mean_twist, relative

LENGTH_TOLERANCE = 1e-9  # [m, rad]
speeds = st.floats(-3.0, 3.0)
headings = st.floats(-3.1, 3.1)


def close(pose, expected, tolerance=LENGTH_TOLERANCE):
    return (abs(pose.x - expected.x) < tolerance and abs(pose.y - expected.y) < tolerance
            and abs(math.remainder(pose.yaw - expected.yaw, 2.0 * math.pi)) < tolerance)


def test_a_pose_in_a_turned_frame():
    """1 m ahead in a frame at (2, 3) that looks to the left is at (2, 4)."""
    assert close(compose(Pose2D(2.0, 3.0, math.pi / 2.0), Pose2D(1.0, 0.0, 0.5)), Pose2D(2.0, 4.0, math.pi / 2.0 + 0.5))


@pytest.mark.parametrize('frame', [ORIGIN, Pose2D(1.0, -2.0, 0.7), Pose2D(-3.0, 0.5, -3.0)])
def test_relative_is_the_inverse_of_compose(frame):
    assert close(relative(compose(frame, Pose2D(0.3, 4.0, 3.0)), frame), Pose2D(0.3, 4.0, 3.0))
    assert close(compose(frame, relative(ORIGIN, frame)), ORIGIN)


@pytest.mark.parametrize('pose, twist, dt, expected', [
    (Pose2D(), STILL, 1.0, Pose2D()),
    (Pose2D(1.0, 2.0, 0.5), STILL, 1.0, Pose2D(1.0, 2.0, 0.5)),
    (Pose2D(), Twist2D(2.0, 0.0, 0.0), 0.5, Pose2D(1.0, 0.0, 0.0)),
    (Pose2D(), Twist2D(0.0, 2.0, 0.0), 0.5, Pose2D(0.0, 1.0, 0.0)),
    (Pose2D(yaw=math.pi / 2.0), Twist2D(2.0, 0.0, 0.0), 0.5, Pose2D(0.0, 1.0, math.pi / 2.0)),
    (Pose2D(yaw=math.pi / 2.0), Twist2D(0.0, 2.0, 0.0), 0.5, Pose2D(-1.0, 0.0, math.pi / 2.0)),
    (Pose2D(3.0, 4.0), Twist2D(0.0, 0.0, 1.0), 4.0, Pose2D(3.0, 4.0, 4.0 - 2.0 * math.pi)),
    # a quarter of a circle of radius v / w = 1 m to the left ends at (1, 1), half of it at (0, 2), all where it began
    (Pose2D(), Twist2D(math.pi / 2.0, 0.0, math.pi / 2.0), 1.0, Pose2D(1.0, 1.0, math.pi / 2.0)),
    (Pose2D(), Twist2D(math.pi / 2.0, 0.0, math.pi / 2.0), 2.0, Pose2D(0.0, 2.0, math.pi)),
    (Pose2D(), Twist2D(math.pi / 2.0, 0.0, math.pi / 2.0), 4.0, Pose2D()),
    # to the right, and sideways: forward is -y's circle
    (Pose2D(), Twist2D(math.pi / 2.0, 0.0, -math.pi / 2.0), 1.0, Pose2D(1.0, -1.0, -math.pi / 2.0)),
    (Pose2D(), Twist2D(0.0, math.pi / 2.0, math.pi / 2.0), 1.0, Pose2D(-1.0, 1.0, math.pi / 2.0)),
])
def test_arc_by_hand(pose, twist, dt, expected):
    assert close(advance(pose, twist, dt), expected)


@given(x=speeds, y=speeds, turn=st.floats(-20.0, 20.0), yaw=headings, pieces=st.integers(2, 50))
def test_one_step_is_as_good_as_many(x, y, turn, yaw, pieces):
    twist, pose = Twist2D(x, y, turn), Pose2D(0.3, -0.2, yaw)
    for _ in range(pieces):
        pose = advance(pose, twist, 0.5 / pieces)
    assert close(advance(Pose2D(0.3, -0.2, yaw), twist, 0.5), pose)


@given(x=speeds, y=speeds, turn=st.floats(-1e-6, 1e-6))
def test_tiny_turns_are_as_exact_as_none(x, y, turn):
    # over 1 s the heading is off by turn at most, so the place by speed * turn
    assert close(advance(Pose2D(), Twist2D(x, y, turn), 1.0), Pose2D(x, y, turn), tolerance=1e-5)


@given(x=speeds, y=speeds, turn=st.floats(-20.0, 20.0), yaw=headings)
def test_mean_twist_is_the_inverse(x, y, turn, yaw):
    pose = Pose2D(1.0, -2.0, yaw)
    twist = mean_twist(pose, advance(pose, Twist2D(x, y, turn), 0.1), turn, 0.1)
    assert (twist.linear_x, twist.linear_y, twist.angular_z) == pytest.approx((x, y, turn), abs=1e-9)
