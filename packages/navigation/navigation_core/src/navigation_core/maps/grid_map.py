"""The occupancy grid, as a nav_msgs/OccupancyGrid has it."""
from typing import Any, Tuple, Union

import numpy as np

from navigation_core.poses import ORIGIN, Array, Numbers, Pose

UNKNOWN, FREE, OCCUPIED = -1, 0, 100  # values of cells; between the last two: the probability of a wall [%]
MAX_CELLS = 5000 * 5000  # of a map that is read: 250 m x 250 m at 0.05 m
Indices = Union[int, Array]


class GridMap:
    """A map of square cells: ``cells[row, column]`` is UNKNOWN, or FREE to OCCUPIED.

    ``cells`` is an int8 array; its rows are y, upwards, its columns x. ``resolution`` [m] is the side of a cell, and
    ``origin`` the pose in the map's frame of the outer corner of cell (0, 0).
    """

    def __init__(self, cells: Array, resolution: float, origin: Pose = ORIGIN):
        self.cells = np.ascontiguousarray(cells, dtype=np.int8)
        self.resolution = float(resolution)
        self.origin = origin
        if self.cells.ndim != 2 or not self.cells.size:
            raise ValueError(f'cells of shape {self.cells.shape}: a map needs rows and columns')
        if not 0.0 < self.resolution < float('inf'):
            raise ValueError(f'resolution {resolution!r}: it must be a positive number of metres')

    @classmethod
    def unknown(cls, width: int, height: int, resolution: float, origin: Pose = ORIGIN) -> 'GridMap':
        """Return a map of ``width`` x ``height`` cells of which none is known."""
        return cls(np.full((height, width), UNKNOWN, np.int8), resolution, origin)

    @property
    def width(self) -> int:
        return int(self.cells.shape[1])

    @property
    def height(self) -> int:
        return int(self.cells.shape[0])

    def to_world(self, columns: Indices, rows: Indices) -> Tuple[Any, Any]:
        """Return x, y [m] of the middles of cells."""
        return self.origin.to_outer((columns + 0.5) * self.resolution, (rows + 0.5) * self.resolution)

    def to_cell(self, x: Numbers, y: Numbers) -> Tuple[Any, Any]:
        """Return the columns and rows of the cells that the points (x, y) [m] lie in; they may be outside of the map.

        Integers for numbers, integer arrays for arrays. The points must be finite.
        """
        inner_x, inner_y = self.origin.to_inner(x, y)
        columns, rows = np.floor(inner_x / self.resolution), np.floor(inner_y / self.resolution)
        if np.ndim(columns) == 0:
            return int(columns), int(rows)
        return columns.astype(np.int64), rows.astype(np.int64)

    def contains(self, columns: Indices, rows: Indices) -> Union[bool, Array]:
        return (columns >= 0) & (columns < self.width) & (rows >= 0) & (rows < self.height)

    def values(self, columns: Array, rows: Array) -> Array:
        """Return the values of cells; outside of the map, UNKNOWN."""
        found = np.full(np.shape(columns), UNKNOWN, np.int8)
        inside = self.contains(columns, rows)
        found[inside] = self.cells[rows[inside], columns[inside]]
        return found
