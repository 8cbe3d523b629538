"""Ranges of a laser scan in three sectors of equally many rays: the message LaserScanSplit."""
import math
from typing import NamedTuple, Sequence

import numpy as np

from kinematic_core.worlds import camera

# [px] in laser_params.yaml of robotont_laserscan_to_distance, half of them below the horizon: 200 at a width of 1280
SCAN_HEIGHT = round(200 / 1280 * camera.WIDTH)


class Sector(NamedTuple):
    """The smallest range and the mean of the finite ranges [m]; NaN where there is none."""

    nearest: float
    mean: float


class Sectors(NamedTuple):
    """A Sector for each third of a scan, which begins at the right."""

    right: Sector
    center: Sector
    left: Sector


def floor_depth(height: float, focal: float) -> float:
    """Return the depth [m] at which the lowest row of the scan shows the floor: farther, nothing else is seen.

    The camera is level, ``height`` [m] above the floor, with a focal length of ``focal`` [px].
    """
    return height * focal / (SCAN_HEIGHT / 2.0)


def split(ranges: Sequence[float]) -> Sectors:
    """Return the Sectors of ranges [m]; NaN does not count, and inf is farther than any obstacle."""
    third = len(ranges) // 3
    return Sectors(_sector(ranges[:third]), _sector(ranges[third:2 * third]), _sector(ranges[2 * third:]))


def _sector(ranges: Sequence[float]) -> Sector:
    values = np.asarray(ranges, float)
    values = values[~np.isnan(values)]
    finite = values[np.isfinite(values)]
    return Sector(float(values.min()) if values.size else math.nan, float(finite.mean()) if finite.size else math.nan)
