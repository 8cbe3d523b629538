"""turtle_robotont.driving.accuracy: corners and circles of tracks whose answers are known."""
import math

import pytest

from turtle_robotont.driving import accuracy
from turtle_robotont.driving.shapes import Point
from turtle_robotont.driving.vehicle import VehicleState

ROUNDING = 1e-9
STEP = 0.01  # [m] between two poses of a drawn line
SQUARE = [(2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 4.0), (2.0, 2.0)]
SQUARE_POINTS = [Point(*corner) for corner in SQUARE[1:]]


def pose(x, y):
    return VehicleState(x, y, 0.0, 0.0, 0.0)


def line(*corners):
    """Return a track along the corners, a pose every STEP."""
    track = [pose(*corners[0])]
    for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
        count = round(math.hypot(x1 - x0, y1 - y0) / STEP)
        track += [pose(x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count) for i in range(1, count + 1)]
    return track


def test_corners_passed_in_order_are_missed_by_nothing():
    assert accuracy.corner_misses(line(*SQUARE), SQUARE_POINTS) == pytest.approx([0.0] * 4, abs=ROUNDING)


def test_cut_corner_is_missed_by_its_distance_from_the_cut():
    track = line((2.0, 2.0), (3.9, 2.0), (4.0, 2.1), (4.0, 4.0), (2.0, 4.0), (2.0, 2.0))
    misses = accuracy.corner_misses(track, SQUARE_POINTS)
    assert misses[0] == pytest.approx(0.1 / math.sqrt(2.0), abs=STEP)
    assert misses[1:] == pytest.approx([0.0] * 3, abs=ROUNDING)


def test_order_of_the_corners_counts():
    assert max(accuracy.corner_misses(line(*SQUARE), SQUARE_POINTS[::-1])) > 1.0


def test_corner_left_out_is_missed():
    assert max(accuracy.corner_misses(line((2.0, 2.0), (4.0, 2.0), (4.0, 4.0), (2.0, 2.0)), SQUARE_POINTS)) > 0.9


def test_without_a_track_everything_is_missed():
    assert accuracy.corner_misses([], SQUARE_POINTS) == [math.inf] * 4


def test_radius_deviation_is_the_largest_distance_from_the_circle():
    track = [pose(math.cos(a / 10.0) * r, math.sin(a / 10.0) * r) for a, r in enumerate((1.0, 1.02, 0.97, 1.0))]
    assert accuracy.radius_deviation(track, Point(0.0, 0.0), 1.0) == pytest.approx(0.03)
