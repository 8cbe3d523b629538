"""The map from above: everything is where its coordinates say, at the scale it states, and bad input is named."""
import math

import numpy as np
import pytest

from kinematic_core.worlds import overhead
from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel
from kinematic_core.worlds.overhead import LARGEST, MARGIN, PAPER, PATH_COLOUR, ROBOT_COLOUR, FloorPlanMap, Path
from kinematic_core.worlds.robot_world import ROBOT_RADIUS

RED, GREEN = (200, 20, 20), (20, 160, 20)
PLAN = FloorPlan((Box('wall', 0.0, 1.0, math.pi / 6, 2.0, 0.2, 0.5, 0.0, RED),
                  Box('sill', 0.0, -1.0, 0.0, 2.0, 0.2, 0.05, 0.0, RED)),
                 (Cylinder('post', -1.5, 0.0, 0.3, 1.0, 0.0, GREEN),), (Panel('panel', 3, 2.0, 0.0, 0.0),))


def at(drawn, picture, x, y):
    column, row = drawn.pixel(x, y)
    return tuple(int(part) for part in picture[round(row), round(column)])


def near(colour, expected, tolerance=3):
    return all(abs(a - b) <= tolerance for a, b in zip(colour, expected))


def has(picture, colour):
    return (np.abs(picture.astype(int) - colour).max(-1) <= 3).any()


def test_shapes_are_where_their_coordinates_say():
    drawn = FloorPlanMap(PLAN)
    picture = drawn.draw()
    assert picture.shape == (drawn.height, drawn.width, 3) and picture.dtype == np.uint8
    along = (math.cos(math.pi / 6), math.sin(math.pi / 6))
    for way in (-0.95, 0.0, 0.95):
        assert near(at(drawn, picture, way * along[0], 1.0 + way * along[1]), RED)
    assert at(drawn, picture, 0.95 * along[0], 1.0 - 0.95 * along[1]) != RED  # y is up
    assert near(at(drawn, picture, -1.5, 0.25), GREEN) and not near(at(drawn, picture, -1.5, 0.4), GREEN)
    assert near(at(drawn, picture, 2.0, 0.15), overhead.MARKER_INK)
    assert near(at(drawn, picture, 1.93, 0.0), overhead.MARKER_INK)  # the panel's face looks towards -x
    assert not near(at(drawn, picture, 2.07, 0.0), overhead.MARKER_INK)


def test_low_things_are_pale():
    drawn = FloorPlanMap(PLAN)
    colour = at(drawn, drawn.draw(), 0.5, -1.0)
    assert near(colour, [part + (255 - part) * 0.6 for part in RED])


def test_scale_bar_is_as_long_as_it_says():
    drawn = FloorPlanMap(PLAN, pixels_per_metre=100.0)
    bar = (drawn.draw()[drawn.height - 14] == overhead.INK).all(-1)
    assert abs(bar.sum() - 100) <= 4


@pytest.mark.parametrize('scale', [20.0, 77.7])
def test_distances_follow_the_scale(scale):
    drawn = FloorPlanMap(PLAN, pixels_per_metre=scale)
    (left, low), (right, high) = drawn.pixel(-1.0, -2.0), drawn.pixel(2.0, 3.0)
    assert right - left == pytest.approx(3.0 * scale) and low - high == pytest.approx(5.0 * scale)


def test_large_world_is_drawn_smaller():
    drawn = FloorPlanMap(FloorPlan((Box('long', 0, 0, 0, 400.0, 1.0, 1.0),)))
    assert max(drawn.width, drawn.height) <= LARGEST + 1 and drawn.draw().shape[1] == drawn.width


def test_title_and_label_are_written():
    path = Path([(0, 0), (1, 0)], 'driven')
    plain, named = overhead.draw_map(PLAN, [path._replace(label='')]), overhead.draw_map(PLAN, [path], title='maze')
    assert (plain[-MARGIN:] != named[-MARGIN:]).any() and (plain[:MARGIN] != named[:MARGIN]).any()


def test_path_and_robot_are_drawn_over_the_plan():
    drawn = FloorPlanMap(PLAN)
    picture = drawn.draw([Path([(-0.5, 0.0), (1.0, 0.0), (1.0, -0.5)])], [(1.0, -0.5, 0.0)])
    assert near(at(drawn, picture, 0.3, 0.0), PATH_COLOUR) and near(at(drawn, picture, 1.0, -0.2), PATH_COLOUR)
    assert near(at(drawn, picture, 1.0, -0.5 + 0.8 * ROBOT_RADIUS), ROBOT_COLOUR)
    assert near(at(drawn, picture, 1.0 + 0.6 * ROBOT_RADIUS, -0.5), (255, 255, 255))  # the arrow points ahead
    assert near(at(drawn, picture, 1.0 - 0.6 * ROBOT_RADIUS, -0.5), ROBOT_COLOUR)
    assert np.array_equal(drawn.draw(), FloorPlanMap(PLAN).draw())  # the next one begins anew


def test_everything_has_room():
    picture = overhead.draw_map(FloorPlan(), [Path([(0, 0), (5, 0)])], [(0.0, 3.0, 1.0)], pixels_per_metre=100)
    assert picture.shape == (300 + 2 * MARGIN, 500 + 2 * MARGIN, 3)
    assert has(picture, PATH_COLOUR) and has(picture, ROBOT_COLOUR)


def test_part_of_a_plan_fills_the_picture():
    drawn = FloorPlanMap(PLAN, between=[(-2.0, -0.5), (-1.0, 0.5)], pixels_per_metre=300)
    assert drawn.pixel(-2.0, 0.5) == pytest.approx((MARGIN + (drawn.width - 412) / 2 - 0.5, MARGIN - 0.5))
    picture = drawn.draw()
    assert picture.shape[0] == 300 + 2 * MARGIN and near(at(drawn, picture, -1.5, 0.25), GREEN)


def test_empty_plan_is_paper_with_a_grid():
    picture = FloorPlanMap(FloorPlan()).draw()
    assert (picture == PAPER).all(-1).mean() > 0.9
