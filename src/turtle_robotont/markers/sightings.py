"""Turns what a tracker reports into positions of AR markers relative to the robot. ROS-free.

======================  ============================================================================================
axes                    x, y, z of a position
======================  ============================================================================================
body                    ahead, to the left, up: REP 103's, that of camera_link and base_link
optical                 to the right, down, ahead: REP 103's for frames whose names end in _optical or _optical_frame
auto                    optical where the frame's name says so, else body
======================  ============================================================================================
"""
import math
from typing import NamedTuple, Sequence

from kinematic_core.validation import InvalidInput

AXES = ('auto', 'body', 'optical')
FURTHEST = 100.0  # [m] at which no camera makes out a marker any more; broken transforms give such poses


class Sighting(NamedTuple):
    """A marker seen: its id, and the position of its middle [m]: ahead, to the left and above."""

    id: int
    ahead: float
    left: float
    up: float

    @property
    def distance(self) -> float:
        """Return the distance [m] over the ground."""
        return math.hypot(self.ahead, self.left)

    @property
    def bearing(self) -> float:
        """Return the direction [rad], positive to the left."""
        return math.atan2(self.left, self.ahead)


def sighting(marker_id: int, position: Sequence[float], frame_id: str, axes: str = 'auto') -> Sighting:
    """Return the Sighting of a marker at ``position`` (x, y, z) [m] in a frame with these axes.

    Raises InvalidInput when no marker can be there: not finite, or further away than FURTHEST.
    """
    x, y, z = position
    distance = math.sqrt(x * x + y * y + z * z) if all(map(math.isfinite, position)) else math.inf
    if not distance <= FURTHEST:
        raise InvalidInput(f'marker {marker_id} at x {x:g}, y {y:g}, z {z:g} m; each must be within {FURTHEST:g} m')
    if axes == 'optical' or axes == 'auto' and frame_id.endswith(('_optical', '_optical_frame')):
        return Sighting(marker_id, z, -x, -y)
    return Sighting(marker_id, x, y, z)
