"""A grey image in three sizes, with interpolation between pixels."""
from __future__ import annotations

import functools

import cv2
import numpy as np

from alvar_core.arrays import Floats, Image, Integers

LEVELS = range(3)  # full, half and quarter size


class Pyramid:
    """A grey image (uint8) at full, half and quarter size, in one array, so that one remap reads all of them.

    ``buffer`` (height + height // 2, width) uint8 is used for that array; without it, a new one is allocated.
    """

    def __init__(self, grey: Image, buffer: Image | None = None) -> None:
        self._height, width = grey.shape
        height = self._height
        boxes, self._table = _layout(width, height)
        self._atlas: Image = np.empty((height + height // 2, width), np.uint8) if buffer is None else buffer
        self._atlas[:height], finer = grey, grey
        for x, y, wide, high in boxes[1:]:
            finer = cv2.resize(finer, (wide, high), dst=self._atlas[y:y + high, x:x + wide],
                               interpolation=cv2.INTER_AREA)

    @property
    def full(self) -> Image:
        """Return the image at full size."""
        return self._atlas[:self._height]

    @property
    def memory(self) -> tuple[Image, Floats]:
        """Return the array of all sizes and the table of where each is, for compiled steps."""
        return self._atlas, self._table

    def read(self, x: Floats, y: Floats, level: Integers) -> Floats:
        """Return the grey values (M, P), float32, at real pixels ``x``, ``y`` (M, P), float32, of the full image.

        ``level`` (M,) selects the size to read from.
        """
        scale, x_offset, y_offset, left, top, right, bottom = self._table[level].T[:, :, None]
        x, y = x * scale, y * scale
        for along, offset, low, high in (x, x_offset, left, right), (y, y_offset, top, bottom):
            along += offset
            np.maximum(along, low, out=along)
            np.minimum(along, high, out=along)
        return cv2.remap(self._atlas, x, y, cv2.INTER_LINEAR).astype(np.float32)


@functools.lru_cache(maxsize=8)
def _layout(width: int, height: int) -> tuple[list[list[int]], Floats]:
    """Return the boxes (x, y, width, height) of all levels, and a row of each.

    A row contains scale, x and y offset, left, top, right, bottom.
    """
    sizes = np.array([[width >> level, height >> level] for level in LEVELS])
    base = np.array([[0, 0], [0, height], [width - sizes[2, 0], height]])
    scale = 0.5 ** np.arange(len(LEVELS))[:, None]
    table = np.hstack([scale, base + 0.5 * scale - 0.5, base, base + sizes - 1]).astype(np.float32)
    return np.hstack([base, sizes]).tolist(), table
