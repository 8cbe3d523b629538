"""fake_localization.core.frames: poses in frames, and back."""
import math

import pytest

from fake_localization.core.frames import compose, inverse
from kinematic_core.worlds.planar import ORIGIN, Pose2D

pytestmark = pytest.mark.slow

EPSILON = 1e-12


def test_a_pose_in_a_turned_frame():
    """1 m ahead in a frame at (2, 3) that looks to the left is at (2, 4)."""
    assert compose(Pose2D(2.0, 3.0, math.pi / 2.0), Pose2D(1.0, 0.0, 0.5)) == pytest.approx(
        (2.0, 4.0, math.pi / 2.0 + 0.5), abs=EPSILON)


@pytest.mark.parametrize('pose', [ORIGIN, Pose2D(1.0, -2.0, 0.7), Pose2D(-3.0, 0.5, -3.0)])
def test_a_pose_and_its_inverse_are_nothing(pose):
    assert compose(pose, inverse(pose)) == pytest.approx(ORIGIN, abs=EPSILON)
    assert compose(inverse(pose), pose) == pytest.approx(ORIGIN, abs=EPSILON)
