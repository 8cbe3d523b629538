"""kinematic_core.worlds.rays: where rays end, against cases by hand and against a slow way to compute them."""
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from kinematic_core.worlds.floor_plan import Box, Cylinder, FloorPlan, Panel, corners
from kinematic_core.worlds.rays import LaserScanner, RayCaster

LENGTH_TOLERANCE = 1e-6  # [m]
HEIGHT = 0.148  # [m]
WALL = Box('wall', 2.0, 0.0, 0.0, 0.2, 2.0, 0.5)  # x 1.9..2.1, y -1..1
POST = Cylinder('post', 0.0, 3.0, 0.5, 1.0)
PLAN = FloorPlan(boxes=(WALL,), cylinders=(POST,))


def cast(plan, x, y, yaw, *degrees, height=HEIGHT):
    return list(RayCaster(plan, height, np.radians(degrees)).ranges(x, y, yaw))


@pytest.mark.parametrize('x, y, yaw, degrees, way', [
    (0.0, 0.0, 0.0, 0.0, 1.9),
    (0.0, 0.0, math.pi / 2.0, 0.0, 2.5),  # the post, 3 m less its radius
    (2.0, 0.5, 0.0, 33.0, 0.0),  # inside the wall
    (0.0, 3.2, 0.0, 33.0, 0.0),  # inside the post
    (1.9, -3.0, math.pi / 2.0, 0.0, 2.0),  # along the side's line: it meets the corner
])
def test_ray_by_hand(x, y, yaw, degrees, way):
    assert cast(PLAN, x, y, yaw, degrees) == [pytest.approx(way, abs=LENGTH_TOLERANCE)]


@pytest.mark.parametrize('height, way', [(0.148, 1.9), (0.6, math.inf), (0.02, 1.9)])
def test_only_what_the_plane_cuts_counts(height, way):
    assert cast(PLAN, 0.0, 0.0, 0.0, 0.0, height=height) == [pytest.approx(way)]


def test_threshold_is_below_the_rays():
    assert cast(FloorPlan(boxes=(WALL._replace(height=0.05),)), 0.0, 0.0, 0.0, 0.0) == [math.inf]


def test_panel_is_seen_at_its_face():
    plan = FloorPlan(panels=(Panel('marker1', 1, 1.5, 0.0, 0.0),))
    assert cast(plan, 0.0, 0.0, 0.0, 0.0) == [pytest.approx(1.5)]


def test_no_ray_gets_through_where_two_walls_meet():
    # a closed square room of four walls that touch; rays to the very corners, of the room and of the walls
    room = FloorPlan(boxes=tuple(Box(f'b{n}', *place, 0.0, *size, 0.5) for n, (place, size) in enumerate([
        ((1.05, 0.0), (0.1, 2.0)), ((-1.05, 0.0), (0.1, 2.0)), ((0.0, 1.05), (2.2, 0.1)), ((0.0, -1.05), (2.2, 0.1))])))
    for x, y in ((0.0, 0.0), (0.3, -0.7), (0.1, 0.2)):
        angles = [math.degrees(math.atan2(to_y - y, to_x - x)) for to_x in (-1.0, 1.0) for to_y in (-1.0, 1.0)]
        assert max(cast(room, x, y, 0.0, *angles, *range(360))) < 3.0


def slow_ray(plan, x, y, angle):
    """Return the way of one ray by intersecting it with every side and every circle."""
    ways, dx, dy = [math.inf], math.cos(angle), math.sin(angle)
    for box in plan.boxes:
        ring = corners(box)
        for (ax, ay), (bx, by) in zip(ring, ring[1:] + ring[:1]):
            ex, ey = bx - ax, by - ay
            across = dx * ey - dy * ex
            if across:
                way = ((ax - x) * ey - (ay - y) * ex) / across
                share = ((ax - x) * dy - (ay - y) * dx) / across
                if way > 0.0 and 0.0 <= share <= 1.0:
                    ways.append(way)
    for post in plan.cylinders:
        ahead = (post.x - x) * dx + (post.y - y) * dy
        square = post.radius ** 2 - ((post.x - x) * dy - (post.y - y) * dx) ** 2
        if square >= 0.0 and ahead - math.sqrt(square) > 0.0:
            ways.append(ahead - math.sqrt(square))
    return min(ways)


places, sizes = st.floats(-5.0, 5.0), st.floats(0.05, 2.0)
boxes = st.builds(lambda x, y, yaw, length, width: Box('b', x, y, yaw, length, width, 0.5),
                  places, places, st.floats(-4.0, 4.0), sizes, sizes)
posts = st.builds(lambda x, y, radius: Cylinder('c', x, y, radius, 0.5), places, places, sizes)


def inside(plan, x, y):
    return (any(math.hypot(post.x - x, post.y - y) <= post.radius + LENGTH_TOLERANCE for post in plan.cylinders)
            or any(all((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) >= -LENGTH_TOLERANCE
                       for a, b in zip(ring, ring[1:] + ring[:1])) for ring in map(corners, plan.boxes)))


@given(st.lists(boxes, max_size=4), st.lists(posts, max_size=3), places, places, st.floats(-4.0, 4.0))
def test_rays_agree_with_the_slow_way(some_boxes, some_posts, x, y, yaw):
    plan = FloorPlan(boxes=tuple(some_boxes), cylinders=tuple(some_posts))
    assume(not inside(plan, x, y))
    angles = np.linspace(-3.0, 3.0, 21)
    for angle, fast in zip(angles, RayCaster(plan, HEIGHT, angles).ranges(x, y, yaw)):
        # a ray that just touches a corner or a circle may go either way
        slow = [slow_ray(plan, x, y, yaw + angle + aside) for aside in (-1e-6, 0.0, 1e-6)]
        assert min(slow) - 1e-3 <= fast <= max(slow) + 1e-3


def test_scanner_begins_behind_and_goes_counter_clockwise():
    scan = LaserScanner(FloorPlan(boxes=(WALL,), cylinders=(POST,)), HEIGHT, noise=0.0).scan(0.0, 0.0, 0.0)
    step = 2.0 * math.pi / 719.0
    assert scan[round(1.5 * math.pi / step)] == pytest.approx(2.5, abs=1e-3)  # +90 degrees: the post
    assert scan[round(math.pi / step)] == pytest.approx(1.9, abs=1e-3)
    assert np.isinf(scan[0]) and np.isinf(scan[round(0.5 * math.pi / step)])


def test_scanner_reaches_as_far_as_it_should():
    far = FloorPlan(boxes=(Box('near', 30.5, 0.0, 0.0, 1.2, 1.0, 0.5), Box('far', -30.6, 0.0, 0.0, 1.0, 1.0, 0.5)))
    scan = LaserScanner(far, HEIGHT, noise=0.0).scan(0.0, 0.0, 0.0)
    assert scan[359] == pytest.approx(29.9, abs=1e-2) and np.isinf(scan[0])
    close = FloorPlan(boxes=(Box('close', 0.55, 0.0, 0.0, 1.0, 1.0, 0.5),))
    assert LaserScanner(close, HEIGHT, noise=0.0).scan(0.0, 0.0, 0.0)[359] == 0.1


def test_noise_is_gaussian_seeded_and_on_every_ray():
    room = FloorPlan(cylinders=(Cylinder('room', 0.0, 0.0, 1.0, 1.0),))
    scanner = LaserScanner(room, HEIGHT, seed=3)
    exact = LaserScanner(room, HEIGHT, noise=0.0).scan(-4.0, 0.0, 0.0)
    hit = np.isfinite(exact)
    errors = np.concatenate([scanner.scan(-4.0, 0.0, 0.0)[hit] - exact[hit] for _ in range(100)])
    assert errors.std() == pytest.approx(0.01, rel=0.05)
    assert abs(errors.mean()) < 5e-4
    again = LaserScanner(room, HEIGHT, seed=3)
    assert np.array_equal(again.scan(-4.0, 0.0, 0.0)[hit], LaserScanner(room, HEIGHT, seed=3).scan(-4.0, 0.0, 0.0)[hit])
    assert not np.array_equal(again.scan(-4.0, 0.0, 0.0)[hit],
                              LaserScanner(room, HEIGHT, seed=4).scan(-4.0, 0.0, 0.0)[hit])


def test_scanner_looks_at_the_plan_it_is_given():
    scanner = LaserScanner(FloorPlan(), HEIGHT, noise=0.0)
    scanner.set_plan(FloorPlan(boxes=(WALL,)))
    assert scanner.scan(0.0, 0.0, 0.0)[359] == pytest.approx(1.9, abs=1e-3)
