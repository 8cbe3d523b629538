"""Maps as nav_msgs/OccupancyGrid, whose cells stay a numpy array: rospy's own tuples take a second for a large map."""
from __future__ import annotations

import struct
from typing import BinaryIO

import numpy as np
import rospy
from genpy import DeserializationError
from nav_msgs.msg import MapMetaData, OccupancyGrid

from navigation_core.maps.grid_map import MAX_CELLS, GridMap
from navigation_core.poses import Array
from navigation_core.ros.poses import from_pose, to_pose

AFTER_FRAME = 8 + 4 + 4 + 4 + 7 * 8  # [bytes] of MapMetaData, between the name of the frame and the number of cells
LENGTH = struct.Struct('<I')


class Grid(OccupancyGrid):
    """An OccupancyGrid of which ``data`` is an int8 array; the same on the wire. For publishers and subscribers."""

    __slots__ = OccupancyGrid.__slots__  # genpy looks for them in the class itself
    data: Array | tuple[int, ...]

    def serialize(self, buff: BinaryIO) -> None:
        """Write the message; rospy calls this method."""
        data, self.data = self.data, ()
        try:
            super().serialize(buff)
        finally:
            self.data = data
        cells = np.asarray(data, np.int8)
        buff.seek(-LENGTH.size, 1)
        buff.write(LENGTH.pack(cells.size))
        buff.write(cells.tobytes())

    def deserialize(self, str: bytes) -> Grid:  # noqa: A002  rospy's name
        """Read the message; rospy calls this method."""
        try:
            at = 16 + LENGTH.unpack_from(str, 12)[0] + AFTER_FRAME
            number, = LENGTH.unpack_from(str, at)
            cells = np.frombuffer(str, np.int8, number, at + LENGTH.size)
        except (struct.error, ValueError) as error:
            raise DeserializationError(error) from None
        super().deserialize(str[:at] + LENGTH.pack(0))
        self.data = cells
        return self


def info_of(grid: GridMap, loaded: rospy.Time | None = None) -> MapMetaData:
    """Return the MapMetaData of a GridMap; ``loaded`` is the time that it states, by default now."""
    return MapMetaData(map_load_time=loaded or rospy.Time.now(), resolution=grid.resolution, width=grid.width,
                       height=grid.height, origin=from_pose(grid.origin))


def to_message(grid: GridMap, frame: str, info: MapMetaData | None = None) -> Grid:
    message = Grid(info=info or info_of(grid), data=grid.cells.ravel())
    message.header.stamp, message.header.frame_id = rospy.Time.now(), frame
    return message


def as_lists(message: OccupancyGrid) -> OccupancyGrid:
    """Return an OccupancyGrid of a Grid, for the answer of a service."""
    return OccupancyGrid(message.header, message.info, np.asarray(message.data).tolist())


def from_message(message: OccupancyGrid) -> GridMap:
    """Return the GridMap of an OccupancyGrid; raise ValueError that says what is wrong."""
    info = message.info
    if not info.width * info.height or info.width * info.height > MAX_CELLS:
        raise ValueError(f'it has {info.width} x {info.height} cells; it must have 1 to {MAX_CELLS}')
    if not 0.0 < info.resolution < float('inf'):
        raise ValueError(f'its resolution is {info.resolution:g}; it must be more than 0 m for each cell')
    cells = np.asarray(message.data, np.int8)
    if cells.size != info.width * info.height:
        raise ValueError(f'it has {cells.size} values; {info.width} x {info.height} cells are stated')
    return GridMap(cells.reshape(info.height, info.width), info.resolution, to_pose(info.origin))
