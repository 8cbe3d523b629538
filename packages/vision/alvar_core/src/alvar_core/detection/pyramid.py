"""A grey image in three sizes."""
from __future__ import annotations

import functools
from typing import Any

import cv2
import numpy as np

from alvar_core.arrays import Floats, Image
from alvar_core.detection.light import LINEAR, Light

LEVELS = range(3)  # full, half and quarter size


class Pyramid:
    """A grey image (uint8) at full, half and quarter size, in one array.

    A pixel of a smaller size has the grey of the mean ``light`` of its pixels. ``buffer`` (height + height // 2, width)
    uint8 is used for that array; without it, a new one is allocated.
    """

    def __init__(self, grey: Image, buffer: Image | None = None, light: Light = LINEAR) -> None:
        self._height, width = grey.shape
        height = self._height
        boxes, self._table = _layout(width, height)
        self._atlas: Image = np.empty((height + height // 2, width), np.uint8) if buffer is None else buffer
        self._atlas[:height], finer = grey, grey
        for x, y, wide, high in boxes[1:]:
            coarser = self._atlas[y:y + high, x:x + wide]
            if light.linear:
                cv2.resize(finer, (wide, high), dst=coarser, interpolation=cv2.INTER_AREA)
            else:
                light.steps.halve(grey=finer, out=coarser)
            finer = coarser

    @property
    def full(self) -> Image:
        """Return the image at full size."""
        return self._atlas[:self._height]

    @property
    def memory(self) -> dict[str, Any]:
        """Return the array of all sizes, and the table of their positions, as arguments of compiled steps."""
        return {'atlas': self._atlas, 'table': self._table}


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
