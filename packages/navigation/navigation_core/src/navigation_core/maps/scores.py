"""How good a map is: its comparison with the true walls.

Walls are polygons [m] in the frame of the world. A map has a frame of its own, so it is first aligned: moved to where
its occupied cells fit the walls best. ``scores`` returns this alignment, too.
"""
from typing import NamedTuple, Sequence, Tuple

import cv2
import numpy as np
from scipy.optimize import minimize

from navigation_core.maps.grid_map import FREE, OCCUPIED, GridMap
from navigation_core.poses import ORIGIN, Array, Pose

Polygon = Sequence[Tuple[float, float]]
FINE = 0.01  # [m] cells of the true map
BORDER = 1.0  # [m] around the true walls
NEAR_CELLS = 1.5  # an occupied cell is right if a true wall is this near [cells], and a wall found likewise
FARTHEST = 0.5  # [m] larger distances count as this in the alignment
POINTS = 2000  # occupied cells that are used for this
SHIFTS = np.linspace(-0.6, 0.6, 7)  # [m] of the coarse search
TURNS = np.radians(np.linspace(-20.0, 20.0, 9))  # [rad] of the coarse search
CUT = 0.75  # [cells] from a wall's surface: the wall may cut cells that are nearer
SAMPLE = 3  # every third cell of the true map is compared


class MapScores(NamedTuple):
    """Shares between 0 and 1."""

    right: float  # of the occupied cells: those near a true wall
    found: float  # of the true walls' visible outline: where an occupied cell is near
    iou: float  # of the free area inside the walls, without cells that a wall's surface cuts: intersection by union
    alignment: Pose  # of the map's frame in the world


def true_map(walls: Sequence[Polygon], resolution: float = FINE) -> GridMap:
    """Return the map in which the walls are OCCUPIED and all else is FREE, BORDER around them."""
    corners = np.array([corner for wall in walls for corner in wall], float)
    low, high = corners.min(axis=0) - BORDER, corners.max(axis=0) + BORDER
    columns, rows = (int(side) for side in np.ceil((high - low) / resolution))
    cells = np.full((rows, columns), FREE, np.uint8)
    for wall in walls:
        outline = np.round(((np.array(wall, float) - low) / resolution - 0.5) * 16).astype(np.int32)
        cv2.fillPoly(cells, [outline], OCCUPIED, shift=4)
    return GridMap(cells.astype(np.int8), resolution, Pose(float(low[0]), float(low[1])))


def scores(grid: GridMap, walls: Sequence[Polygon], start: Tuple[float, float], guess: Pose = ORIGIN) -> MapScores:
    """Return the MapScores of a map.

    ``start`` (x, y) [m] in the world is a place where the robot was: only the area connected with it, within the
    rectangle around all walls, counts as free. ``guess`` is the approximate pose of the map's frame in the world. Raise
    ValueError if the map has no occupied cell.
    """
    rows, columns = np.nonzero(grid.cells == OCCUPIED)
    if not len(rows):
        raise ValueError('the map has no occupied cell')
    truth = true_map(walls)
    away = _distances(truth.cells == OCCUPIED) * truth.resolution
    points = np.stack(grid.to_world(columns, rows), axis=1)
    alignment = _aligned(points, away, truth, guess)
    near = NEAR_CELLS * grid.resolution
    right = float((_values(away, truth, *alignment.to_outer(points[:, 0], points[:, 1])) <= near).mean())
    inside = _area(truth, start)
    outline = _outline(truth, inside)
    x, y = truth.to_world(outline[1], outline[0])
    occupied_away = _distances(grid.cells == OCCUPIED) * grid.resolution
    found = float((_values(occupied_away, grid, *alignment.to_inner(x, y)) <= near).mean())
    return MapScores(right, found, _iou(grid, truth, inside, away, alignment), alignment)


def _iou(grid: GridMap, truth: GridMap, inside: Array, away: Array, alignment: Pose) -> float:
    rows, columns = np.nonzero(_rectangle(truth) & ~(inside & (away <= CUT * grid.resolution)))
    sample = slice(None, None, SAMPLE)
    rows, columns = rows[sample], columns[sample]
    x, y = alignment.to_inner(*truth.to_world(columns, rows))
    free, really = grid.values(*grid.to_cell(x, y)) == FREE, inside[rows, columns]
    return float((free & really).sum() / max((free | really).sum(), 1))


def _distances(walls: Array) -> Array:
    if not walls.any():
        return np.full(walls.shape, np.inf, np.float32)
    return np.asarray(cv2.distanceTransform((~walls).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE))


def _values(layer: Array, grid: GridMap, x: Array, y: Array) -> Array:
    """Return the values of a layer of a map's shape at points [m]; outside, infinity."""
    columns, rows = grid.to_cell(x, y)
    inside = grid.contains(columns, rows)
    return np.where(inside, layer[np.where(inside, rows, 0), np.where(inside, columns, 0)], np.inf)


def _aligned(points: Array, away: Array, truth: GridMap, guess: Pose) -> Pose:
    """Return the pose of the map's frame at which the points lie nearest to the walls: coarse search, then simplex."""
    points = points[::max(1, len(points) // POINTS)]

    def cost(pose: Sequence[float], every: int = 1) -> float:
        x, y = Pose(*pose).to_outer(points[::every, 0], points[::every, 1])
        return float(np.minimum(_values(away, truth, x, y), FARTHEST).mean())
    middle = points.mean(axis=0)
    starts = []
    for turn in TURNS:  # about the middle of the map, so that turns and shifts do not depend on its frame
        turned = Pose(guess.x, guess.y, guess.yaw + turn)
        before, after = guess.to_outer(*middle), turned.to_outer(*middle)
        starts += [(turned.x + before[0] - after[0] + x, turned.y + before[1] - after[1] + y, turned.yaw)
                   for x in SHIFTS for y in SHIFTS]
    found = min(starts, key=lambda pose: cost(pose, 5))
    for size in (0.1, 0.02):
        simplex = np.array([found, *(np.array(found) + size * row for row in np.eye(3))])
        found = minimize(cost, found, method='Nelder-Mead',
                         options={'initial_simplex': simplex, 'xatol': 1e-4, 'fatol': 1e-6}).x
    return Pose(*(float(value) for value in found))


def _rectangle(truth: GridMap) -> Array:
    """Return which cells lie in the rectangle around all walls."""
    rows, columns = np.nonzero(truth.cells == OCCUPIED)
    inside = np.zeros(truth.cells.shape, bool)
    inside[rows.min():rows.max() + 1, columns.min():columns.max() + 1] = True
    return inside


def _area(truth: GridMap, start: Tuple[float, float]) -> Array:
    """Return which cells are free and connected with ``start`` within the rectangle around all walls."""
    free = (truth.cells == FREE) & _rectangle(truth)
    labels = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)[1]
    column, row = truth.to_cell(*start)
    if not truth.contains(column, row) or not free[row, column]:
        raise ValueError(f'the start at {start} is not a free place between the walls')
    return np.asarray(labels == labels[row, column])


def _outline(truth: GridMap, inside: Array) -> Tuple[Array, Array]:
    """Return rows and columns of the wall cells that border on the area."""
    beside = cv2.dilate(inside.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    rows, columns = np.nonzero(beside & (truth.cells == OCCUPIED))
    return rows, columns
