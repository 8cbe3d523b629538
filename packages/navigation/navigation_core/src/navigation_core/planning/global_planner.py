"""The cheapest path through a costmap, as navfn plans it."""
import math
from typing import List, NamedTuple, Optional, Tuple

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from navigation_core.planning.costmap import INSCRIBED, UNKNOWN, Costmap
from navigation_core.poses import Array

NEUTRAL = 50.0  # cost of a step through a free cell, and
FACTOR = 0.8  # of each unit of cost: those of navfn
MARGIN = 20  # cells that may be used around the known part of a map
STEPS = [(1, 0), (0, 1), (1, 1), (-1, 1), (2, 1), (1, 2), (-1, 2), (-2, 1)]  # (columns, rows); the others by symmetry
Point = Tuple[float, float]


class Plan(NamedTuple):
    """A path (n, 2) [m] from start to goal; or None, and the reason."""

    path: Optional[Array]
    problem: str = ''


def plan(costmap: Costmap, start: Point, goal: Point, tolerance: float = 0.0, allow_unknown: bool = True) -> Plan:
    """Return the Plan between two points [m]; it may end at most ``tolerance`` [m] beside the goal.

    The robot's middle avoids cells of the cost INSCRIBED or more; a robot that stands on one, because it was driven
    against a wall, may take the shortest way out. The start's own cell is not tested.
    """
    ends: List[Tuple[int, int]] = []
    for name, (x, y) in (('start', start), ('goal', goal)):
        if not costmap.inside(*costmap.cells(np.array(x), np.array(y))):
            height, width = costmap.shape
            return Plan(None, f'the {name} ({x:.2f}, {y:.2f}) is outside of the map, which has x from {costmap.x:.2f} '
                              f'to {costmap.x + width * costmap.resolution:.2f} m and y from {costmap.y:.2f} to '
                              f'{costmap.y + height * costmap.resolution:.2f} m')
        column, row = costmap.cells(np.array(x), np.array(y))
        ends.append((int(row), int(column)))
    (top, left), costs = _part(costmap, ends)
    ends = [(row - top, column - left) for row, column in ends]
    weights = NEUTRAL + FACTOR * costs.astype(np.float32)
    weights[costs >= INSCRIBED] = np.inf
    unknown = costs == UNKNOWN
    weights[unknown] = NEUTRAL + FACTOR * (INSCRIBED - 1) if allow_unknown else np.inf
    goals = _near(weights, ends[1], tolerance / costmap.resolution)
    if not len(goals):
        kind = 'an unknown cell' if unknown[ends[1]] else 'an obstacle, or closer to one than the radius of the robot'
        return Plan(None, f'the goal ({goal[0]:.2f}, {goal[1]:.2f}) is in {kind}')
    if costs[ends[0]] >= INSCRIBED:
        weights[_way_out(costs, ends[0])] = NEUTRAL + FACTOR * INSCRIBED
    weights[ends[0]] = min(weights[ends[0]], NEUTRAL + FACTOR * INSCRIBED)
    cells = _cheapest(weights, ends[0], goals)
    if cells is None:
        return Plan(None, f'there is no free path from ({start[0]:.2f}, {start[1]:.2f}) to ({goal[0]:.2f}, '
                          f'{goal[1]:.2f})')
    path = np.stack(costmap.points(cells[:, 1] + left, cells[:, 0] + top), axis=1)
    path[0] = start
    if tuple(cells[-1]) == ends[1]:
        path[-1] = goal
    return Plan(path)


def length(path: Array) -> float:
    """Return the length [m] of a path."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def _way_out(costs: Array, start: Tuple[int, int]) -> Array:
    """Return the mask of cells without an obstacle that are at most as far from ``start`` as the nearest free one."""
    rows, columns = np.indices(costs.shape)
    away = np.hypot(rows - start[0], columns - start[1])
    nearest = away[costs < INSCRIBED].min(initial=np.inf)
    result: Array = (costs == INSCRIBED) & (away <= nearest + 1.5)
    return result


def _part(costmap: Costmap, ends: List[Tuple[int, int]]) -> Tuple[Tuple[int, int], Array]:
    """Return the part of the costs that paths may use, and its first row and column: known cells and both ends."""
    known = costmap.costs != UNKNOWN
    bounds = []
    for axis in (0, 1):
        used = np.flatnonzero(known.any(axis=1 - axis))
        places = [int(place) for place in used[[0, -1]]] if used.size else []
        places += [end[axis] for end in ends]
        bounds.append((max(min(places) - MARGIN, 0), max(places) + MARGIN + 1))
    (top, bottom), (left, right) = bounds
    return (top, left), costmap.costs[top:bottom, left:right]


def _near(weights: Array, cell: Tuple[int, int], radius: float) -> Array:
    """Return the cells (n, 2) that can be used within ``radius`` [cells] of one, the nearest first."""
    reach = math.ceil(radius)
    rows, columns = np.mgrid[max(cell[0] - reach, 0):min(cell[0] + reach + 1, weights.shape[0]),
                             max(cell[1] - reach, 0):min(cell[1] + reach + 1, weights.shape[1])].reshape(2, -1)
    away = np.hypot(rows - cell[0], columns - cell[1])
    near = (away <= max(radius, 0.0)) & np.isfinite(weights[rows, columns])
    order = np.argsort(away[near], kind='stable')
    result: Array = np.stack([rows[near], columns[near]], axis=1)[order]
    return result


def _cheapest(weights: Array, start: Tuple[int, int], goals: Array) -> Optional[Array]:
    """Return the cells (n, 2) of the cheapest path to the first of ``goals`` that can be reached; None if none can."""
    if tuple(goals[0]) == start:
        return goals[:1]  # spares the search, in each period in which move_base asks whether a goal is hopeless
    width = weights.shape[1]
    numbers = np.arange(weights.size, dtype=np.int32).reshape(weights.shape)
    graph = _graph(weights, numbers)
    first = int(numbers[start])
    costs, before = dijkstra(graph, directed=False, indices=first, return_predecessors=True)
    reached = [number for number in numbers[goals[:, 0], goals[:, 1]] if np.isfinite(costs[number])]
    if not reached:
        return None
    path = [int(reached[0])]
    while path[-1] != first:
        path.append(int(before[path[-1]]))
    return np.stack(np.divmod(np.array(path[::-1]), width), axis=1)


def _graph(weights: Array, numbers: Array) -> csr_matrix:
    """Return the graph of the steps between cells that can be used; each step once."""
    height, width = weights.shape
    starts, ends, costs = [], [], []
    for columns, rows in STEPS:
        here = slice(0, height - rows), slice(max(-columns, 0), width - max(columns, 0))
        there = slice(rows, height), slice(max(columns, 0), width - max(-columns, 0))
        cost = (weights[here] + weights[there]) * (0.5 * math.hypot(columns, rows))
        usable = np.isfinite(cost)
        for between in _between(weights, columns, rows):
            usable &= np.isfinite(between)
        starts.append(numbers[here][usable])
        ends.append(numbers[there][usable])
        costs.append(cost[usable])
    return csr_matrix((np.concatenate(costs), (np.concatenate(starts), np.concatenate(ends))),
                      shape=(numbers.size, numbers.size))


def _between(weights: Array, columns: int, rows: int) -> List[Array]:
    """Return the weights of the cells that a step of two cells passes, each in the shape of its start cells."""
    if abs(columns) + rows < 3:
        return []
    height, width = weights.shape
    sign = 1 if columns > 0 else -1
    passed = [(sign, 0), (sign, 1)] if abs(columns) == 2 else [(0, 1), (sign, 1)]
    left, bottom = max(-columns, 0), height - rows
    span = width - abs(columns)
    return [weights[row:row + bottom, left + column:left + column + span] for column, row in passed]
