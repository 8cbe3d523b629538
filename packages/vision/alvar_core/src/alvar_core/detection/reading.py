"""Read the cells of a marker: compare them with all code words of ALVAR's 5x5 numbers, or read them one by one."""
from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from alvar_core import code, native
from alvar_core.arrays import ArrayLike, Bools, Floats, Image, Integers
from alvar_core.detection import thresholds
from alvar_core.detection.acceptance import Ended, Shortfall, edges
from alvar_core.detection.alignment import Covariance, Grid


def black_cells(white: ArrayLike, margin: int) -> Bools:
    """Return the black cells (..., n + 2 margin, n + 2 margin), bool, of markers; ``white`` (..., n, n) bool."""
    white = np.asarray(white, bool)
    rows, columns = white.shape[-2:]
    black = np.ones((*white.shape[:-2], rows + 2 * margin, columns + 2 * margin), bool)  # numpy.pad takes longer
    np.logical_not(white, out=black[..., margin:margin + rows, margin:margin + columns])
    return black


@functools.lru_cache(maxsize=1)
def words_of_numbers() -> Bools:
    """Return the cells (1024, 5, 5), bool, True is white, of all numbers in all orientations.

    Row turns * 256 + number contains the cells that numpy.rot90(cells, turns) turns upright.
    """
    upright = [code.encode(number) for number in range(256)]
    words = np.array([np.rot90(cells, -turns) for turns in range(4) for cells in upright])
    words.flags.writeable = False  # all callers share it
    return words


@dataclass(frozen=True)
class Reading:
    """The result of reading a marker.

    ``content`` is a code.Content, ``fit`` 0 to 1, ``score_gap`` the difference to the fit of the next best code word,
    ``white`` (n, n), bool, the cells in the orientation of the image.
    """

    content: code.Content
    fit: float
    score_gap: float
    white: Bools

    @property
    def edges(self) -> int:
        """Return the number of edges between black and white cells."""
        return int(edges(black_cells(self.white, 1)))


@dataclass
class CoarseMatch:
    """The coarse decoding of those K of N quads that have a dark border.

    ``kept`` (K,): their indices; ``h`` (K, 3, 3): their homographies; ``fit`` (K,): that of the best code word, up to
    1; ``score_gap`` (K,): difference to the fit of the next best; ``word`` (K,): index of the best.
    """

    kept: Integers
    h: Floats
    fit: Floats
    score_gap: Floats
    word: Integers


class CoarseDecoder:
    """Decides for rough quads whether the border is dark, and which code word the cells resemble.

    It reads one grey value per cell, of the data cells and one ring of the border, and some along the outer edge.
    ``words`` (1024, 5, 5), bool, are the code words of resolution 5; None at other resolutions, where it matches only
    the cells that are equal in all markers.
    """

    ALONG = np.array([-0.75, -0.4, 0.0, 0.4, 0.75])  # positions along each side, as shares of its half
    DEPTHS = (0.4, -0.7)  # [cells] outside the edge, at which white and black are read

    def __init__(self, resolution: int, margin: int) -> None:
        self.half = resolution / 2 + margin
        n = resolution + 2
        line = np.arange(n) - (n - 1) / 2
        cells = np.stack([np.tile(line, n), np.repeat(line, n)], 1)
        rim, points = (np.concatenate([p, np.ones((len(p), 1))], 1).T for p in (self._rim_points(), cells))
        self.words = words_of_numbers() if resolution == 5 else None
        known, words = self._centred_words(resolution)
        blurred = words[:, :0] if self.words is None else self._blurred_words(self.words, line, margin)
        self.steps = native.steps.CoarseDecoder(half=self.half, rim=rim, cells=points, words=words, blurred=blurred,
                                                known=known)

    def _rim_points(self) -> Floats:
        points = []
        for depth in self.DEPTHS:
            x, y = self.ALONG * self.half, np.full(len(self.ALONG), -(self.half + depth))
            for _ in range(4):
                points.append(np.stack([x, y], 1))
                x, y = -y, x
        return np.concatenate(points)

    def _centred_words(self, resolution: int) -> tuple[Floats, Floats]:
        """Return which cells count (W or 1, P), and the words minus their means, normalised (P, W).

        There are P cells: the data cells and one ring around them.
        """
        if self.words is not None:
            words, known = np.pad(self.words, ((0, 0), (1, 1), (1, 1))), np.ones((1, 7, 7))
        else:
            mask, white = code.fixed_cells(resolution)
            words = np.array([np.rot90(np.pad(white, 1), -turns) for turns in range(4)])
            known = np.array([np.rot90(np.pad(mask, 1, constant_values=True), -turns) for turns in range(4)])
        flat = known.reshape(len(known), -1).astype(np.float32)
        centred = words.reshape(len(words), -1).astype(np.float32)
        centred = (centred - (centred * flat).sum(1, keepdims=True) / flat.sum(1, keepdims=True)) * flat
        return flat, (centred / np.linalg.norm(centred, axis=1, keepdims=True)).T

    @staticmethod
    def _blurred_words(words: Bools, line: Floats, margin: int) -> Floats:
        """Return ``words`` as (P, W) as a blur of SMALL_BLUR shows them; ``line``: x or y of the points [cells]."""
        black = black_cells(words, margin)
        covered = native.steps.coverage(line=line.astype(np.float32), cells=black.shape[-1],
                                        variance=np.array([thresholds.SMALL_BLUR ** 2]))[0]
        flat = (1 - covered @ black.astype(np.float32) @ covered.T).reshape(len(black), -1)
        flat -= flat.mean(1, keepdims=True)
        blurred: Floats = (flat / np.linalg.norm(flat, axis=1, keepdims=True)).T
        return blurred

    def match(self, smooth: Image, quads: Floats, ended: list[Ended] | None = None) -> CoarseMatch:
        """Return the CoarseMatch of quads (N, 4, 2) [real px] in a lightly smoothed image.

        ``ended`` gets those without a dark border.
        """
        return CoarseMatch(**self.steps.match(smooth=smooth, quads=quads, limit=native.limit, ended=ended))

    def other_margin(self, smooth: Image, corners: Floats) -> Shortfall | None:
        """Return the margin, one cell narrower or wider, with which the cells match a code word better; None if none.

        ``corners`` (4, 2) [real px] are those of the marker. The Shortfall is (NARROWER_MARGIN or WIDER_MARGIN, fit,
        fit with that margin).
        """
        found: Shortfall | None = self.steps.other_margin(smooth=smooth, corners=corners)
        return found


class Reader:
    """Reads aligned markers of one resolution and margin (both in cells); ``grid`` is that of the aligned values."""

    def __init__(self, grid: Grid, resolution: int = code.MIN_RESOLUTION, margin: int = code.MARGIN) -> None:
        self.resolution, self.margin, self.grid = resolution, margin, grid
        reach = self.resolution / 2 + min(0.5, margin / 2)
        self._inside = np.abs(self.grid.line) < reach
        self._line = grid.line[self._inside]
        self._seen = words_of_numbers() if resolution == 5 else np.zeros((0, 5, 5), bool)
        x, y = (v.ravel() for v in np.meshgrid(self._line, self._line))
        light = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * y], 1))[0]
        self.steps = native.steps.Reader(line=self._line, light=light, words=self._seen.reshape(-1, 25).T)

    def read(self, values: Floats, covariance: Covariance, noise: Floats) -> list[Reading]:
        """Return the best Reading of each marker of resolution 5.

        ``values`` (M, P) [greys] are those on the grid, ``covariance`` is the blur in cells. ``noise`` (M,) [greys] is
        the standard deviation of the values' noise, which does not reduce the fit.
        """
        return [self.of_word(*self.steps.read(values=each, xx=xx, yy=yy, noise=sigma, limit=native.limit))
                for each, xx, yy, sigma in zip(self._region(values), covariance.xx, covariance.yy, noise)]

    def _coverage(self, covariance: Covariance) -> tuple[Floats, Floats]:
        """Return how much each column and row of data cells covers each column and row of samples; both (M, S, n)."""
        ex, ey = (native.steps.coverage(line=self._line, cells=self.resolution, variance=each)
                  for each in (covariance.xx, covariance.yy))
        return ex, ey

    def _region(self, values: Floats) -> Floats:
        side = self.grid.count
        return values.reshape(-1, side, side)[:, self._inside][:, :, self._inside]

    def of_word(self, word: int, fit: float, score_gap: float) -> Reading:
        """Return the Reading of a code word (index turns * 256 + number)."""
        turns, number = divmod(int(word), 256)
        return Reading(code.Content(code.NUMBER, number, 0, turns), float(fit), float(score_gap), self._seen[word])

    def read_cells(self, shares: Floats, covariance: Covariance) -> list[Reading | None]:
        """Return the Readings (or None) of markers of any resolution, read cell by cell.

        ``shares`` (M, P) are the samples, from 0 (black) to 1 (white).
        """
        ex, ey = self._coverage(covariance)
        grey = self._region(shares)
        matched = (ey.transpose(0, 2, 1) @ grey @ ex).reshape(len(shares), -1)
        return [self._cellwise(*each) for each in zip(matched, grey, ex, ey)]

    def _cellwise(self, matched: Floats, grey: Floats, ex: Floats, ey: Floats) -> Reading | None:
        n = self.resolution
        gram = ((ey.T @ ey)[:, None, :, None] * (ex.T @ ex)[None, :, None, :]).reshape(n * n, n * n)
        ridge = np.eye(n * n) * thresholds.CELL_RIDGE * np.trace(gram) / (n * n)
        cells = np.linalg.solve(gram + ridge, matched)
        white = (cells > np.sort(cells)[-3:].mean() / 2).reshape(n, n)
        content = code.decode(white)
        if content is None:
            return None
        upright = self._redrawn(content, white)
        if upright is None:
            return None
        white = np.rot90(upright, -content.turns)
        w = white.ravel().astype(np.float32)
        fit = w @ matched / np.sqrt(np.maximum(w @ gram @ w, 1e-6) * (float((grey * grey).sum()) + 1e-6))
        return Reading(content, float(fit), 1.0, white)

    def _redrawn(self, content: code.Content, seen: Bools) -> Bools | None:
        """Return the upright cells of the drawing of this content that is most similar to ``seen``.

        Return None if more than two cells differ in each.
        """
        drawings = []
        for strong in (False, True):
            try:
                drawings.append(code.encode(content.value, content.kind, strong, self.resolution))
            except code.CodeError:
                continue
        upright = np.rot90(seen, content.turns)
        drawings = [d for d in drawings if (d != upright).sum() <= 2]
        return min(drawings, key=lambda d: int((d != upright).sum()), default=None)
