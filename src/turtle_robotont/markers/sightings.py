"""Convert the messages of a tracker to positions of AR markers relative to the robot. ROS-free.

======================  ============================================================================================
axes                    x, y, z of a position
======================  ============================================================================================
body                    ahead, to the left, up: the axes of camera_link and base_link (REP 103)
optical                 to the right, down, ahead: the axes of frames named ..._optical or ..._optical_frame (REP 103)
auto                    optical if the name of the frame says so, else body
======================  ============================================================================================
"""
import math
from typing import NamedTuple, Sequence

from turtle_robotont.driving.shapes import InvalidInput

AXES = ('auto', 'body', 'optical')
FARTHEST = 100.0  # [m] no camera detects a marker at this distance; wrong transforms give such poses


class Sighting(NamedTuple):
    """A detected marker: its id, and the position [m] of its middle: ahead, to the left and above."""

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

    Raise InvalidInput if the position is not finite or farther away than FARTHEST.
    """
    x, y, z = position
    distance = math.sqrt(x * x + y * y + z * z) if all(map(math.isfinite, position)) else math.inf
    if not distance <= FARTHEST:
        raise InvalidInput(f'marker {marker_id} at x {x:g}, y {y:g}, z {z:g} m; each must be within {FARTHEST:g} m')
    if axes == 'optical' or axes == 'auto' and frame_id.endswith(('_optical', '_optical_frame')):
        return Sighting(marker_id, z, -x, -y)
    return Sighting(marker_id, x, y, z)
