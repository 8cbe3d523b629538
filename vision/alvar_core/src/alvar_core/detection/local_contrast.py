"""Read markers in uneven light: by the local contrast across the edges of cells, not by their greys.

A shadow's edge, a dark band or a lamp's reflection changes the grey of many cells, but the contrast of few pairs of
neighbours. Coordinates are in cells as in alignment.py. An edge lies between two neighbours: those of a row, then those
of a column. Its contrast is (right - left) / (right + left), or that of lower and upper, from -1 to 1.
"""
from __future__ import annotations

import ctypes
from dataclasses import dataclass

import cv2
import numpy as np

from alvar_core import code, native
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.detection import thresholds
from alvar_core.detection.reading import words_of_numbers


def steps_of(white: Bools) -> Integers:
    """Return what is on each edge of cells (..., n, n), bool, True is white: 1 black to white, -1 the reverse, 0."""
    cells = white.astype(np.int8)
    sideways, down = np.diff(cells, axis=-1), np.diff(cells, axis=-2)
    flat = white.shape[:-2] + (-1,)
    return np.concatenate([sideways.reshape(flat), down.reshape(flat)], -1)


@dataclass
class LocalMatch:
    """What the local contrasts of K quads say.

    ``rim`` (K,): share of the places on the outer edge where white follows black; ``contrast`` (K,): typical there;
    ``plain`` (K,): share of the edges inside the border without a step; ``fit``, ``gap``, ``word`` (K,): of the code.
    """

    rim: Floats
    contrast: Floats
    plain: Floats
    fit: Floats
    gap: Floats
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
        self._of_code, self._of_border = np.flatnonzero(near), np.flatnonzero(~near)
        self._points = self._pairs(np.stack([x, y], 1), across)
        line = np.arange(n) - (n - 1) / 2
        full = np.full(n, self.half)
        rim = np.concatenate([np.stack([line, -full], 1), np.stack([full, line], 1),
                              np.stack([line, full], 1), np.stack([-full, line], 1)])
        outward = np.repeat([[0.0, -1], [1, 0], [0, 1], [-1, 0]], n, 0)
        self._rim_points = self._pairs(rim, outward)
        shown = steps[:, self._of_code]
        # (1024, 3 E): for each edge which of the three costs counts
        self._costs = np.ascontiguousarray(np.concatenate([shown < 0, shown == 0, shown > 0], 1).T)
        self._is_code = near

    def _pairs(self, middle: Floats, across: Floats) -> Floats:
        """Return homogeneous points (3, 2 * edges * places): before the edges, then after them."""
        along = across[:, ::-1]
        place = middle[:, None] + np.array(self.ALONG)[:, None] * along[:, None]
        both = np.stack([place - self.ACROSS * across[:, None], place + self.ACROSS * across[:, None]])
        flat = both.reshape(-1, 2)
        return np.ascontiguousarray(np.concatenate([flat, np.ones((len(flat), 1))], 1).T, np.float32)

    def contrasts(self, smooth: Image, h: Floats, points: Floats) -> Floats:
        """Return the contrasts (M, edges, places) at homogeneous points of markers at ``h`` (M, 3, 3), real px."""
        if native.library:
            h, seen = np.ascontiguousarray(h, np.float32), np.empty((len(h), points.shape[1] // 2), np.float32)
            native.library.alvar_contrasts(
                *native.image(smooth), len(h), native.address(h), seen.shape[1], native.address(points),
                ctypes.c_double(thresholds.DARK_GREY), native.address(seen))
            return seen.reshape(len(h), -1, len(self.ALONG))
        p = h.astype(np.float32) @ points
        inverse = 1 / p[:, 2]
        grey = cv2.remap(smooth, p[:, 0] * inverse, p[:, 1] * inverse, cv2.INTER_LINEAR,
                         borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
        before, after = grey.reshape(len(h), 2, -1).transpose(1, 0, 2)
        out = (after - before) / (after + before + thresholds.DARK_GREY)
        return out.reshape(len(h), -1, len(self.ALONG))

    def rim(self, smooth: Image, h: Floats) -> tuple[Floats, Floats]:
        """Return, of markers at ``h``, the share of the rim that is an edge, and its typical contrast.

        Both may be 0 where the share is below thresholds.MIN_LOCAL_RIM.
        """
        if native.library:
            h, out, limits = np.ascontiguousarray(h, np.float32), np.empty((2, len(h))), _limits()
            native.library.alvar_local_rims(
                *native.image(smooth), len(h), native.address(h), self._rim_points.shape[1] // 2,
                native.address(self._rim_points), native.address(limits),
                ctypes.c_double(thresholds.MIN_LOCAL_RIM), native.address(out))
            return out[0], out[1]
        seen = self.contrasts(smooth, h, self._rim_points).reshape(len(h), -1)
        middle = seen.shape[1] // 2
        contrast = np.partition(seen, [middle - 1, middle], 1)[:, middle - 1:middle + 1].mean(1)
        shown = (seen > thresholds.MIN_LOCAL_SHARE * contrast[:, None]) & (seen > thresholds.MIN_LOCAL_CONTRAST)
        return shown.mean(1), contrast

    def match(self, smooth: Image, h: Floats) -> LocalMatch:
        """Return the LocalMatch of markers at ``h`` (M, 3, 3)."""
        if native.library:
            return self._match_compiled(native.library, smooth, h)
        rim, contrast = self.rim(smooth, h)
        low, other, high = np.moveaxis(self.contrasts(smooth, h, self._points), 2, 0)
        seen = np.maximum(np.minimum(low, other), np.minimum(np.maximum(low, other), high))  # the median of three
        seen = seen / np.maximum(contrast, thresholds.MIN_LOCAL_CONTRAST)[:, None]
        stepped = np.abs(seen[:, self._of_border]) >= thresholds.MAX_PLAIN_CONTRAST
        plain = 1 - stepped.sum(1) / max(1, len(self._of_border))  # a border of one cell has no inner edges
        seen = seen[:, self._of_code]
        cap = thresholds.MAX_EDGE_COST
        cost = np.concatenate([np.clip(1 + seen, 0, cap), np.clip(np.abs(seen), 0, cap), np.clip(1 - seen, 0, cap)], 1)
        fit = 1 - cost.astype(np.float32) @ self._costs.astype(np.float32) / (cap * seen.shape[1])
        rows = np.arange(len(fit))
        word = fit.argmax(1)
        best = fit[rows, word]
        fit[rows, word] = -1
        return LocalMatch(rim, contrast, plain, best, best - fit.max(1), word)

    def _match_compiled(self, library: ctypes.CDLL, smooth: Image, h: Floats) -> LocalMatch:
        """Do the same as ``match`` with the compiled step of native/decoding.cpp."""
        h, place = np.ascontiguousarray(h, np.float32), native.address
        out, words, limits = np.empty((5, len(h))), np.empty(len(h), np.int64), _limits()
        library.alvar_match_local(
            *native.image(smooth), len(h), place(h), self._rim_points.shape[1] // 2, place(self._rim_points),
            len(self._is_code), place(self._points), place(self._is_code), self._costs.shape[1], place(self._costs),
            place(limits), place(out), place(words))
        rim, contrast, plain, fit, gap = out
        return LocalMatch(rim, contrast, plain, fit, gap, words)


def _limits() -> Floats:
    """Return the thresholds that native/decoding.cpp needs."""
    return np.array([thresholds.DARK_GREY, thresholds.MIN_LOCAL_SHARE, thresholds.MIN_LOCAL_CONTRAST,
                     thresholds.MAX_PLAIN_CONTRAST, thresholds.MAX_EDGE_COST])
