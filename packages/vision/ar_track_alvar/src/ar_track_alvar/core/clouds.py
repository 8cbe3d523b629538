"""Read a coloured, organised point cloud: its image and its points, ordered like the pixels.

The functions take a sensor_msgs/PointCloud2, or anything with the same attributes.
"""
from __future__ import annotations

from typing import Any, Sequence

import cv2
import numpy as np

from alvar_core.detection.prepared_image import ImageError

TYPES = {1: 'i1', 2: 'u1', 3: 'i2', 4: 'u2', 5: 'i4', 6: 'u4', 7: 'f4', 8: 'f8'}  # PointField.datatype
BYTE, WORDS = 2, (5, 6, 7)  # datatypes of separate r, g and b, and of all three in one number
MAX_PIXELS = 4096 * 4096
REGISTERED = ('use the registered cloud of the driver (depth_registered/points, or ordered_pc:=true and '
              'align_depth:=true of realsense2_camera)')


class CloudError(ImageError):
    """A point cloud cannot be used; the text says why."""


class Cloud:
    """The points and colours of a PointCloud2, without copies; raise CloudError for unusable data."""

    def __init__(self, message: Any) -> None:
        self._message = message
        self._check_size()
        fields = {field.name: field for field in message.fields}
        missing = [name for name in 'xyz' if name not in fields]
        if missing:
            self._fail(f'fields x, y and z are needed; {", ".join(missing)} is missing among {_names(fields)}')
        self._places = [self._numbers(fields[name]) for name in 'xyz']
        self._colours = self._find_colours(fields)

    @property
    def shape(self) -> tuple[int, int]:
        """Return (height, width) [px]."""
        return self._message.height, self._message.width

    def bgr(self) -> np.ndarray:
        """Return the image (height, width, 3) uint8 in OpenCV's order, a new array."""
        return cv2.merge([np.ascontiguousarray(channel) for channel in self._colours])

    def grey(self) -> np.ndarray:
        """Return the grey image (height, width) uint8."""
        return cv2.cvtColor(self.bgr(), cv2.COLOR_BGR2GRAY)

    def window(self, top: int, bottom: int, left: int, right: int) -> np.ndarray:
        """Return the points (rows, columns, 3) float64 [m] of a part of the image; NaN without a point."""
        return np.stack([axis[top:bottom, left:right].astype(np.float64) for axis in self._places], -1)

    def _check_size(self) -> None:
        message = self._message
        if message.height < 2 or message.width < 2:
            self._fail(f'it is not organised like an image (height {message.height}, width {message.width}): '
                       f'{REGISTERED}')
        if message.height * message.width > MAX_PIXELS:
            self._fail(f'it has {message.width}x{message.height} points; at most {MAX_PIXELS} are allowed')
        if message.point_step < 1 or message.row_step < message.point_step * message.width:
            self._fail(f'row_step is {message.row_step} bytes; a row of {message.width} points of '
                       f'{message.point_step} bytes has {message.point_step * message.width}')
        needed = message.row_step * (message.height - 1) + message.point_step * message.width
        if len(message.data) < needed:
            self._fail(f'it has {len(message.data)} bytes of data, {needed} are needed; is it cut off?')

    def _fail(self, why: str) -> None:
        raise CloudError(f'the point cloud cannot be used: {why}')

    def _array(self, kind: str, offset: int, name: str) -> np.ndarray:
        message, item = self._message, np.dtype(kind)
        if not 0 <= offset <= message.point_step - item.itemsize:
            self._fail(f'the field {name} at offset {offset} does not fit into a point of {message.point_step} bytes')
        return np.ndarray(self.shape, item, message.data, offset, (message.row_step, message.point_step))

    def _numbers(self, field: Any) -> np.ndarray:
        if field.datatype not in (7, 8):
            self._fail(f'the field {field.name} has the datatype {field.datatype}; FLOAT32 (7) or FLOAT64 (8) is '
                       'needed')
        order = '>' if self._message.is_bigendian else '<'
        return self._array(order + TYPES[field.datatype], field.offset, field.name)

    def _find_colours(self, fields: dict[str, Any]) -> Sequence[np.ndarray]:
        """Return blue, green and red (height, width) uint8."""
        word = fields.get('rgb') or fields.get('rgba')
        if word is not None:
            if word.datatype not in WORDS:
                self._fail(f'the field {word.name} has the datatype {word.datatype}; FLOAT32 (7), UINT32 (6) or '
                           'INT32 (5), with 0xRRGGBB, is needed')
            places = (3, 2, 1) if self._message.is_bigendian else (0, 1, 2)
            self._array('u4', word.offset, word.name)
            return [self._array('u1', word.offset + place, word.name) for place in places]
        if all(name in fields and fields[name].datatype == BYTE for name in 'rgb'):
            return [self._array('u1', fields[name].offset, name) for name in 'bgr']
        self._fail(f'it has no colours (a field rgb or rgba is needed; it has {_names(fields)}): {REGISTERED}')
        raise AssertionError  # _fail does not return


def _names(fields: dict[str, Any]) -> str:
    return ', '.join(sorted(fields)) or 'none'
