"""The points that a laser scan has hit, in the frame of the robot."""
import math
from typing import NamedTuple

import numpy as np

from navigation_core.poses import Array, Pose

LARGEST_ANGLE = 2.0 * math.pi + 0.1  # [rad] that a scan covers


class Scan(NamedTuple):
    """The usable beams of a scan, in the order of their angles, in the frame of the robot.

    ``points`` (beams, 2) [m] are where the beams end, ``hit`` (beams,) whether a solid is there: a beam longer than
    the usable range only shows free space. ``ranges`` (beams,) [m] and ``angles`` (beams,) [rad] are in the
    scanner's frame, whose pose on the robot is ``mount``. ``spacing`` [rad] lies between two neighbouring beams.
    """

    points: Array
    hit: Array
    ranges: Array
    angles: Array
    mount: Pose
    spacing: float


def usable(ranges: Array, angle_min: float, angle_increment: float, nearest: float, farthest: float,
           usable_range: float, mount: Pose) -> Scan:
    """Return the Scan of a LaserScan's fields; beams without a finite range in [nearest, farthest) [m] are left out.

    Beams beyond ``usable_range`` [m] are cut there. Raise ValueError unless the angles are finite.
    """
    ranges = np.asarray(ranges, dtype=float)
    if not (math.isfinite(angle_min) and 0.0 < abs(angle_increment) * max(len(ranges) - 1, 1) < LARGEST_ANGLE):
        raise ValueError(f'angle_min is {angle_min:g}, angle_increment {angle_increment:g} rad, for {len(ranges)} '
                         f'ranges; the scan must cover more than 0 and at most {LARGEST_ANGLE:.4g} rad')
    with np.errstate(invalid='ignore'):
        kept = np.isfinite(ranges) & (ranges >= max(nearest, 1e-3)) & (ranges < farthest)
    angles = angle_min + angle_increment * np.flatnonzero(kept)
    ranges = ranges[kept]
    hit = ranges < usable_range
    ranges = np.minimum(ranges, usable_range)
    if angle_increment < 0.0:  # a scanner that is mounted upside down turns clockwise
        angles, ranges, hit = angles[::-1], ranges[::-1], hit[::-1]
    x, y = mount.to_outer(ranges * np.cos(angles), ranges * np.sin(angles))
    return Scan(np.stack([x, y], axis=1), hit, ranges, angles, mount, abs(angle_increment))
