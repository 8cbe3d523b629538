"""kinematic_core.worlds.collision: a disc stops, slides and never gets through."""
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from kinematic_core.worlds.collision import ROUNDING, Obstacles
from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel, corners

pytestmark = pytest.mark.slow

RADIUS = 0.18  # [m]
HEIGHT = 0.25  # [m]
LENGTH_TOLERANCE = 1e-6  # [m]
WALL = Box('wall', 1.0, 0.0, 0.0, 0.1, 4.0, 0.5)  # x 0.95..1.05
POST = Cylinder('post', 2.0, 0.0, 0.5, 1.0)

places = st.floats(-3.0, 3.0)
sizes = st.floats(0.02, 2.0)
yaws = st.floats(-math.pi, math.pi)
boxes = st.builds(lambda x, y, yaw, length, width: Box('box', x, y, yaw, length, width, 0.5),
                  places, places, yaws, sizes, sizes)
posts = st.builds(lambda x, y, radius: Cylinder('post', x, y, radius, 0.5), places, places, sizes)
plans = st.builds(lambda some, others: FloorPlan(boxes=tuple(some), cylinders=tuple(others)),
                  st.lists(boxes, max_size=4), st.lists(posts, max_size=3))


def obstacles(*shapes):
    return Obstacles(FloorPlan(boxes=tuple(shape for shape in shapes if isinstance(shape, Box)),
                               cylinders=tuple(shape for shape in shapes if isinstance(shape, Cylinder))),
                     RADIUS, HEIGHT)


def distance_to_segment(point, a, b):
    (px, py), (ax, ay), (bx, by) = point, a, b
    length = (bx - ax) ** 2 + (by - ay) ** 2
    t = min(1.0, max(0.0, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length))
    return math.hypot(px - ax - t * (bx - ax), py - ay - t * (by - ay))


def gap(plan, x, y):
    """Return the distance of a point from the nearest surface [m], 0 inside, without the code under test."""
    gaps = [math.inf]
    for box in plan.boxes:
        ring = corners(box)
        sides = list(zip(ring, ring[1:] + ring[:1]))
        inside = all((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= 0.0 for a, b in sides)
        gaps.append(0.0 if inside else min(distance_to_segment((x, y), a, b) for a, b in sides))
    gaps += [max(0.0, math.hypot(x - post.x, y - post.y) - post.radius) for post in plan.cylinders]
    return min(gaps)


@pytest.mark.parametrize('shape, start, way, end, touched', [
    # free, up to the wall, against it
    (WALL, (0.0, 0.0), (0.5, 0.0), (0.5, 0.0), False),
    (WALL, (0.0, 0.0), (0.77, 0.0), (0.77, 0.0), False),  # 0.95 - 0.18
    (WALL, (0.0, 0.0), (0.9, 0.0), (0.77, 0.0), True),
    (WALL, (0.0, 0.0), (500.0, 0.0), (0.77, 0.0), True),
    (WALL, (0.77, 0.0), (1e-3, 0.0), (0.77, 0.0), True),
    (WALL, (0.77, 0.0), (-0.3, 0.2), (0.47, 0.2), False),
    # along the wall: what leads into it is lost
    (WALL, (0.0, 0.0), (1.2, 0.3), (0.77, 0.3), True),
    (WALL, (0.77, -1.0), (0.3, 1.5), (0.77, 0.5), True),
    # from behind
    (WALL, (2.0, 0.0), (-500.0, 0.0), (1.23, 0.0), True),
    # a post straight ahead stops it, half a metre and its radius before the axis
    (POST, (0.0, 0.0), (3.0, 0.0), (1.32, 0.0), True),
])
def test_way_by_hand(shape, start, way, end, touched):
    x, y, touch = obstacles(shape).move(*start, *way)
    assert (x, y) == pytest.approx(end, abs=LENGTH_TOLERANCE)
    assert touch is touched


def test_it_slides_round_a_post():
    # beside the axis it is pushed off and passes
    x, y, touched = obstacles(POST).move(0.0, 0.3, 4.0, 0.0)
    assert touched and x > 2.5 and y == pytest.approx(0.68, abs=0.03)  # 0.5 + 0.18, passed at the widest place


def test_it_stops_in_a_corner():
    corner = obstacles(WALL, Box('side', 0.0, 1.0, 0.0, 2.0, 0.1, 0.5))  # x to 0.95, y to 0.95
    assert corner.move(0.0, 0.0, 5.0, 4.0)[:2] == pytest.approx((0.77, 0.77), abs=LENGTH_TOLERANCE)


def test_it_does_not_fit_through_a_narrow_gap():
    narrow = obstacles(Box('left', 1.0, 1.17, 0.0, 0.1, 2.0, 0.5), Box('right', 1.0, -1.17, 0.0, 0.1, 2.0, 0.5))
    x, _, touched = narrow.move(0.0, 0.0, 3.0, 0.0)  # 0.34 m wide, the robot 0.36 m
    assert touched and x < 1.0


def test_it_fits_through_a_wide_gap():
    wide = obstacles(Box('left', 1.0, 1.19, 0.0, 0.1, 2.0, 0.5), Box('right', 1.0, -1.19, 0.0, 0.1, 2.0, 0.5))
    assert wide.move(0.0, 0.0, 3.0, 0.0) == (pytest.approx(3.0), pytest.approx(0.0), False)


@pytest.mark.parametrize('shape, blocks', [
    (WALL._replace(height=0.05), False),  # the threshold of a maze's door
    (WALL._replace(height=0.07), True),
    (WALL._replace(bottom=0.3), False),  # driven under
    (WALL._replace(bottom=0.2), True),
    (WALL._replace(bottom=0.02, height=0.03), False),
])
def test_what_is_low_is_rolled_over_and_what_hangs_high_driven_under(shape, blocks):
    assert obstacles(shape).move(0.0, 0.0, 2.0, 0.0)[2] is blocks


def test_panel_stands_in_the_way():
    plan = FloorPlan(panels=(Panel('marker1', 1, 1.0, 0.0, 0.0),))
    assert Obstacles(plan, RADIUS, HEIGHT).move(0.0, 0.0, 2.0, 0.0)[0] == pytest.approx(0.82, abs=LENGTH_TOLERANCE)


@pytest.mark.parametrize('x, y, name', [
    (0.0, 0.0, None), (0.77, 0.0, None), (0.78, 0.0, 'wall'), (1.0, 0.0, 'wall'), (1.23, 0.0, None),
    (1.0, 2.17, 'wall'), (1.0, 2.18, None), (1.05 + 0.13, 2.0 + 0.13, None), (1.05 + 0.12, 2.0 + 0.12, 'wall'),
    (1.4, 0.0, 'post'), (2.0, 0.0, 'post'),
])
def test_what_is_there_is_named(x, y, name):
    assert obstacles(WALL, POST).at(x, y) == name


@given(plan=plans, x=places, y=places)
def test_clearance_is_the_distance_as_far_as_it_looks(plan, x, y):
    true = gap(plan, x, y)
    assume(true > 0.0)
    clearance = Obstacles(plan, RADIUS, HEIGHT).clearance(x, y)
    assert clearance == pytest.approx(min(true - RADIUS, 0.25), abs=LENGTH_TOLERANCE)


@given(plan=plans, x=places, y=places,
       ways=st.lists(st.tuples(st.floats(0.0, 6.0), yaws), min_size=1, max_size=8))
def test_it_never_gets_into_or_through_anything(plan, x, y, ways):
    assume(gap(plan, x, y) > RADIUS)
    around = Obstacles(plan, RADIUS, HEIGHT)
    for length, direction in ways:
        old_x, old_y = x, y
        x, y, touched = around.move(x, y, length * math.cos(direction), length * math.sin(direction))
        assert gap(plan, x, y) > RADIUS - 2.0 * ROUNDING - 1e-12
        moved = math.hypot(x - old_x, y - old_y)
        assert moved <= length + LENGTH_TOLERANCE
        if not touched:
            assert moved == pytest.approx(length, abs=LENGTH_TOLERANCE)
            # the way was free all along
            assert all(gap(plan, old_x + (x - old_x) * t / 20.0, old_y + (y - old_y) * t / 20.0) > RADIUS - 1e-6
                       for t in range(21))


@given(x=st.floats(-3.0, 0.7), y=places, length=st.floats(0.0, 1e4), direction=yaws)
def test_endless_wall_is_never_passed_and_slides_without_loss(x, y, length, direction):
    endless = obstacles(Box('wall', 1.0, 0.0, 0.0, 0.02, 1e6, 0.5))
    end_x, end_y, touched = endless.move(x, y, length * math.cos(direction), length * math.sin(direction))
    assert end_x <= 0.81 + LENGTH_TOLERANCE
    assert touched == (x + length * math.cos(direction) > 0.81 + ROUNDING)
    if abs(math.sin(direction)) > 1e-6:  # else it comes to rest at once
        assert end_y == pytest.approx(y + length * math.sin(direction), abs=1e-6 * max(1.0, length))


@given(plan=plans, x=places, y=places)
def test_who_stands_inside_something_is_told_so(plan, x, y):
    true = gap(plan, x, y)
    assume(abs(true - RADIUS) > 1e-6)
    assert (Obstacles(plan, RADIUS, HEIGHT).at(x, y) is None) == (true > RADIUS)
