"""Mapping while driving: one map if the scanner covers all directions, else particles that each have a map.

A scanner that covers all directions sees enough walls, so matching alone finds each pose. In a camera's 90 degrees, a
direction often stays open; then each particle keeps its own pose, and those that fit when the robot returns survive.
"""
import math
from typing import List, NamedTuple, Optional, Tuple

import numpy as np

from navigation_core.maps.grid_map import GridMap
from navigation_core.poses import Array, Pose, wrap
from navigation_core.scans import Scan
from navigation_core.slam.count_grid import CountGrid
from navigation_core.slam.matching import Match, beam_distances, match, thinned

ALL_AROUND = math.pi  # [rad] a scan that covers more needs no particles
TRUST = 2.0  # weight of one scan in the resampling, in independent beams per radian
OUTLIERS = 0.1  # share of beams that may end anywhere
LEAST = np.array([0.02, 0.02, 0.02])  # [m, m, rad] added to the deviations of the odometry
SPREAD = 0.5  # of the particles, in deviations of the odometry: their increments are matched already
FITS = 0.08  # [m] standard deviation of a beam's end, for the resampling


class Settings(NamedTuple):
    """What the user chooses; the names in brackets are gmapping's parameters."""

    resolution: float = 0.05  # [m] (delta)
    area: Tuple[float, float, float, float] = (-10.0, -10.0, 10.0, 10.0)  # [m] (xmin, ymin, xmax, ymax), grows
    particles: int = 30
    linear_update: float = 1.0  # [m] (linearUpdate)
    angular_update: float = 0.5  # [rad] (angularUpdate)
    temporal_update: float = -1.0  # [s] (temporalUpdate); negative: never
    resample_threshold: float = 0.5  # (resampleThreshold)
    minimum_score: float = 0.0  # (minimumScore), a sum over all beams
    distance_by_distance: float = 0.1  # (srr) error of the odometry: [m/m]
    distance_by_turn: float = 0.2  # (srt) [m/rad]
    turn_by_distance: float = 0.1  # (str) [rad/m]
    turn_by_turn: float = 0.2  # (stt) [rad/rad]


class _Particle:
    """One hypothesis: the pose of the robot, and the map that follows from its path."""

    def __init__(self, pose: Pose, grid: CountGrid, total: float = 0.0) -> None:
        self.pose, self.grid = pose, grid
        self.total = total  # logarithm of the weight since the start
        self.weight = 0.0  # the same since the last resampling

    def copy(self) -> '_Particle':
        return _Particle(self.pose, self.grid.copy(), self.total)


class Mapper:
    """Makes a map from odometry and scans. Public and read-only: ``pose``, in the map's frame, and ``updates``."""

    def __init__(self, settings: Settings, start: Optional[Pose] = None, seed: int = 0) -> None:
        """Begin with an empty map; the robot is at ``start`` in the map's frame, by default where the odometry begins.
        """
        self.settings = settings
        self._start = start
        self.pose = start or Pose()
        self.updates = 0
        self._random = np.random.default_rng(seed)
        self._particles = [_Particle(self.pose, CountGrid(settings.resolution, *settings.area))]
        self._odometry: Optional[Pose] = None  # of the last scan
        self._added_at = self.pose  # the tracked pose of the last scan that the maps contain
        self._added_time = 0.0

    def process(self, odometry: Pose, scan: Scan, time: float) -> bool:
        """Take a scan and the odometry's pose at the same ``time`` [s]; return whether the map has changed."""
        if self._odometry is None and self._start is None:
            self.pose = self._particles[0].pose = odometry
        if not len(scan.points):
            return False
        if self._odometry is None:
            self._add_first(scan)
        else:
            self._track(self._odometry.step_to(odometry), scan)
        self._odometry = odometry
        moved = self._added_at.step_to(self.pose)
        waited = 0.0 <= self.settings.temporal_update <= time - self._added_time
        if self.updates and not waited and math.hypot(moved.x, moved.y) < self.settings.linear_update \
                and abs(moved.yaw) < self.settings.angular_update:
            return False
        if self.updates:
            self._update(moved, scan)
        self.updates += 1
        self._added_at, self._added_time = self.pose, time
        return True

    def to_map(self, occupied: float = 0.25) -> GridMap:
        """Return the map of the best particle; ``occupied`` is (occ_thresh)."""
        return self._best().grid.to_map(occupied)

    def entropy(self) -> float:
        """Return the entropy of the particles' weights: 0 if one is certain, log(particles) if all are equal."""
        weights = self._weights()
        return float(-(weights * np.log(np.maximum(weights, 1e-300))).sum())

    def _best(self) -> _Particle:
        return max(self._particles, key=lambda particle: particle.total)

    def _weights(self) -> Array:
        logs = np.array([particle.weight for particle in self._particles])
        weights: Array = np.exp(logs - logs.max())
        return np.asarray(weights / weights.sum())

    def _add_first(self, scan: Scan) -> None:
        covered = len(scan.angles) * scan.spacing
        number = 1 if covered > ALL_AROUND else self.settings.particles
        self._particles[0].grid.add(self.pose, scan)
        self._particles += [self._particles[0].copy() for _ in range(number - 1)]

    def _track(self, step: Pose, scan: Scan) -> None:
        """Follow the robot in the best map."""
        expected = self.pose.then(step)
        if math.hypot(step.x, step.y) < 1e-5 and abs(step.yaw) < 1e-5:
            self.pose = expected
            return
        self.pose = self._matched(self._best().grid, scan, expected, step).pose

    def _deviations(self, step: Pose) -> Array:
        """Return the standard deviations of x, y [m] and yaw [rad] that the odometry has after a step."""
        way, turn = math.hypot(step.x, step.y), abs(step.yaw)
        chosen = self.settings
        along = chosen.distance_by_distance * way + chosen.distance_by_turn * turn
        return np.array([along, along, chosen.turn_by_distance * way + chosen.turn_by_turn * turn])

    def _matched(self, grid: CountGrid, scan: Scan, expected: Pose, step: Pose) -> Match:
        points = thinned(scan)
        found = match(grid, points, expected, self._deviations(step) + LEAST)
        if found.score * scan.hit.sum() < self.settings.minimum_score:
            return Match(expected, found.score)
        return found

    def _update(self, moved: Pose, scan: Scan) -> None:
        """Let each particle follow, and add the scan to its map."""
        best, several = self._best(), len(self._particles) > 1
        for particle in self._particles:
            if not several:
                particle.pose = self.pose
            else:
                spread = SPREAD * self._random.normal(0.0, 1.0, 3) * self._deviations(moved) * (particle is not best)
                guess = particle.pose.then(moved)
                guess = Pose(guess.x + spread[0], guess.y + spread[1], float(wrap(guess.yaw + spread[2])))
                particle.pose = self._matched(particle.grid, scan, guess, moved).pose
                gained = self._likelihood(particle, scan)
                particle.weight += gained
                particle.total += gained
            particle.grid.add(particle.pose, scan)
        if several:
            self._choose()
            self.pose = self._best().pose

    def _likelihood(self, particle: _Particle, scan: Scan) -> float:
        points = thinned(scan)
        if not len(points):
            return 0.0
        off = beam_distances(particle.grid, points, particle.pose)
        fit = np.log(OUTLIERS + (1.0 - OUTLIERS) * np.exp(-0.5 * np.square(off / FITS))).mean()
        return float(TRUST * len(scan.angles) * scan.spacing * fit)

    def _choose(self) -> None:
        """Resample the particles by their weights when few of them have most of the weight."""
        weights, number = self._weights(), len(self._particles)
        if 1.0 / np.square(weights).sum() > self.settings.resample_threshold * number:
            return
        chosen = drawn(weights, number, float(self._random.uniform()))
        old, seen = self._particles, set()
        self._particles = []
        for index in chosen:
            particle = old[index].copy() if index in seen else old[index]
            seen.add(index)
            particle.weight = 0.0
            self._particles.append(particle)


def drawn(weights: Array, number: int, offset: float) -> List[int]:
    """Return ``number`` indices, drawn by weight with low-variance sampling; ``offset`` in [0, 1)."""
    steps = (np.arange(number) + offset) / number
    found = np.searchsorted(np.cumsum(weights), steps * weights.sum())
    return [int(index) for index in np.minimum(found, len(weights) - 1)]
