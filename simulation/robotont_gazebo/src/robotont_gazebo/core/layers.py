"""Blend the drawing of one layer onto the image, with smooth upper and lower edges."""
from typing import Tuple

import cv2
import numpy as np

from robotont_gazebo.core.visibility import Layer

STEEPEST = 4.0  # [px/column]: an edge is blended over as many rows as it rises in a column, but no more than these


class LayerMask:
    """The rows that one layer covers: in each column ``first`` to ``end`` (exclusive) fully, some next to them partly.

    first, end (width,) int32; left, right: the columns between which the layer shows anything; reach: the number of
    rows above ``first`` and from ``end`` on that are partly covered.
    """

    def __init__(self, layer: Layer, height: int) -> None:
        present = layer.solid >= 0
        columns = np.flatnonzero(present)
        self.left, self.right = (int(columns[0]), int(columns[-1]) + 1) if len(columns) else (0, 0)
        self._upper = np.clip(layer.upper, -STEEPEST, height + STEEPEST)
        self._lower = np.clip(layer.lower, -STEEPEST, height + STEEPEST)
        same = present[1:] & (layer.solid[1:] == layer.solid[:-1]) & (layer.kind[1:] == layer.kind[:-1]) \
            & (layer.face[1:] == layer.face[:-1])
        self._wide_upper, self._wide_lower = _widths(layer.upper, same), _widths(layer.lower, same)
        first = np.ceil(self._upper + 0.5 * self._wide_upper)
        end = np.floor(self._lower - 0.5 * self._wide_lower) + 1
        self.first = np.where(present, np.clip(first, 0, height), height).astype(np.int32)
        self.end = np.where(present, np.clip(end, 0, height), 0).astype(np.int32)
        self._present, self._height = present, height
        self.reach = int(np.ceil(max(self._wide_upper[present].max(initial=1.0),
                                     self._wide_lower[present].max(initial=1.0))))

    def rows_of(self, left: int, right: int) -> Tuple[int, int]:
        """Return the first and the end row of the covered area in the columns ``left`` to ``right``."""
        return (max(0, int(self.first[left:right].min()) - self.reach),
                min(self._height, int(self.end[left:right].max()) + self.reach))

    def blend(self, canvas: np.ndarray, drawn: np.ndarray) -> None:
        """Copy ``drawn`` onto ``canvas``, both (height, width, 4) uint8, where this layer covers it."""
        part = np.s_[self.left:self.right]
        top, bottom = int(self.first[part].min()), int(self.end[part].max())
        if top < bottom:
            rows = np.arange(top, bottom, dtype=np.int16)[:, None]
            mask = (rows >= self.first[part].astype(np.int16)) & (rows < self.end[part].astype(np.int16))
            cv2.copyTo(drawn[top:bottom, part], mask.view(np.uint8), canvas[top:bottom, part])
        self._blend_edges(canvas, drawn)

    def _blend_edges(self, canvas: np.ndarray, drawn: np.ndarray) -> None:
        columns = np.flatnonzero(self._present)
        steps = np.arange(self.reach)[:, None]
        first, end = self.first[columns], self.end[columns]
        above, below = first - 1 - steps, np.maximum(end, first) + steps
        rows = np.concatenate([above, below])
        upper, lower = self._upper[columns], self._lower[columns]
        share = (np.clip((rows - upper) / self._wide_upper[columns] + 0.5, 0.0, 1.0)
                 + np.clip((lower - rows) / self._wide_lower[columns] + 0.5, 0.0, 1.0) - 1.0)
        wanted = (share > 0.0) & (rows >= 0) & (rows < self._height)
        index = (rows * canvas.shape[1] + columns)[wanted]
        share = np.round(share[wanted] * 256).astype(np.int32)[:, None]
        flat = canvas.reshape(-1, 4)
        under = flat[index].astype(np.int32)
        flat[index] = under + ((drawn.reshape(-1, 4)[index] - under) * share >> 8)


def _widths(rows: np.ndarray, same: np.ndarray) -> np.ndarray:
    """Return over how many rows (width,) the edges at ``rows`` are blended: 1, or their rise to a ``same`` neighbour.

    rows (width,): rows of the edges; same (width - 1,) bool: the next column shows the same face.
    """
    rise = np.where(same, np.abs(rows[1:] - rows[:-1]), 0.0)
    out = np.ones(len(rows))
    out[1:] = np.maximum(out[1:], rise)
    out[:-1] = np.maximum(out[:-1], rise)
    widths: np.ndarray = np.minimum(out, STEEPEST)
    return widths
