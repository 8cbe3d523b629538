"""Costmaps: how near to an obstacle each cell is, as costmap_2d's layers compute it.

A costmap is a grid without rotation; ``costs[row, column]`` has rows along y. Values are those of costmap_2d: FREE,
rising to INSCRIBED, where a robot with its middle there touches an obstacle in any case, LETHAL, where an obstacle is,
and UNKNOWN.
"""
import math
from typing import NamedTuple, Optional, Tuple

import cv2
import numpy as np

from navigation_core.maps.grid_map import GridMap
from navigation_core.poses import Array

FREE, INSCRIBED, LETHAL, UNKNOWN = 0, 253, 254, 255
Window = Tuple[slice, slice]


class Inflation(NamedTuple):
    """How costs fall with the distance from an obstacle: by ``scaling`` [1/m], to FREE at ``radius`` [m]."""

    radius: float = 0.55
    scaling: float = 10.0

    def costs(self, distance: Array, inscribed: float) -> Array:
        """Return the costs (uint8) at distances [m] from the nearest obstacle."""
        costs = np.full(distance.shape, FREE, np.uint8)
        near = distance <= self.radius
        costs[near] = (INSCRIBED - 1) * np.exp(-self.scaling * np.maximum(distance[near] - inscribed, 0.0))
        costs[distance <= min(inscribed, self.radius)] = INSCRIBED
        costs[distance == 0.0] = LETHAL
        return costs


INFLATION = Inflation()


class Costmap:
    """The static map and the obstacles that sensors have seen, inflated.

    ``costs``: see above. ``clearance`` [m] is the distance of each cell from the nearest obstacle; it is exact up to
    ``reach`` [m]. ``x``, ``y`` [m] is the outer corner of cell (0, 0) in the costmap's frame. ``static`` and ``seen``
    are the layers: FREE, LETHAL or UNKNOWN.
    """

    def __init__(self, width: int, height: int, resolution: float, x: float = 0.0, y: float = 0.0,
                 inscribed: float = 0.0, reach: float = 0.0, inflation: Inflation = INFLATION,
                 static: Optional[Array] = None, track_unknown: bool = True) -> None:
        """``inscribed`` [m]: radius of the robot's footprint; ``reach`` [m]: at least its circumscribed one."""
        self.resolution, self.x, self.y = resolution, x, y
        self.inscribed, self.inflation = inscribed, inflation
        self.reach = max(reach, inflation.radius)
        background = UNKNOWN if track_unknown else FREE
        self.static = np.full((height, width), background, np.uint8) if static is None else static
        self.seen = np.full((height, width), UNKNOWN, np.uint8)
        self.costs = np.empty((height, width), np.uint8)
        self.clearance = np.empty((height, width), np.float32)
        self.update()

    @classmethod
    def of_map(cls, grid: GridMap, inscribed: float, reach: float, inflation: Inflation = INFLATION,
               lethal_threshold: int = 100, track_unknown: bool = True) -> 'Costmap':
        """Return the costmap of an occupancy grid whose origin has no rotation."""
        return cls(grid.width, grid.height, grid.resolution, grid.origin.x, grid.origin.y, inscribed, reach, inflation,
                   static_layer(grid.cells, lethal_threshold, track_unknown))

    @property
    def shape(self) -> Tuple[int, int]:
        """The numbers of rows and columns."""
        return self.costs.shape[0], self.costs.shape[1]

    def cells(self, x: Array, y: Array) -> Tuple[Array, Array]:
        """Return the columns and rows of points [m]; they may be outside."""
        return (np.floor((np.asarray(x) - self.x) / self.resolution).astype(np.int64),
                np.floor((np.asarray(y) - self.y) / self.resolution).astype(np.int64))

    def points(self, columns: Array, rows: Array) -> Tuple[Array, Array]:
        """Return the middles [m] of cells."""
        return self.x + (columns + 0.5) * self.resolution, self.y + (rows + 0.5) * self.resolution

    def inside(self, columns: Array, rows: Array) -> Array:
        height, width = self.shape
        result: Array = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
        return result

    def sample(self, layer: Array, x: Array, y: Array, outside: float) -> Array:
        """Return the values of ``layer`` at points [m], and ``outside`` where there are none."""
        columns, rows = self.cells(x, y)
        height, width = self.shape
        values = layer[np.clip(rows, 0, height - 1), np.clip(columns, 0, width - 1)]
        result: Array = np.where(self.inside(columns, rows), values, outside)
        return result

    def clearances(self, x: Array, y: Array) -> Array:
        """Return ``clearance`` [m] at points (n, m) [m], interpolated between the middles of cells; 0 outside."""
        columns = ((x - self.x) / self.resolution - 0.5).astype(np.float32)
        rows = ((y - self.y) / self.resolution - 0.5).astype(np.float32)
        result: Array = cv2.remap(self.clearance, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return result

    def move_to(self, x: float, y: float) -> None:
        """Move a rolling costmap by whole cells, so that (x, y) [m] is in its middle; what it has seen stays in place.

        Call ``update`` afterwards.
        """
        height, width = self.shape
        columns = round((x - width * self.resolution / 2.0 - self.x) / self.resolution)
        rows = round((y - height * self.resolution / 2.0 - self.y) / self.resolution)
        self.x += columns * self.resolution
        self.y += rows * self.resolution
        moved = np.full_like(self.seen, UNKNOWN)
        kept_rows, kept_columns = height - abs(rows), width - abs(columns)
        if kept_rows > 0 and kept_columns > 0:
            row, column = max(-rows, 0), max(-columns, 0)
            moved[row:row + kept_rows, column:column + kept_columns] = self.seen[
                max(rows, 0):max(rows, 0) + kept_rows, max(columns, 0):max(columns, 0) + kept_columns]
        self.seen = moved

    def observe(self, sensor: Tuple[float, float], ends: Array, hits: Array, raytrace_range: float,
                obstacle_range: float) -> Optional[Window]:
        """Clear the cells along rays, and mark those where rays have hit something; return the window that changed.

        ``ends`` (rays, 2) [m] are the ends of rays from ``sensor``, ``hits`` (rays,) whether an obstacle is there.
        Call ``update`` afterwards.
        """
        if not len(ends):
            return None
        offsets = ends - sensor
        lengths = np.hypot(*offsets.T)
        shown = np.minimum(lengths - hits * self.resolution, raytrace_range)  # a hit keeps its own cell
        steps = math.ceil(max(float(shown.max()), 0.0) / self.resolution * 2.0) + 1
        along = np.linspace(0.0, max(float(shown.max()), 0.0), steps)
        directions = offsets / np.maximum(lengths, 1e-9)[:, None]
        ray, step = np.nonzero(along[None, :] <= shown[:, None])
        columns, rows = self.cells(sensor[0] + directions[ray, 0] * along[step],
                                   sensor[1] + directions[ray, 1] * along[step])
        free = self.inside(columns, rows)
        self.seen[rows[free], columns[free]] = FREE
        marked = ends[hits & (lengths <= obstacle_range)]
        hit_columns, hit_rows = self.cells(marked[:, 0], marked[:, 1])
        lethal = self.inside(hit_columns, hit_rows)
        self.seen[hit_rows[lethal], hit_columns[lethal]] = LETHAL
        columns = np.concatenate([columns[free], hit_columns[lethal]])
        rows = np.concatenate([rows[free], hit_rows[lethal]])
        if not columns.size:
            return None
        return slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)

    def forget_beyond(self, x: float, y: float, distance: float) -> None:
        """Forget obstacles that were seen outside of the square of 2 ``distance`` [m] around (x, y) [m]."""
        (left, right), (bottom, top) = self.cells(np.array([x - distance, x + distance]),
                                                  np.array([y - distance, y + distance]))
        kept = slice(max(int(bottom), 0), max(int(top) + 1, 0)), slice(max(int(left), 0), max(int(right) + 1, 0))
        seen = np.full_like(self.seen, UNKNOWN)
        seen[kept] = self.seen[kept]
        self.seen = seen
        self.update()

    def update(self, window: Optional[Window] = None) -> None:
        """Compute costs and clearance from the layers, in a window that has changed, or everywhere."""
        reach = math.ceil(self.reach / self.resolution) + 1
        inner, outer = _grown(window, reach, self.shape), _grown(window, 2 * reach, self.shape)
        layers = combined(self.static[outer], self.seen[outer])
        clearance = cv2.distanceTransform((layers != LETHAL).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        if not (layers == LETHAL).any():
            clearance[...] = math.hypot(*layers.shape)
        clearance *= self.resolution
        costs = self.inflation.costs(clearance, self.inscribed)
        costs[(layers == UNKNOWN) & (costs < INSCRIBED)] = UNKNOWN
        part = tuple(slice(a.start - b.start, a.stop - b.start) for a, b in zip(inner, outer))
        self.costs[inner], self.clearance[inner] = costs[part], clearance[part]

    def without_seen(self) -> 'Costmap':
        """Return the costmap of the static map alone."""
        height, width = self.shape
        return Costmap(width, height, self.resolution, self.x, self.y, self.inscribed, self.reach, self.inflation,
                       self.static)


def static_layer(cells: Array, lethal_threshold: int = 100, track_unknown: bool = True) -> Array:
    """Return the layer of the cells of an occupancy grid: LETHAL from ``lethal_threshold`` [%] on."""
    layer = np.where(cells >= lethal_threshold, LETHAL, FREE).astype(np.uint8)
    if track_unknown:
        layer[cells < 0] = UNKNOWN
    return layer


def combined(static: Array, seen: Array) -> Array:
    """Return both layers in one: what sensors have seen counts where the map has no obstacle."""
    result: Array = np.where((seen == LETHAL) | (static == UNKNOWN) & (seen != UNKNOWN), seen, static)
    return result


def occupancy(costs: Array) -> Array:
    """Return costs as the values of an OccupancyGrid (int8), as costmap_2d publishes them."""
    table = np.arange(256)
    table = np.where(table > 0, 1 + (97 * (table - 1)) // 251, 0)
    table[[INSCRIBED, LETHAL, UNKNOWN]] = 99, 100, -1
    result: Array = table.astype(np.int8)[costs]
    return result


def _grown(window: Optional[Window], margin: int, shape: Tuple[int, int]) -> Window:
    if window is None:
        return slice(0, shape[0]), slice(0, shape[1])
    rows, columns = (slice(max(part.start - margin, 0), min(part.stop + margin, size))
                     for part, size in zip(window, shape))
    return rows, columns
