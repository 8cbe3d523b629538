"""Monte Carlo localisation: particles move with the odometry, and those that fit the scans remain."""
import math
from statistics import NormalDist
from typing import NamedTuple, Optional, Sequence

import numpy as np
from scipy import ndimage

from navigation_core.localisation.kld import entropy_limit
from navigation_core.localisation.motion import moved
from navigation_core.localisation.sensor import MeasuredMap, SensorModel, chosen, log_likelihoods, placed
from navigation_core.poses import Array, Pose, wrap
from navigation_core.scans import Scan

BIN, TURN_BIN = 0.5, math.radians(10.0)  # [m], [rad] of the bins that are counted
MAX_BINS = 2_000_000  # in the box around all particles; above that they form one cluster
TRIALS = 40  # random poses that are tried for each one that is used
TRIED_BEAMS = 20


class Settings(NamedTuple):
    """amcl's parameters."""

    min_particles: int = 100
    max_particles: int = 5000
    kld_error: float = 0.01  # (kld_err)
    kld_probability: float = 0.99  # (kld_z)
    alphas: Sequence[float] = (0.2, 0.2, 0.2, 0.2, 0.2)  # (odom_alpha1 to 5)
    motion: str = 'diff'  # (odom_model_type)
    recovery_slow: float = 0.0  # (recovery_alpha_slow)
    recovery_fast: float = 0.0  # (recovery_alpha_fast)
    resample_interval: int = 2


class Estimate(NamedTuple):
    """The pose of the most likely cluster of particles, and its covariance (3, 3) of x, y [m] and yaw [rad]."""

    pose: Pose
    covariance: Array


class ParticleFilter:
    """Poses that the robot may have. Public and read-only: ``particles`` (n, 3), ``weights`` (n,), whose sum is 1."""

    def __init__(self, measured: MeasuredMap, settings: Settings, sensor: SensorModel, seed: int = 0) -> None:
        """Begin with particles all over the free cells of the map."""
        self.measured, self._settings, self._sensor = measured, settings, sensor
        self.particles: Array = np.zeros((0, 3))
        self.weights: Array = np.zeros(0)
        self._seed, self._starts = seed, 0
        self._quantile = NormalDist().inv_cdf(settings.kld_probability)
        self.spread()

    def place(self, mean: Pose, covariance: Array) -> None:
        """Put the particles around a pose; ``covariance`` (3, 3) of x, y [m] and yaw [rad]."""
        spread = np.asarray(covariance, dtype=float)
        self._begin()
        self._set(self._random.multivariate_normal(mean, 0.5 * (spread + spread.T), self._settings.max_particles,
                                                   check_valid='ignore'))
        self._lost = False

    def spread(self) -> None:
        """Put the particles all over the free cells: the robot may be anywhere."""
        self._begin()
        self._set(self._anywhere(self._settings.max_particles))
        self._lost = True

    def _begin(self) -> None:
        """Draw other random numbers than before, which do not depend on the number of scans until now."""
        self._starts += 1
        self._random = np.random.default_rng([self._seed, self._starts])

    def update(self, step: Pose, scan: Scan) -> None:
        """Take a scan, and the new pose of the odometry in the frame of the last scan's.

        The first scan after ``place`` or ``spread`` only gives weights: one view does not say where a robot is.
        """
        if self._lost and self._updates:  # poses that fit a scan help more than thousands of random ones
            self._set(self._anywhere_like(scan, self._settings.max_particles))
            self._lost = False
        self.particles = moved(self.particles, step, self._settings.alphas, self._settings.motion, self._random)
        logs = np.log(np.maximum(self.weights, 1e-300)) + log_likelihoods(self.measured, self.particles, scan,
                                                                         self._sensor)
        weights = np.exp(logs - logs.max())
        self.weights = weights / weights.sum()
        self._note_fit(scan)
        self._updates += 1
        if self._updates % self._settings.resample_interval == 0:
            self._resample(scan)

    def estimate(self) -> Estimate:
        cluster = self._clusters()
        heaviest = np.argmax(np.bincount(cluster, self.weights))
        inside = cluster == heaviest
        poses, weights = self.particles[inside], self.weights[inside] / self.weights[inside].sum()
        x, y = weights @ poses[:, 0], weights @ poses[:, 1]
        yaw = math.atan2(weights @ np.sin(poses[:, 2]), weights @ np.cos(poses[:, 2]))
        off = np.stack([poses[:, 0] - x, poses[:, 1] - y, wrap(poses[:, 2] - yaw)], axis=1)
        return Estimate(Pose(float(x), float(y), yaw), (off * weights[:, None]).T @ off)

    def _set(self, particles: Array) -> None:
        self.particles = particles
        self.weights = np.full(len(particles), 1.0 / len(particles))
        self._slow = self._fast = 0.0
        self._updates = 0

    def _anywhere(self, number: int) -> Array:
        free = self.measured.free[self._random.integers(0, len(self.measured.free), number)]
        half = 0.5 * self.measured.grid.resolution
        return np.concatenate([free + self._random.uniform(-half, half, free.shape),
                               self._random.uniform(-math.pi, math.pi, (number, 1))], axis=1)

    def _anywhere_like(self, scan: Scan, number: int) -> Array:
        """Return random poses at which the scan fits, of TRIALS times as many."""
        guesses = self._anywhere(min(TRIALS * number, 50_000))
        logs = log_likelihoods(self.measured, guesses, scan, self._sensor._replace(beams=TRIED_BEAMS))
        weights = np.exp(logs - logs.max())
        return guesses[self._random.choice(len(guesses), number, p=weights / weights.sum())]

    def _note_fit(self, scan: Scan) -> None:
        """Average how well the scans fit, slowly and fast: if the fast mean is worse, the robot seems lost."""
        points = chosen(scan, self._sensor.beams)[0]
        if not len(points):
            return
        mean = self.particles[np.argsort(-self.weights)[:20]]
        off = self.measured.distances(*placed(mean, points))
        fit = float(np.exp(-0.5 * np.square(off / self._sensor.sigma_hit)).mean())
        self._slow += (self._settings.recovery_slow if self._slow else 1.0) * (fit - self._slow)
        self._fast += (self._settings.recovery_fast if self._fast else 1.0) * (fit - self._fast)

    def _resample(self, scan: Scan) -> None:
        """Draw as many particles by weight as their bins need; if the robot seems lost, add random ones."""
        most = self._settings.max_particles
        drawn = self._random.choice(len(self.particles), most, p=self.weights)
        particles = self.particles[drawn]
        lost = max(0.0, 1.0 - self._fast / self._slow) if self._slow > 0.0 else 0.0
        new = self._random.uniform(size=most) < lost
        if new.any():
            particles[new] = self._anywhere_like(scan, int(new.sum()))
        first = np.zeros(most, bool)
        first[np.unique(self._bins(particles), axis=0, return_index=True)[1]] = True
        needed = entropy_limit(np.cumsum(first), self._settings.kld_error, self._quantile)
        enough = np.flatnonzero(np.arange(1, most + 1) >= np.maximum(needed, self._settings.min_particles))
        particles = particles[:int(enough[0]) + 1] if len(enough) else particles
        self.particles = particles
        self.weights = np.full(len(particles), 1.0 / len(particles))

    def _bins(self, particles: Array) -> Array:
        return np.floor(particles / (BIN, BIN, TURN_BIN)).astype(np.int64)

    def _clusters(self) -> Array:
        """Return the number of the cluster of each particle; neighbouring bins belong to one."""
        bins = self._bins(self.particles)
        bins -= bins.min(axis=0)
        shape = bins.max(axis=0) + 1
        if int(shape[0]) * int(shape[1]) * int(shape[2]) > MAX_BINS:
            return np.zeros(len(bins), np.int64)
        filled = np.zeros(shape, bool)
        filled[tuple(bins.T)] = True
        labels: Optional[Array] = ndimage.label(filled, np.ones((3, 3, 3)))[0]
        assert labels is not None
        found = labels[tuple(bins.T)]
        if shape[2] == round(2.0 * math.pi / TURN_BIN):  # -pi and pi are neighbours
            for low, high in zip(*np.nonzero(labels[:, :, 0] * labels[:, :, -1])):
                found[found == labels[low, high, -1]] = labels[low, high, 0]
        return np.asarray(found)
