"""kinematic_core.worlds.floor_plan: valid plans, overlaps, panels that move."""
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinematic_core.worlds.floor_plan import PANEL_THICKNESS, Box, Cylinder, FloorPlan, Panel, corners
from plain_support import InvalidInput

LENGTH_TOLERANCE = 1e-9  # [m]
BOX = Box('wall', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5)
POST = Cylinder('post', 3.0, 0.0, 0.5, 1.0)
PANEL = Panel('marker1', 1, 0.0, 2.0, math.pi / 2.0)


def plan_with(shape):
    kinds = {Box: 'boxes', Cylinder: 'cylinders', Panel: 'panels'}
    return FloorPlan(**{kinds[type(shape)]: (shape,)})


@pytest.mark.parametrize('shape', [BOX, POST, PANEL, PANEL._replace(marker_size=0.40), BOX._replace(bottom=1.0)])
def test_good_shape_passes(shape):
    plan_with(shape).check()


@pytest.mark.parametrize('shape, said', [
    (BOX._replace(length=0.0), 'wall: length is 0; it must be above 0'),
    (BOX._replace(width=-1.0), 'wall: width is -1; it must be above 0'),
    (BOX._replace(height=math.nan), 'wall: height is nan; it must be a finite number'),
    (BOX._replace(x=math.inf), 'wall: x is inf; it must be a finite number'),
    (BOX._replace(yaw='1'), "wall: yaw is '1'; it must be a finite number"),
    (BOX._replace(y=True), 'wall: y is True; it must be a finite number'),
    (BOX._replace(x=1e7), r'wall: x is 10000000.0; it must be at most 1000'),
    (BOX._replace(bottom=-0.1), 'wall: bottom is -0.1; it must be at least 0, the floor'),
    (BOX._replace(colour=(0, 0, 256)), r'wall: colour is \(0, 0, 256\); it must be three whole numbers from 0 to 255'),
    (BOX._replace(colour=(0, 0)), 'wall: colour is .*three whole numbers'),
    (BOX._replace(colour='red'), "wall: colour is 'red'; it must be three whole numbers"),
    (BOX._replace(name=''), "'': a name must have 1 to"),
    (POST._replace(radius=0.0), 'post: radius is 0; it must be above 0'),
    (PANEL._replace(marker_id=-1), 'marker1: marker_id is -1; it must be a whole number from 0 to 4294967295'),
    (PANEL._replace(marker_id=2 ** 32), 'marker1: marker_id is 4294967296; it must be'),
    (PANEL._replace(marker_id=1.5), 'marker1: marker_id is 1.5; it must be a whole number'),
    (PANEL._replace(path='round'), "marker1: path is 'round'; it must be a list of at most 1000 waypoints"),
    (PANEL._replace(path=((0.0, 1.0),)), r'marker1: path\[0\] is \(0.0, 1.0\); it must be \[time, x, y, yaw\]'),
    (PANEL._replace(path=((0.0, 0.0, math.nan, 0.0),)), r'marker1: path\[0\]: y is nan'),
    (PANEL._replace(path=((1.0, 0.0, 0.0, 0.0),)), r'path\[0\]: time is 1 s; the first must be 0'),
    (PANEL._replace(path=((0.0, 0, 0, 0), (2.0, 0, 0, 0), (1.0, 0, 0, 0))), r'path\[2\]: time is 1 s'),
    (PANEL._replace(marker_size=0.41), 'marker1: marker_size is 0.41; the panel has only 0.4 m'),
])
def test_bad_shape_is_named_with_its_field(shape, said):
    with pytest.raises(InvalidInput, match=said):
        plan_with(shape).check()


PATH = ((0.0, 0.0, 0.0, 3.0), (2.0, 4.0, 0.0, -3.0), (2.0, 4.0, 0.0, 0.0), (3.0, 4.0, 2.0, 0.0))


@pytest.mark.parametrize('time, x, y, yaw', [
    (0.0, 0.0, 0.0, 3.0),
    (1.0, 2.0, 0.0, math.pi - 2.0 * math.pi),  # half of the shorter way from 3 to -3 is at pi
    (2.0, 4.0, 0.0, 0.0),  # turned on the spot
    (2.5, 4.0, 1.0, 0.0),
    (3.0, 0.0, 0.0, 3.0),  # and again
    (7.0, 2.0, 0.0, -math.pi),
])
def test_a_panel_moves_along_its_path(time, x, y, yaw):
    moved = plan_with(PANEL._replace(path=PATH)).at(time).panels[0]
    assert (moved.x, moved.y, moved.yaw) == pytest.approx((x, y, yaw), abs=LENGTH_TOLERANCE)


def test_a_path_of_one_waypoint_is_a_place():
    assert PANEL._replace(path=((0.0, 5.0, 6.0, 0.5),)).at(9.0)[2:5] == (5.0, 6.0, 0.5)


def test_a_panel_that_moves_is_seen_and_stops_nothing():
    plan = FloorPlan(boxes=(BOX,), panels=(PANEL._replace(path=PATH), PANEL._replace(name='marker2')))
    plan.check()
    assert [solid.name for solid in plan.solids()] == ['wall', 'marker1', 'marker2']
    assert [body.name for body in plan.bodies()] == ['wall', 'marker2']
    placed = plan.with_moved([(7.0, 8.0, 0.1)])
    assert placed.panels[0][2:5] == (7.0, 8.0, 0.1) and placed.panels[1] == plan.panels[1]
    with pytest.raises(InvalidInput, match="'marker1' moves by itself"):
        plan.with_panel('marker1', 0.0, 0.0, 0.0)


def test_names_are_unique_over_all_kinds():
    with pytest.raises(InvalidInput, match='wall: the name is used twice'):
        FloorPlan(boxes=(BOX,), cylinders=(POST._replace(name='wall'),)).check()


@pytest.mark.parametrize('field', ['ground_colour', 'sky_colour'])
def test_colours_of_the_world_are_checked(field):
    with pytest.raises(InvalidInput, match=field):
        FloorPlan(**{field: (0, 0, -1)}).check()


# BOX spans x -1..1, y -0.5..0.5, z 0..0.5
@pytest.mark.parametrize('other, depth', [
    (Box('b', 1.9, 0.0, 0.0, 2.0, 1.0, 0.5), 0.1),  # from x = 0.9
    (Box('b', 2.0, 0.0, 0.0, 2.0, 1.0, 0.5), None),  # side by side
    (Box('b', 1.995, 0.0, 0.0, 2.0, 1.0, 0.5), None),  # 5 mm: touching
    (Box('b', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5), 0.5),  # the same box: up is the shortest way out
    (Box('b', 0.0, 0.0, 0.0, 2.0, 1.0, 0.5, bottom=0.5), None),  # on top
    (Box('b', 1.5, 0.0, math.pi / 2.0, 2.0, 1.2, 0.5), 0.1),  # turned: x 0.9..2.1
    # a square on its corner, half a diagonal = 0.7071 m: reaches to x = 1.6 - 0.7071 = 0.8929
    (Box('b', 1.6, 0.0, math.pi / 4.0, 1.0, 1.0, 0.5), 1.0 - (1.6 - math.sqrt(0.5))),
    (Cylinder('c', 1.4, 0.0, 0.5, 1.0), 0.1),
    (Cylinder('c', 1.6, 0.0, 0.5, 1.0), None),
    # off the corner (1, 0.5): 0.6 m away along the diagonal, so no overlap though the bounding squares do
    (Cylinder('c', 1.0 + 0.6 * math.sqrt(0.5), 0.5 + 0.6 * math.sqrt(0.5), 0.5, 1.0), None),
    (Cylinder('c', 1.0 + 0.4 * math.sqrt(0.5), 0.5 + 0.4 * math.sqrt(0.5), 0.5, 1.0), 0.1),
])
def test_overlap_is_found_with_its_depth(other, depth):
    plan = FloorPlan(boxes=(BOX,) + ((other,) if isinstance(other, Box) else ()),
                     cylinders=(other,) if isinstance(other, Cylinder) else ())
    found = plan.overlaps()
    if depth is None:
        assert found == []
    else:
        assert [pair[:2] for pair in found] == [('wall', other.name)]
        assert found[0][2] == pytest.approx(depth, abs=LENGTH_TOLERANCE)


def test_two_cylinders_overlap_by_their_radii():
    plan = FloorPlan(cylinders=(POST, POST._replace(name='b', x=3.0, y=0.9), POST._replace(name='c', y=-1.1)))
    assert [(a, b) for a, b, _ in plan.overlaps()] == [('post', 'b')]
    assert FloorPlan(cylinders=(POST, POST._replace(name='same'))).overlaps()[0][2] == pytest.approx(1.0)


def test_panel_moves_and_the_old_plan_stays():
    plan = FloorPlan(panels=(PANEL, PANEL._replace(name='marker2', marker_id=2)))
    moved = plan.with_panel('marker2', 1.0, -1.0, 0.5)
    assert moved.panels == (PANEL, Panel('marker2', 2, 1.0, -1.0, 0.5))
    assert plan.panels[1].x == 0.0


@pytest.mark.parametrize('arguments, said', [
    (('marker9', 0.0, 0.0, 0.0), "there is no panel 'marker9'; the panels are: marker1"),
    (('marker1', math.nan, 0.0, 0.0), "the panel 'marker1': x is nan"),
    (('marker1', 0.0, 0.0, math.inf), "the panel 'marker1': yaw is inf"),
])
def test_panel_that_cannot_move(arguments, said):
    with pytest.raises(InvalidInput, match=said):
        FloorPlan(panels=(PANEL,)).with_panel(*arguments)


def test_panel_is_a_board_behind_its_face():
    # yaw 90 degrees: the face looks along -y, the board lies on the +y side of the face at y = 2
    board = PANEL.board()
    assert (board.x, board.y) == pytest.approx((0.0, 2.0 + PANEL_THICKNESS / 2.0), abs=LENGTH_TOLERANCE)
    xs, ys = zip(*corners(board))
    assert (min(xs), max(xs)) == pytest.approx((-0.2, 0.2), abs=LENGTH_TOLERANCE)
    assert (min(ys), max(ys)) == pytest.approx((2.0, 2.0 + PANEL_THICKNESS), abs=LENGTH_TOLERANCE)
    assert (board.bottom, board.bottom + board.height) == pytest.approx((0.05, 0.45))
    assert FloorPlan(panels=(PANEL,)).solids() == (board,)


@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0), yaw=st.floats(-4.0, 4.0))
def test_overlap_is_the_same_both_ways_and_holds_for_points(x, y, yaw):
    other = Box('b', x, y, yaw, 1.0, 0.6, 0.5)
    depth = {a: d for a, _, d in FloorPlan(boxes=(BOX, other)).overlaps(0.0)}.get('wall')
    back = {a: d for a, _, d in FloorPlan(boxes=(other, BOX)).overlaps(0.0)}.get('b')
    assert (depth is None) == (back is None)
    assert depth is None or depth == pytest.approx(back)
    if any(abs(px) < 0.99 and abs(py) < 0.49 for px, py in corners(other)):
        assert depth is not None


def test_outlines_are_those_of_what_a_scanner_sees():
    plan = FloorPlan((Box('wall', 0.0, 1.0, 0.0, 2.0, 0.2, 0.5), Box('door', 5.0, 0.0, 0.0, 1.0, 1.0, 0.05)),
                     (Cylinder('post', 3.0, 0.0, 0.5, 1.0),))
    wall, post = plan.outlines(0.3)
    assert [(round(x, 9), round(y, 9)) for x, y in sorted(wall)] == [(-1.0, 0.9), (-1.0, 1.1), (1.0, 0.9), (1.0, 1.1)]
    assert [math.hypot(x - 3.0, y) for x, y in post] == pytest.approx([0.5] * len(post))
