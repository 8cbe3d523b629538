"""A horizontal laser scan from the rows around the middle of a depth image. No ROS.

The camera's optical frame: z forward, x right, y down. Angles of the scan count from the optical axis,
counter-clockwise seen from above, so the first ray belongs to the right edge of the image.
"""
import math
from typing import NamedTuple

import numpy as np


class ScanError(ValueError):
    """An image cannot be converted to a scan; the text says why."""


class Camera(NamedTuple):
    """Focal length and principal point [px] of a rectified image."""

    fx: float
    cx: float
    cy: float


class Settings(NamedTuple):
    """The number of rows that are used, and the limits of the ranges [m] that count."""

    height: int
    nearest: float
    farthest: float


class Scan(NamedTuple):
    """Angles [rad] of the first and the last ray, and the ranges (rays,) float32 [m] from right to left."""

    first: float
    last: float
    ranges: np.ndarray


def scan(depths: np.ndarray, camera: Camera, settings: Settings) -> Scan:
    """Return the Scan of depths (height, width) [m]: per ray, the smallest range within the settings' limits.

    A ray without such a range is inf if one of its pixels is, otherwise NaN. Rays have equal angles between them, as
    LaserScan requires, but columns do not: a ray without a column of its own is NaN, and where two columns share one,
    the nearer counts. Raise ScanError if the rows are not in the image.
    """
    height, width = depths.shape
    half = settings.height // 2
    if not (camera.fx > 0.0 and half <= camera.cy <= height - half):
        raise ScanError(f'scan_height is {settings.height} px; around the row {camera.cy:g} of an image with {height} '
                        f'rows, at most {max(0, 2 * int(min(camera.cy, height - camera.cy)))} are possible')
    first_row = int(camera.cy - half)
    slopes = (np.arange(width) - camera.cx) / camera.fx
    angles = -np.arctan(slopes)
    first, last = float(angles[-1]), float(angles[0])
    ranges = depths[first_row:first_row + settings.height] * np.hypot(slopes, 1.0).astype(np.float32)
    with np.errstate(invalid='ignore'):
        counts = (ranges >= settings.nearest) & (ranges <= settings.farthest)
    columns = np.where(counts, ranges, np.float32(np.inf)).min(axis=0)
    endless = np.isinf(ranges).any(axis=0)
    columns[np.isinf(columns) & ~endless] = np.nan
    increment = (last - first) / (width - 1) if width > 1 else math.inf
    index = ((angles - first) / increment).astype(int)
    found = np.full(width, np.nan, np.float32)
    np.fmin.at(found, index, columns)
    return Scan(first, last, found)
