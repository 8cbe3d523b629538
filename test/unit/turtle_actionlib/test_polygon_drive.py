"""Polygons: their measures, and a turtle that is driven round them."""
import math

import pytest

from kinematic_core.worlds.planar import STILL, Pose2D, advance
from turtle_actionlib.core.polygon_drive import Polygon, PolygonDrive

DT = 0.016  # [s] a step of turtlesim
LATE = 3  # [steps] after which a velocity acts
LONGEST = 60.0  # [s]


@pytest.mark.parametrize('edges, radius, side, apothem, angle', [
    (4, math.sqrt(2.0), 2.0, 1.0, math.pi / 2.0),
    (6, 1.0, 1.0, math.sqrt(0.75), math.radians(120.0)),
    (3, 1.0, math.sqrt(3.0), 0.5, math.radians(60.0)),
])
def test_measures(edges, radius, side, apothem, angle):
    polygon = Polygon(edges, radius)
    assert (polygon.side, polygon.apothem, polygon.interior_angle) == pytest.approx((side, apothem, angle))


@pytest.mark.parametrize('edges, radius, said', [
    (2, 1.0, 'edges is 2; it must be 3 to 100'), (-5, 1.0, 'edges is -5'), (101, 1.0, 'edges is 101'),
    (5, 0.0, 'radius is 0; it must be 0.1 to 11 m'), (5, -1.0, 'radius is -1'), (5, math.nan, 'radius is nan'),
    (5, math.inf, 'radius is inf'),
])
def test_what_is_no_polygon_is_refused(edges, radius, said):
    with pytest.raises(ValueError, match=said):
        Polygon(edges, radius)


def driven(edges, radius, late=0):
    """Return the poses of a turtle that draws a polygon, with velocities that act ``late`` steps later."""
    drive, pose, poses = PolygonDrive(Polygon(edges, radius)), Pose2D(5.0, 5.0, 0.3), []
    under_way = [STILL] * late
    for _ in range(int(LONGEST / DT)):
        velocity = drive.step(pose)
        if velocity is None:
            return poses
        under_way.append(velocity)
        pose = advance(pose, under_way.pop(0), DT)
        poses.append(pose)
    raise AssertionError(f'not done in {LONGEST} s')


@pytest.mark.parametrize('edges', [3, 4, 5, 12])
@pytest.mark.parametrize('late', [0, LATE])
def test_turtle_comes_back_and_has_turned_once(edges, late):
    poses = driven(edges, 1.3, late)
    assert poses[-1] == pytest.approx((5.0, 5.0, 0.3), abs=1e-3)
    turned = sum(math.remainder(b.yaw - a.yaw, 2.0 * math.pi) for a, b in zip(poses, poses[1:]))
    assert turned == pytest.approx(2.0 * math.pi, abs=0.01)


def test_corners_are_those_of_the_polygon():
    # a square with a side of 2 m from (5, 5), its first edge at 0.3 rad
    corners = [(5 + 2 * math.cos(0.3), 5 + 2 * math.sin(0.3)), (5 - 2 * math.sin(0.3), 5 + 2 * math.cos(0.3))]
    poses = driven(4, math.sqrt(2.0))
    for x, y in corners:
        assert min(math.hypot(pose.x - x, pose.y - y) for pose in poses) < 1e-4
