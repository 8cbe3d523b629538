"""From the name of a shape to the drive that draws it, and to how well it was drawn. ROS-free.

Units and frames as in turtle_robotont.shapes.
"""
from typing import NamedTuple

from kinematic_core.checks import InvalidInput
from turtle_robotont import checks, shapes
from turtle_robotont.control import CircleDrive, Drive, Goal, GoTo, Path
from turtle_robotont.strafing import StrafeCircle, StrafeTo
from turtle_robotont.vehicle import TURTLE


class Drawing(NamedTuple):
    """A shape about to be drawn: the drive, the corners to pass in order, or a circle's centre and radius [m]."""

    drive: Drive
    begin: shapes.Point
    corners: list
    centre: shapes.Point = None
    radius: float = 0.0

    def errors(self, track):
        """Return (largest corner or circle error, gap at the end) [m] of the track that the turtle drove."""
        if self.centre is not None:
            worst = checks.radius_deviation(track, self.centre, self.radius)
        else:
            worst = max(checks.corner_misses(track, self.corners))
        return worst, shapes.distance(track[-1], self.begin)


def plan(shape, start, size=shapes.DEFAULT_SIZE, corners=(), limits=None, vehicle=TURTLE, strafe=False):
    """Return the Drawing of a shape for a vehicle that stands at the pose ``start``.

    ``size`` [m] counts for a square, triangle and circle, ``corners`` (pairs [x, y], m) for 'corners'; ``limits``: the
    vehicle's own by default. With ``strafe`` it keeps its heading, otherwise it turns into every direction it drives.
    Raises InvalidInput when the shape is unknown or any part of it would leave the vehicle's arena.
    """
    if shape not in shapes.SHAPES:
        raise InvalidInput(f'there is no shape {shape!r}; choose one of {", ".join(shapes.SHAPES)}')
    limits = limits or vehicle.limits
    if shape == 'corners':
        points = shapes.points_from(corners)
        if vehicle.arena is not None:
            shapes.require_fit(points)
        return _polyline([*points, points[0]], points[0], start, _leg_maker(start, limits, vehicle, strafe), None)
    shapes.require_size(size)
    if vehicle.arena is not None:
        shapes.require_shape_fits(shape, size, start)
    begin = shapes.Point(start.x, start.y)
    if shape == 'circle':
        drive = (StrafeCircle if strafe else CircleDrive)(start, size / 2.0, limits, vehicle=vehicle)
        return Drawing(drive, begin, [], shapes.circle_centre(size, start), size / 2.0)
    return _polyline(shapes.polygon(shapes.SIDES[shape], size, start), begin,
                     start, _leg_maker(start, limits, vehicle, strafe), start.theta)


def _leg_maker(start, limits, vehicle, strafe):
    """Return the function (begin, goal) that makes the drive of one side."""
    if strafe:
        return lambda begin, goal: StrafeTo(begin, goal._replace(theta=start.theta), limits, vehicle=vehicle)
    return lambda begin, goal: GoTo(begin, goal, limits, jumps_forgiven=0, vehicle=vehicle)


def _polyline(corners, begin, start, leg, last_heading):
    legs, before = [], start
    for corner in corners:
        heading = last_heading if len(legs) == len(corners) - 1 else None
        legs.append(leg(before, Goal(corner.x, corner.y, heading)))
        before = corner
    return Drawing(Path(legs), begin, corners)
