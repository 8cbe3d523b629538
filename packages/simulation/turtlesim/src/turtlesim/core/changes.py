"""The changed pixels of the canvas as runs of one colour, so that a page can show it without drawing.

A run is 8 bytes, little-endian: count << 18 | first pixel (row * 500 + column), then blue << 16 | green << 8 | red. A
page copies the second number into its own pixels. Strokes change few pixels, and an empty canvas has 500 runs.
"""
from typing import Optional

import numpy as np

from kinematic_core.worlds.turtle_world import CANVAS_SIZE

PIXEL_BITS = 18  # of the number of a pixel, 0 to 249,999
RUN = np.dtype([('place', '<u4'), ('colour', '<u4')])


def runs(pixels: bytes, before: Optional[bytes] = None) -> bytes:
    """Return the runs that turn the canvas ``before`` into ``pixels``, RGB row by row; without ``before``, all runs."""
    if pixels == before:
        return b''
    rows = np.frombuffer(pixels, np.uint8).reshape(CANVAS_SIZE, 3 * CANVAS_SIZE)
    if before is None:
        chosen: np.ndarray = np.arange(CANVAS_SIZE)
        changed = np.ones((CANVAS_SIZE, CANVAS_SIZE), bool)
        now = rows.reshape(CANVAS_SIZE, CANVAS_SIZE, 3)
    else:
        old = np.frombuffer(before, np.uint8).reshape(CANVAS_SIZE, 3 * CANVAS_SIZE)
        chosen = np.flatnonzero((rows != old).any(axis=1))
        now = rows[chosen].reshape(-1, CANVAS_SIZE, 3)
        changed = (now != old[chosen].reshape(-1, CANVAS_SIZE, 3)).any(axis=2)
    colours = now.astype('<u4') @ np.array([1, 1 << 8, 1 << 16], '<u4')
    edge = np.ones((len(chosen), CANVAS_SIZE + 1), bool)  # between neighbouring pixels: where a run ends
    edge[:, 1:-1] = (colours[:, 1:] != colours[:, :-1]) | (changed[:, 1:] != changed[:, :-1])
    row, column = np.nonzero(changed & edge[:, :-1])
    _, last = np.nonzero(changed & edge[:, 1:])
    found = np.empty(len(row), RUN)
    found['place'] = (last - column + 1) << PIXEL_BITS | chosen[row] * CANVAS_SIZE + column
    found['colour'] = colours[row, column]
    return found.tobytes()
