"""Plan the drive that draws a shape, and measure how well it was drawn. ROS-free.

Units and frames as in turtle_robotont.driving.shapes.
"""
from typing import Any, List, NamedTuple, Optional, Sequence, Tuple

from turtle_robotont.driving import accuracy, shapes
from turtle_robotont.driving.control import CircleDrive, Drive, DriveSequence, Goal, GoTo, Leg
from turtle_robotont.driving.shapes import HasPosition, InvalidInput, Point
from turtle_robotont.driving.strafing import StrafeCircle, StrafeTo
from turtle_robotont.driving.vehicle import TURTLE, Limits, Vehicle, VehicleState


class Drawing(NamedTuple):
    """A planned shape: its drive and start, and the corners in their order, or a circle's centre and radius [m]."""

    drive: Drive
    start: Point
    corners: List[Point]
    centre: Optional[Point] = None
    radius: float = 0.0

    def errors(self, track: Sequence[VehicleState]) -> Tuple[float, float]:
        """Return (largest corner or circle error, gap at the end) [m] of the track that the turtle drove."""
        if self.centre is not None:
            worst = accuracy.radius_deviation(track, self.centre, self.radius)
        else:
            worst = max(accuracy.corner_misses(track, self.corners))
        return worst, shapes.distance(track[-1], self.start)


def plan(shape: str, start: VehicleState, size: float = shapes.DEFAULT_SIZE, corners: Sequence[Any] = (),
         limits: Optional[Limits] = None, vehicle: Vehicle = TURTLE, strafe: bool = False) -> Drawing:
    """Return the Drawing of a shape for a vehicle that stands at ``start``.

    ``size`` [m] applies to all shapes except 'corners', which takes ``corners``, pairs [x, y] [m]. ``limits`` default
    to the vehicle's own. With ``strafe``, the vehicle keeps its heading; otherwise it turns towards each corner.
    Raise InvalidInput if the shape is unknown or any part of it would leave the vehicle's arena.
    """
    if shape not in shapes.SHAPES:
        raise InvalidInput(f'there is no shape {shape!r}; choose one of {", ".join(shapes.SHAPES)}')
    limits = limits or vehicle.limits
    if shape == 'corners':
        points = shapes.points_from(corners)
        if vehicle.arena is not None:
            shapes.require_fit(points)
        legs = _legs([*points, points[0]], start, limits, vehicle, strafe, None)
        return Drawing(DriveSequence(legs), points[0], [*points, points[0]])
    shapes.require_size(size)
    if vehicle.arena is not None:
        shapes.require_shape_fits(shape, size, start)
    position = Point(start.x, start.y)
    if shape == 'circle':
        circle_drive = StrafeCircle if strafe else CircleDrive
        return Drawing(circle_drive(start, size / 2.0, limits, vehicle=vehicle), position, [],
                       shapes.circle_centre(size, start), size / 2.0)
    points = shapes.POLYGONS[shape](size, start)
    return Drawing(DriveSequence(_legs(points, start, limits, vehicle, strafe, start.theta)), position, points)


def _legs(corners: Sequence[Point], start: VehicleState, limits: Limits, vehicle: Vehicle, strafe: bool,
          last_heading: Optional[float]) -> List[Leg]:
    """Return the drives from ``start`` from corner to corner; ``last_heading`` [rad]: the one to end with, if any."""
    legs: List[Leg] = []
    previous: HasPosition = start
    for corner in corners:
        heading = last_heading if len(legs) == len(corners) - 1 else None
        if strafe:
            legs.append(StrafeTo(previous, corner, start.theta, limits, vehicle=vehicle))
        else:
            legs.append(GoTo(previous, Goal(corner.x, corner.y, heading), limits, jumps_forgiven=0, vehicle=vehicle))
        previous = corner
    return legs
