"""plain_support.rotations: matrices, quaternions and angles of one rotation."""
import math

import numpy as np
import pytest

from plain_support import rotations

HALF = math.sqrt(0.5)  # sin and cos of half of 90 degrees
ROUNDING = 1e-12


@pytest.mark.parametrize('rpy, quaternion, forward', [  # forward: where the x axis points
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
    ((0.0, 0.0, math.pi / 2.0), (0.0, 0.0, HALF, HALF), (0.0, 1.0, 0.0)),
    ((0.0, math.pi / 2.0, 0.0), (0.0, HALF, 0.0, HALF), (0.0, 0.0, -1.0)),
    ((math.pi / 2.0, 0.0, 0.0), (HALF, 0.0, 0.0, HALF), (1.0, 0.0, 0.0)),
    ((-math.pi / 2.0, 0.0, -math.pi / 2.0), (-0.5, 0.5, -0.5, 0.5), (0.0, -1.0, 0.0)),  # of an optical frame
])
def test_matrix_and_quaternion_by_hand(rpy, quaternion, forward):
    matrix = rotations.matrix_from_rpy(*rpy)
    assert matrix[:, 0] == pytest.approx(forward, abs=ROUNDING)
    assert rotations.quaternion_from_matrix(matrix) == pytest.approx(quaternion, abs=ROUNDING)
    assert rotations.matrix_from_quaternion(3.0 * np.array(quaternion)) == pytest.approx(matrix, abs=ROUNDING)


@pytest.mark.parametrize('rpy', [(0.3, -0.4, 2.5), (-3.0, 1.5, -3.1), (1.0, 0.0, 0.0)])
def test_angles_there_and_back(rpy):
    matrix = rotations.matrix_from_rpy(*rpy)
    assert rotations.rpy_from_matrix(matrix) == pytest.approx(rpy, abs=ROUNDING)
    assert np.linalg.det(matrix) == pytest.approx(1.0)


def test_angle_between_two_rotations():
    turn = rotations.matrix_from_rpy(0.2, -0.1, 0.5)
    assert rotations.angle_between(turn, turn @ rotations.matrix_from_rpy(0.0, 0.7, 0.0)) == pytest.approx(0.7)
    assert rotations.angle_between(turn, turn) == pytest.approx(0.0, abs=1e-7)
