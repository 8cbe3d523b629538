"""rospy_support.rotations: angles as quaternions and back."""
import math

import pytest
from geometry_msgs.msg import Quaternion

from rospy_support import rotations

HALF = math.sqrt(0.5)
ROUNDING = 1e-12


def parts(quaternion):
    return quaternion.x, quaternion.y, quaternion.z, quaternion.w


@pytest.mark.parametrize('angles, axes, expected', [
    ((0.0, 0.0, 0.0), 'sxyz', (0.0, 0.0, 0.0, 1.0)),
    ((0.0, 0.0, math.pi / 2), 'sxyz', (0.0, 0.0, HALF, HALF)),
    ((math.pi / 2, 0.0, 0.0), 'sxyz', (HALF, 0.0, 0.0, HALF)),
    ((0.0, math.pi / 2, 0.0), 'rzxz', (HALF, 0.0, 0.0, HALF)),
    ((math.pi / 2, math.pi / 2, 0.0), 'rzxz', (0.5, 0.5, 0.5, 0.5)),  # z by 90 degrees, then the new x by 90 degrees
])
def test_quaternion_of_angles(angles, axes, expected):
    assert parts(rotations.to_quaternion(*angles, axes=axes)) == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize('yaw', [0.0, 0.7, -3.1, 3.1])
@pytest.mark.parametrize('length', [1.0, 0.5])
def test_yaw_comes_back(yaw, length):
    quaternion = Quaternion(*(length * part for part in parts(rotations.to_quaternion(0.3, -0.4, yaw))))
    assert rotations.yaw_of(quaternion) == pytest.approx(yaw, abs=ROUNDING)
