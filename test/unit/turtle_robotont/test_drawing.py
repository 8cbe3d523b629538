"""turtle_robotont.driving.drawing: planned, driven in the simulated world and measured."""
import math

import pytest

from turtle_robotont.driving import drawing, shapes
from turtle_robotont.driving.control import Goal, State
from turtle_robotont.driving.shapes import InvalidInput
from turtle_robotont.driving.vehicle import Limits
from unit_support.robot_loop import path_deviation

CORNER_TOLERANCE = 0.05  # [m] limit for the shapes of the course; the controller needs a fifth of it
STRAIGHT_TOLERANCE = 0.03  # [m] off the lines between the corners
FOUR = [[3.0, 3.0], [6.0, 3.5], [5.5, 7.0], [2.5, 6.0]]


@pytest.mark.parametrize('delay', [0, 1, 2, 3])
@pytest.mark.parametrize('shape, size, start, speed', [
    ('square', 2.0, (5.5, 5.5, 0.0), 2.0),
    ('square', 5.5, (5.5, 5.5, 0.0), 1.0),
    ('square', 0.3, (5.5, 5.5, 1.0), 2.0),
    ('triangle', 2.0, (5.5, 5.5, -2.0), 3.0),
    ('circle', 2.0, (5.5, 5.5, 0.0), 2.0),
    ('circle', 0.4, (5.5, 5.5, 3.0), 5.0),
    ('corners', 0.0, (9.0, 9.0, 0.0), 2.0),
])
def test_shape_is_drawn_within_the_tolerance(loop, shape, size, start, speed, delay):
    run = loop(start, delay)
    plan = drawing.plan(shape, run.pose, size, FOUR, Limits(speed, 5.0))
    run.run(plan.drive)
    assert plan.drive.state is State.ARRIVED
    worst, gap = plan.errors(run.track)
    assert worst <= CORNER_TOLERANCE / 2.0 and gap <= CORNER_TOLERANCE / 2.0
    if plan.corners:
        lines = [run.track[0], *plan.corners]
        assert path_deviation(run.track, lines) <= STRAIGHT_TOLERANCE


def test_closed_shape_ends_with_the_heading_it_began_with(loop):
    for shape in (*shapes.POLYGONS, 'circle'):
        run = loop((5.0, 5.0, 0.5))
        run.run(drawing.plan(shape, run.pose, 1.5).drive)
        assert run.pose.theta == pytest.approx(0.5, abs=0.03)


def test_given_corners_are_closed():
    plan = drawing.plan('corners', Goal(1.0, 1.0, 0.0), corners=FOUR)
    assert [list(corner) for corner in plan.corners] == [*FOUR, FOUR[0]] and list(plan.start) == FOUR[0]


def test_teleport_spoils_a_drawing_and_shows_in_its_errors(loop):
    run = loop()
    plan = drawing.plan('square', run.pose)

    def disturb(loop):
        if 2.0 < loop.time < 2.01:
            loop.world.teleport_absolute('turtle1', 1.0, 1.0, 0.0)
    run.run(plan.drive, disturb)
    assert plan.drive.state is State.FAILED and 'of 4: something else moved the turtle' in plan.drive.reason
    worst, gap = plan.errors(run.track)
    assert worst > 1.0 and gap > 1.0


@pytest.mark.parametrize('shape, size, corners, text', [
    ('hexagon', 1.0, (), f"no shape 'hexagon'; choose one of {', '.join(shapes.SHAPES)}"),
    ('square', 20.0, (), 'would leave the arena'),
    ('circle', math.nan, (), 'size is nan'),
    ('corners', 1.0, [[1.0, 1.0], [1.0, 12.0]], 'corner 2 (1.00, 12.00) outside'),
    ('corners', 1.0, [[1.0, 1.0]], 'at least 2'),
])
def test_what_cannot_be_drawn_is_refused(shape, size, corners, text):
    with pytest.raises(InvalidInput) as refusal:
        drawing.plan(shape, Goal(5.0, 5.0, 0.0), size, corners)
    assert text in str(refusal.value)
