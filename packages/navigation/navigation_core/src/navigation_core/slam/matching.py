"""Find the pose at which a scan fits a map: Gauss-Newton on distances to walls, with the expected pose as prior."""
import math
from typing import List, NamedTuple, Sequence

import numpy as np

from navigation_core.poses import Array, Pose, wrap
from navigation_core.scans import Scan
from navigation_core.slam.count_grid import CountGrid

BEAMS = 180  # that are matched at most, evenly chosen
STEPS = 10  # at most
NEAR = 2e-4  # [m, rad] a step this short is the last
FARTHEST_STEP = 0.1  # [m, rad] of one step
ERROR = 0.03  # [m] a beam's distance from a wall, standard deviation
INDEPENDENT = 0.2  # share of the beams that count: neighbours hit the same wall
FITS = 0.05  # [m] standard deviation of the score
SURE = 0.8  # the score below which other poses around the expected one are tried
BETTER = 0.1  # by which the score of another pose must be higher
LOOSER = 10.0  # times the variance of the expected pose, for these
MOVES = np.linspace(-0.2, 0.2, 5)  # [m] of the search
TURNS = np.linspace(-0.5, 0.5, 11)  # [rad] of the search
SEARCHED, STARTS = 40, 3  # beams of the search, and poses that are refined


class Match(NamedTuple):
    """Where a scan fits: ``score`` is between 0, no beam ends at a wall, and 1, all do."""

    pose: Pose
    score: float


def thinned(scan: Scan, beams: int = BEAMS) -> Array:
    """Return (n, 2) points [m] that the scan hit, at most ``beams``."""
    points = scan.points[scan.hit]
    return np.asarray(points[::max(1, math.ceil(len(points) / beams))])


def match(grid: CountGrid, points: Array, expected: Pose, deviations: Sequence[float]) -> Match:
    """Return where points (n, 2) [m] of a scan fit the grid, near ``expected``.

    ``deviations`` (x, y [m], yaw [rad]) are the standard deviations of the expected pose, in the grid's frame: it
    decides where walls give no information, such as along a corridor.
    """
    prior = 1.0 / np.square(np.maximum(deviations, 1e-3))
    found = _refined(grid, points, expected, prior, expected)
    if found.score < SURE and len(points):
        for start in _starts(grid, points, expected):
            other = _refined(grid, points, start, prior / LOOSER, expected)
            if other.score > found.score + BETTER:
                found = other
    return found


def _refined(grid: CountGrid, points: Array, start: Pose, prior: Array, expected: Pose) -> Match:
    """Return the nearest local optimum."""
    pose = np.array(start)
    for _ in range(STEPS):
        step = _step(grid, points, pose, prior, expected)
        pose = pose + step
        if np.abs(step).max() < NEAR:
            break
    found = Pose(float(pose[0]), float(pose[1]), float(wrap(pose[2])))
    return Match(found, score(grid, points, found))


def _starts(grid: CountGrid, points: Array, expected: Pose) -> List[Pose]:
    """Return the poses around the expected one that fit best, of a coarse search."""
    points = points[::max(1, len(points) // SEARCHED)]
    yaws, x, y = (each.ravel() for each in np.meshgrid(expected.yaw + TURNS, expected.x + MOVES, expected.y + MOVES,
                                                      indexing='ij'))
    cos, sin = np.cos(yaws)[:, None], np.sin(yaws)[:, None]
    off = grid.distances(x[:, None] + cos * points[:, 0] - sin * points[:, 1],
                         y[:, None] + sin * points[:, 0] + cos * points[:, 1])[0]
    scores = np.exp(-0.5 * np.square(off / (2.0 * FITS))).mean(axis=1)
    return [Pose(float(x[best]), float(y[best]), float(yaws[best])) for best in np.argsort(-scores)[:STARTS]]


def score(grid: CountGrid, points: Array, pose: Pose) -> float:
    """Return how well points of a scan that is taken at ``pose`` fit the grid, as in Match."""
    return float(np.exp(-0.5 * np.square(beam_distances(grid, points, pose) / FITS)).mean()) if len(points) else 0.0


def beam_distances(grid: CountGrid, points: Array, pose: Pose) -> Array:
    """Return the distances [m] from the walls of points of a scan that is taken at ``pose``."""
    return grid.distances(*pose.to_outer(points[:, 0], points[:, 1]))[0]


def _step(grid: CountGrid, points: Array, pose: Array, prior: Array, expected: Pose) -> Array:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    turned_x, turned_y = cos * points[:, 0] - sin * points[:, 1], sin * points[:, 0] + cos * points[:, 1]
    off, slope_x, slope_y = grid.distances(pose[0] + turned_x, pose[1] + turned_y)
    slopes = np.stack([slope_x, slope_y, slope_y * turned_x - slope_x * turned_y], axis=1)
    weights = INDEPENDENT / (ERROR * ERROR + off * off)  # Cauchy weights: distant points may not be mapped yet
    missing = np.array([expected.x - pose[0], expected.y - pose[1], wrap(expected.yaw - pose[2])])
    weighted = slopes * weights[:, None]
    step = np.linalg.solve(weighted.T @ slopes + np.diag(prior), prior * missing - weighted.T @ off)
    return np.asarray(step * min(1.0, FARTHEST_STEP / max(float(np.abs(step).max()), 1e-9)))
