"""turtle_robotont.driving.shapes: corners, circles, and what fits into the arena."""
import math

import pytest

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from turtle_robotont.driving import shapes
from turtle_robotont.driving.control import Goal
from turtle_robotont.driving.shapes import InvalidInput, Point

ROUNDING = 1e-9
UP, LEFT = math.pi / 2.0, math.pi
ROOT3 = math.sqrt(3.0)


def near(points):
    return [pytest.approx(point, abs=ROUNDING) for point in points]


@pytest.mark.parametrize('sides, size, start, corners', [
    (4, 2.0, Goal(5.0, 5.0, 0.0), [(7.0, 5.0), (7.0, 7.0), (5.0, 7.0), (5.0, 5.0)]),
    (4, 1.0, Goal(5.0, 5.0, UP), [(5.0, 6.0), (4.0, 6.0), (4.0, 5.0), (5.0, 5.0)]),
    (3, 2.0, Goal(1.0, 1.0, 0.0), [(3.0, 1.0), (2.0, 1.0 + ROOT3), (1.0, 1.0)]),  # height of the triangle: sqrt(3)
    (3, 2.0, Goal(5.0, 5.0, LEFT), [(3.0, 5.0), (4.0, 5.0 - ROOT3), (5.0, 5.0)]),
])
def test_polygon_lies_to_the_left_and_ends_where_it_began(sides, size, start, corners):
    assert shapes.polygon(sides, size, start) == near(corners)


@pytest.mark.parametrize('start, centre', [
    (Goal(5.0, 5.0, 0.0), (5.0, 6.0)), (Goal(5.0, 5.0, UP), (4.0, 5.0)), (Goal(5.0, 5.0, LEFT), (5.0, 4.0)),
])
def test_circle_lies_to_the_left(start, centre):
    assert near([centre]) == [shapes.circle_centre(2.0, start)]


def test_outline_of_a_circle_is_its_four_ends():
    assert shapes.outline('circle', 2.0, Goal(5.0, 5.0, 0.0)) == near([(6.0, 6.0), (5.0, 7.0), (4.0, 6.0), (5.0, 5.0)])


@pytest.mark.parametrize('shape, start, largest', [
    ('square', Goal(5.0, 5.0, 0.0), ARENA_SIZE - 5.0),
    ('square', Goal(5.0, 2.0, -UP), 2.0),  # down 2 m to the lower wall
    ('triangle', Goal(1.0, 9.0, 0.0), (ARENA_SIZE - 9.0) / (ROOT3 / 2.0)),  # its top touches first
    ('circle', Goal(5.0, 5.0, 0.0), ARENA_SIZE - 5.0),  # up
    ('circle', Goal(5.0, 5.0, LEFT), 5.0),  # down
    ('circle', Goal(2.0, 5.0, 0.0), 4.0),  # the left wall is 2 m = one radius away
    ('square', Goal(ARENA_SIZE, 5.0, 0.0), 0.0),
])
def test_largest_size_touches_the_nearest_wall(shape, start, largest):
    assert shapes.largest_size(shape, start) == pytest.approx(largest)
    if largest:
        shapes.require_shape_fits(shape, largest, start)
    with pytest.raises(InvalidInput):
        shapes.require_shape_fits(shape, largest + 0.11, start)


@pytest.mark.parametrize('shape, size, start, texts', [
    ('square', 9.0, Goal(5.0, 5.0, 0.0),
     ['square of size 9 m from (5.00, 5.00)', 'corner 1 (14.00, 5.00)', 'corner 2 (14.00, 14.00)',
      'corner 3 (5.00, 14.00)', 'must be 0 to 11.09 m', 'largest possible size is 6.08 m']),
    ('circle', 7.0, Goal(5.0, 5.0, 0.0), ['upper end (5.00, 12.00)', 'largest possible size is 6.08 m']),
    ('circle', 5.0, Goal(2.0, 5.0, 0.0), ['left end (-0.50, 7.50)', 'largest possible size is 4.00 m']),
    ('triangle', 1.0, Goal(11.08, 5.0, 0.0), ['corner 1 (12.08, 5.00)', 'first drive the turtle away']),
    ('square', math.nan, Goal(5.0, 5.0, 0.0), ['size is nan m', '0.1 to 11.09 m']),
    ('square', math.inf, Goal(5.0, 5.0, 0.0), ['size is inf m']),
    ('square', -1.0, Goal(5.0, 5.0, 0.0), ['size is -1 m']),
    ('square', 0.05, Goal(5.0, 5.0, 0.0), ['size is 0.05 m']),
])
def test_refusal_names_what_would_leave_the_arena_and_what_fits(shape, size, start, texts):
    with pytest.raises(InvalidInput) as refusal:
        shapes.require_shape_fits(shape, size, start)
    for text in texts:
        assert text in str(refusal.value)
    assert ('corner 4' in str(refusal.value)) is False  # it is the start


@pytest.mark.parametrize('point', [Point(0.0, 0.0), Point(ARENA_SIZE, ARENA_SIZE), Point(ARENA_SIZE + 1e-9, -1e-9)])
def test_points_up_to_the_walls_fit(point):
    shapes.require_fit([point])


@pytest.mark.parametrize('point', [Point(-0.01, 1.0), Point(1.0, 11.1), Point(math.nan, 1.0), Point(1.0, math.inf)])
def test_points_outside_are_named(point):
    with pytest.raises(InvalidInput, match=r'corner 2 \('):
        shapes.require_fit([Point(1.0, 1.0), point])


def test_pairs_become_points():
    assert shapes.points_from([[1, 2.5], (3.0, 4)]) == [Point(1.0, 2.5), Point(3.0, 4.0)]


@pytest.mark.parametrize('corners, text', [
    ([], '0 corners are given; at least 2'),
    ([[1.0, 1.0]], '1 corners are given'),
    ([[1.0, 1.0], 2.0], 'corner 2 is 2.0; it must be a pair'),
    ([[1.0, 1.0, 1.0], [2.0, 2.0]], 'corner 1 is [1.0, 1.0, 1.0]'),
])
def test_what_is_no_list_of_pairs_is_refused(corners, text):
    with pytest.raises(InvalidInput) as refusal:
        shapes.points_from(corners)
    assert text in str(refusal.value) and 'e.g. [[' in str(refusal.value)


def test_the_default_corners_fit():
    shapes.require_fit(shapes.points_from(shapes.DEFAULT_CORNERS))
