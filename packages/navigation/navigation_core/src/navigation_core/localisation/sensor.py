"""How well a scan fits a map at many poses: the likelihood field and the beam model."""
from typing import NamedTuple, Tuple

import cv2
import numpy as np

from navigation_core.maps.grid_map import FREE, OCCUPIED, GridMap
from navigation_core.poses import Array, Numbers
from navigation_core.scans import Scan

FIELD, FIELD_PROB, BEAM = MODELS = 'likelihood_field', 'likelihood_field_prob', 'beam'
SMALLEST = 1e-12  # likelihood of a beam
MARCH_STEPS = 30  # of a ray, each as long as the distance to the nearest wall


class SensorModel(NamedTuple):
    """amcl's parameters laser_*."""

    model: str = FIELD
    beams: int = 30  # of a scan that count
    z_hit: float = 0.95
    z_short: float = 0.1  # only of the beam model, as is z_max
    z_max: float = 0.05
    z_rand: float = 0.05
    sigma_hit: float = 0.2  # [m]
    lambda_short: float = 0.1  # [1/m]
    max_distance: float = 2.0  # [m] larger distances from a wall count as this
    max_range: float = 30.0  # [m]


class MeasuredMap:
    """A GridMap with the distance of each cell to the nearest wall. ``free`` (n, 2) [m]: middles of its free cells."""

    def __init__(self, grid: GridMap, max_distance: float) -> None:
        """Measure the distances up to ``max_distance`` [m]; ValueError if no cell of the map is free."""
        self.grid = grid
        walls = grid.cells == OCCUPIED
        distances = np.full(grid.cells.shape, max_distance, np.float32)
        if walls.any():
            away = cv2.distanceTransform((~walls).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            distances = np.minimum(away * grid.resolution, max_distance).astype(np.float32)
        self._distances, self._farthest = distances, max_distance
        rows, columns = np.nonzero(grid.cells == FREE)
        if not len(rows):
            raise ValueError('no cell of it is free')
        self.free = np.stack(grid.to_world(columns, rows), axis=1)

    def distances(self, x: Array, y: Array) -> Array:
        """Return the distances [m] of points [m] to the nearest wall; outside of the map, the largest one."""
        columns, rows = self.grid.to_cell(x, y)
        inside = self.grid.contains(columns, rows)
        found = self._distances[np.where(inside, rows, 0), np.where(inside, columns, 0)]
        return np.where(inside, found, self._farthest)


def chosen(scan: Scan, beams: int) -> Tuple[Array, Array, Array]:
    """Return points (n, 2) [m] on the robot, angles and ranges of at most ``beams`` beams that hit, evenly chosen."""
    index = np.flatnonzero(scan.hit)
    if len(index):
        index = index[np.unique(np.linspace(0, len(index) - 1, min(beams, len(index))).astype(int))]
    return scan.points[index], scan.angles[index], scan.ranges[index]


def log_likelihoods(measured: MeasuredMap, particles: Array, scan: Scan, sensor: SensorModel) -> Array:
    """Return the logarithm of the likelihood of the scan's chosen beams at each pose (n, 3)."""
    points, angles, ranges = chosen(scan, sensor.beams)
    if not len(points):
        return np.zeros(len(particles))
    if sensor.model == BEAM:
        likely = _beams(measured, particles, scan, angles, ranges, sensor)
    else:
        off = measured.distances(*placed(particles, points))
        likely = sensor.z_hit * np.exp(-0.5 * np.square(off / sensor.sigma_hit)) + sensor.z_rand / sensor.max_range
    total: Array = np.log(np.maximum(likely, SMALLEST)).sum(axis=1)
    return total


def placed(particles: Array, points: Array) -> Tuple[Array, Array]:
    """Return x, y (n, points) [m] in the map of points on the robot, at each pose."""
    cos, sin = np.cos(particles[:, 2:3]), np.sin(particles[:, 2:3])
    return (particles[:, 0:1] + cos * points[:, 0] - sin * points[:, 1],
            particles[:, 1:2] + sin * points[:, 0] + cos * points[:, 1])


def _beams(measured: MeasuredMap, particles: Array, scan: Scan, angles: Array, ranges: Array,
           sensor: SensorModel) -> Array:
    x, y = placed(particles, np.array([[scan.mount.x, scan.mount.y]]))
    expected = cast(measured, x, y, particles[:, 2:3] + scan.mount.yaw + angles, sensor.max_range)
    off = ranges - expected
    likely = sensor.z_hit * np.exp(-0.5 * np.square(off / sensor.sigma_hit)) + sensor.z_rand / sensor.max_range
    shorter = sensor.z_short * sensor.lambda_short * np.exp(-sensor.lambda_short * ranges)
    likely = likely + np.where(off < 0.0, shorter, 0.0) + np.where(ranges >= sensor.max_range, sensor.z_max, 0.0)
    return np.asarray(likely)


def cast(measured: MeasuredMap, x: Numbers, y: Numbers, angles: Array, farthest: float) -> Array:
    """Return the lengths [m] of rays to the walls, at most ``farthest``; each step is as long as the free distance."""
    cos, sin = np.cos(angles), np.sin(angles)
    length = np.zeros(angles.shape)
    smallest = 0.5 * measured.grid.resolution
    for _ in range(MARCH_STEPS):
        away = measured.distances(x + length * cos, y + length * sin)
        step = np.where(away > 0.0, np.maximum(away - smallest, smallest), 0.0)
        if not step.any():
            break
        length = np.minimum(length + step, farthest)
    return length
