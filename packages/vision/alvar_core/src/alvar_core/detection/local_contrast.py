"""Read markers in uneven light: by the local contrast across the edges of cells, not by their greys.

A shadow's edge, a dark band or a lamp's reflection changes the grey of many cells, but the contrast of few pairs of
neighbours. Coordinates are in cells as in alignment.py. An edge lies between two neighbours: those of a row, then those
of a column. Its contrast is (right - left) / (right + left), or that of lower and upper, from -1 to 1.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from alvar_core import code, native
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.detection.reading import words_of_numbers


def steps_of(white: Bools) -> Integers:
    """Return the step on each edge of cells (..., n, n), True is white: 1 black to white, -1 the reverse, 0 none."""
    cells = white.astype(np.int8)
    sideways, down = np.diff(cells, axis=-1), np.diff(cells, axis=-2)
    flat = white.shape[:-2] + (-1,)
    return np.concatenate([sideways.reshape(flat), down.reshape(flat)], -1)


@dataclass
class LocalMatch:
    """The results of the local contrasts of K quads.

    ``rim`` (K,): share of the places on the outer edge where white follows black; ``contrast`` (K,): typical there;
    ``plain`` (K,): share of the edges inside the border without a step; ``fit``, ``score_gap``, ``word`` (K,): of the
    code.
    """

    rim: Floats
    contrast: Floats
    plain: Floats
    fit: Floats
    score_gap: Floats
    word: Integers


class LocalDecoder:
    """Reads the local contrast of markers of resolution 5; ``margin`` in cells."""

    ALONG = (-0.28, 0.0, 0.28)  # cells along an edge, where it is read
    ACROSS = 0.36  # cells to each side of it

    def __init__(self, margin: int) -> None:
        n = code.MIN_RESOLUTION + 2 * margin
        self.half = n / 2
        self.words = words_of_numbers()
        padded = np.pad(self.words, ((0, 0), (margin, margin), (margin, margin)))
        steps = steps_of(padded)
        rows, columns = np.arange(n) - (n - 1) / 2, np.arange(n - 1) - (n - 2) / 2
        x = np.concatenate([np.tile(columns, n), np.tile(rows, n - 1)])
        y = np.concatenate([np.repeat(rows, n - 1), np.repeat(columns, n)])
        count = n * (n - 1)
        across = np.repeat([[1.0, 0.0], [0.0, 1.0]], count, 0)
        near = np.maximum(np.abs(x), np.abs(y)) < code.MIN_RESOLUTION / 2 + 0.9
        points = self._pairs(np.stack([x, y], 1), across)
        line = np.arange(n) - (n - 1) / 2
        full = np.full(n, self.half)
        rim = np.concatenate([np.stack([line, -full], 1), np.stack([full, line], 1),
                              np.stack([line, full], 1), np.stack([-full, line], 1)])
        outward = np.repeat([[0.0, -1], [1, 0], [0, 1], [-1, 0]], n, 0)
        shown = steps[:, near]
        # (3 E, 1024): which of the three costs of each edge counts
        costs = np.concatenate([shown < 0, shown == 0, shown > 0], 1).T
        self._steps = native.steps.LocalDecoder(rim=self._pairs(rim, outward), points=points, of_code=near, costs=costs)

    def _pairs(self, middle: Floats, across: Floats) -> Floats:
        """Return homogeneous points (3, 2 * edges * places): before the edges, then after them."""
        along = across[:, ::-1]
        place = middle[:, None] + np.array(self.ALONG)[:, None] * along[:, None]
        both = np.stack([place - self.ACROSS * across[:, None], place + self.ACROSS * across[:, None]])
        flat = both.reshape(-1, 2)
        return np.ascontiguousarray(np.concatenate([flat, np.ones((len(flat), 1))], 1).T, np.float32)

    def contrasts(self, smooth: Image, h: Floats, points: Floats) -> Floats:
        """Return the contrasts (M, edges, places) at homogeneous points of markers at ``h`` (M, 3, 3), real px."""
        seen: Floats = native.steps.contrasts(smooth=smooth, h=h, points=points, limit=native.limit)
        return seen.reshape(len(h), -1, len(self.ALONG))

    def rim(self, smooth: Image, h: Floats) -> tuple[Floats, Floats]:
        """Return, of markers at ``h``, the share of the rim that is an edge, and its typical contrast.

        Both may be 0 where the share is below thresholds.MIN_LOCAL_RIM.
        """
        found: tuple[Floats, Floats] = self._steps.rim(smooth=smooth, h=h, limit=native.limit)
        return found

    def match(self, smooth: Image, h: Floats) -> LocalMatch:
        """Return the LocalMatch of markers at ``h`` (M, 3, 3)."""
        rows = self._steps.match(smooth=smooth, h=h, limit=native.limit)
        return LocalMatch(*(rows[name] for name in ('rim', 'contrast', 'plain', 'fit', 'score_gap', 'word')))
