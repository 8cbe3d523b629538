"""A grid that counts how often each cell was hit and how often beams passed it, and has the distance to the walls.

Near a wall, the distance is the mean of the scans, so it is exact to a fraction of a cell; farther away, it is the
distance to the nearest occupied cell. It is positive in front of a wall, and negative behind it. The grid grows with
the scans.
"""
from typing import Dict, Optional, Tuple

import cv2
import numpy as np

from navigation_core.maps.grid_map import FREE, OCCUPIED, UNKNOWN, GridMap
from navigation_core.poses import Array, Pose
from navigation_core.scans import Scan

SHIFT = 4  # binary digits of a fraction in OpenCV's coordinates
SHORTER = 1.0  # [cells] by which the free part of a beam ends before its hit
GROWTH = 40  # [cells] by which the grid grows at least
MAX_SIDE = 4000  # [cells]
BAND = np.arange(-1.5, 1.6, 0.5)  # [cells] along the normal of a wall, where scans measure its distance
NEIGHBOURS = 4  # beams to both sides whose points give the normal
STRAIGHT = 0.4  # [m] between those points at most
FARTHEST = 0.5  # [m] larger distances count as this
MARGIN = 12  # [cells] around a scan in which distances change
SEEN = 0.3  # a cell seen less often is unknown


class CountGrid:
    """Counts of cells. ``corner`` [cells] is the column and row of cell (0, 0), counted from the frame's origin."""

    def __init__(self, resolution: float, x_min: float, y_min: float, x_max: float, y_max: float) -> None:
        """Make a grid of square cells of ``resolution`` [m] that covers the area [m]."""
        self.resolution = resolution
        self.corner = np.floor(np.array([x_min, y_min]) / resolution + 1e-6).astype(int)
        columns, rows = np.maximum(np.ceil(np.array([x_max, y_max]) / resolution - 1e-6).astype(int) - self.corner, 1)
        hits, seen, told, weights = np.zeros((4, rows, columns), np.float32)
        self._layers = {'hits': hits, 'seen': seen, 'told': told, 'weights': weights,
                        'distance': np.full((rows, columns), FARTHEST, np.float32)}

    def copy(self) -> 'CountGrid':
        other = object.__new__(CountGrid)
        other.resolution, other.corner = self.resolution, self.corner.copy()
        other._layers = {name: layer.copy() for name, layer in self._layers.items()}
        return other

    def add(self, pose: Pose, scan: Scan) -> None:
        """Count a scan that was taken at ``pose``."""
        if not len(scan.points):
            return
        ends = np.stack(pose.to_outer(scan.points[:, 0], scan.points[:, 1]), axis=1) / self.resolution
        scanner = pose.then(scan.mount)
        middle = np.array([scanner.x, scanner.y]) / self.resolution
        low = np.floor(np.minimum(ends.min(axis=0), middle)).astype(int) - MARGIN
        high = np.ceil(np.maximum(ends.max(axis=0), middle)).astype(int) + MARGIN
        self._grow(low, high)
        low = np.maximum(low, self.corner)
        high = np.minimum(high, self.corner + self._shape())
        if (low >= high).any():
            return
        (left, bottom), (right, top) = low - self.corner, high - self.corner
        window = {name: layer[bottom:top, left:right] for name, layer in self._layers.items()}
        shape = int(top - bottom), int(right - left)
        hits = np.minimum(_sums(ends[scan.hit] - low, None, shape), 1.0)
        free = _free(scan, scanner, self.resolution, low, shape)
        window['hits'] += hits
        window['seen'] += np.maximum(hits, free)
        _tell(window, ends - low, _normals(ends, scan, self.resolution), shape, self.resolution)
        window['distance'][:] = _distances(window, self.resolution)

    def distances(self, x: Array, y: Array) -> Tuple[Array, Array, Array]:
        """Return the distances [m] of points [m] from the walls, -FARTHEST to FARTHEST, and the gradient."""
        field = self._layers['distance']
        rows, columns = field.shape
        u = x / self.resolution - (self.corner[0] + 0.5)
        v = y / self.resolution - (self.corner[1] + 0.5)
        left, bottom = np.floor(u), np.floor(v)
        inside = (left >= 0) & (left < columns - 1) & (bottom >= 0) & (bottom < rows - 1)
        first = (np.where(inside, bottom, 0) * columns + np.where(inside, left, 0)).astype(int)
        flat = field.ravel()
        a, b, c, d = flat[first], flat[first + 1], flat[first + columns], flat[first + columns + 1]
        s, t = u - left, v - bottom
        lower, upper = a + s * (b - a), c + s * (d - c)
        slope = (b - a) + t * ((d - c) - (b - a))
        return (np.where(inside, lower + t * (upper - lower), FARTHEST),
                np.where(inside, slope, 0.0) / self.resolution,
                np.where(inside, upper - lower, 0.0) / self.resolution)

    def to_map(self, occupied: float) -> GridMap:
        """Return the map: cells hit in more than the share ``occupied`` of the scans that saw them are OCCUPIED."""
        hits, seen = self._layers['hits'], self._layers['seen']
        cells = np.where(seen > SEEN, np.where(hits > occupied * seen, OCCUPIED, FREE), UNKNOWN)
        x, y = self.corner * self.resolution
        return GridMap(cells, self.resolution, Pose(float(x), float(y), 0.0))

    def _shape(self) -> Array:
        return np.array(self._layers['hits'].shape[::-1])

    def _grow(self, low: Array, high: Array) -> None:
        """Add columns and rows so that [low, high) lies inside, but not beyond MAX_SIDE."""
        size = self._shape()
        before, after = (np.where(side > 0, np.maximum(side, GROWTH), 0)
                         for side in (self.corner - low, high - (self.corner + size)))
        if not before.any() and not after.any() or (size + before + after > MAX_SIDE).any():
            return
        pads = (int(before[1]), int(after[1])), (int(before[0]), int(after[0]))
        self._layers = {name: np.pad(layer, pads, constant_values=FARTHEST if name == 'distance' else 0.0)
                        for name, layer in self._layers.items()}
        self.corner = self.corner - before


def _sums(points: Array, values: Optional[Array], shape: Tuple[int, int]) -> Array:
    """Return the sums (rows, columns) of values, or the numbers, of the points [cells] in each cell."""
    cells = np.floor(points).astype(int)
    inside = ((cells >= 0) & (cells < shape[::-1])).all(axis=1)
    found = np.bincount(cells[inside, 1] * shape[1] + cells[inside, 0], None if values is None else values[inside],
                        shape[0] * shape[1])
    return found.reshape(shape).astype(np.float32)


def _free(scan: Scan, scanner: Pose, resolution: float, low: Array, shape: Tuple[int, int]) -> Array:
    """Return (rows, columns), 1 where the beams, as wide as their spacing, passed, else 0."""
    free = np.maximum(scan.ranges / resolution - SHORTER * scan.hit, 0.0)
    half = 0.5 * scan.spacing
    angles = scanner.yaw + np.stack([scan.angles - half, scan.angles + half], axis=1)
    corners = free[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=2)
    gaps = np.flatnonzero(np.diff(scan.angles) > 1.5 * scan.spacing) + 1
    corners = np.insert(corners, gaps, 0.0, axis=0).reshape(-1, 2)
    outline = np.concatenate([np.zeros((1, 2)), corners]) + np.array([scanner.x, scanner.y]) / resolution - low - 0.5
    mask = np.zeros(shape, np.uint8)
    cv2.fillPoly(mask, [np.round(outline * (1 << SHIFT)).astype(np.int32)], 1, shift=SHIFT)
    return mask.astype(np.float32)


def _normals(ends: Array, scan: Scan, resolution: float) -> Array:
    """Return the normals (beams, 2), towards the scanner, of the wall at each end [cells]; NaN if it is unknown."""
    normals = np.full(ends.shape, np.nan)
    wide = 2 * NEIGHBOURS
    if len(ends) <= wide:
        return normals
    along = ends[wide:] - ends[:-wide]
    length = np.hypot(along[:, 0], along[:, 1])
    near = scan.angles[wide:] - scan.angles[:-wide] < (wide + 0.5) * scan.spacing
    known = near & scan.hit[wide:] & scan.hit[:-wide] & (length > 1e-6) & (length < STRAIGHT / resolution)
    known &= scan.hit[NEIGHBOURS:-NEIGHBOURS]
    turned = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(length, 1e-6)[:, None]
    normals[NEIGHBOURS:-NEIGHBOURS][known] = turned[known]  # angles grow counter-clockwise: the scanner is to the left
    return normals


def _tell(window: Dict[str, Array], ends: Array, normals: Array, shape: Tuple[int, int], resolution: float) -> None:
    known = np.isfinite(normals[:, 0])
    ends, normals = ends[known], normals[known]
    points = (ends[:, None, :] + BAND[None, :, None] * normals[:, None, :]).reshape(-1, 2)
    middles = np.floor(points) + 0.5
    off = ((middles.reshape(len(ends), len(BAND), 2) - ends[:, None, :]) * normals[:, None, :]).sum(axis=2).ravel()
    window['told'] += _sums(points, off * resolution, shape)
    window['weights'] += _sums(points, None, shape)


def _distances(window: Dict[str, Array], resolution: float) -> Array:
    """Return the signed distances [m] of cells."""
    hits, seen, weights = window['hits'], window['seen'], window['weights']
    occupied = hits > 0.25 * seen
    if not occupied.any():
        return np.full(hits.shape, FARTHEST, np.float32)
    away = cv2.distanceTransform((~occupied).astype(np.uint8), cv2.DIST_L2, 3) * resolution
    away = np.where((seen > SEEN), away, -away)
    return np.asarray(np.clip(np.where(weights > 0, window['told'] / np.maximum(weights, 1.0), away),
                              -FARTHEST, FARTHEST))
