"""Read the cells of a marker: compare them with all code words of ALVAR's 5x5 numbers, or read them one by one."""
from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass

import cv2
import numpy as np

from alvar_core import code, native
from alvar_core.arrays import ArrayLike, Bools, Floats, Image, Integers
from alvar_core.detection import homography, thresholds
from alvar_core.detection.alignment import NORMAL_STEP, Covariance, Grid


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


def in_chunks(a: Floats, b: Floats, limit: int = 250000) -> Floats:
    """Return a @ b, computed in parts that are too small for OpenBLAS to start threads, whose start takes longer."""
    rows = max(1, limit // (b.shape[0] * b.shape[1]))
    if len(a) <= rows:
        return a @ b
    return np.concatenate([a[i:i + rows] @ b for i in range(0, len(a), rows)])


def without_noise(energy: Floats | float, noise: Floats | float) -> Floats:
    """Return energy minus noise, which counts for at most the share MAX_NOISE_SHARE of it; arrays or numbers."""
    return energy - np.minimum(noise, thresholds.MAX_NOISE_SHARE * energy)


@dataclass(frozen=True)
class Reading:
    """The result of reading a marker.

    ``content`` is a code.Content, ``fit`` 0 to 1, ``gap`` the difference to the fit of the next best code word,
    ``white`` (n, n), bool, the cells in the orientation of the image.
    """

    content: code.Content
    fit: float
    gap: float
    white: Bools


@dataclass
class CoarseMatch:
    """The coarse decoding of those K of N quads that have a dark border.

    ``kept`` (K,): their indices; ``h`` (K, 3, 3): their homographies; ``fit`` (K,): that of the best code word, up to
    1; ``gap`` (K,): difference to the fit of the next best; ``word`` (K,): index of the best.
    """

    kept: Integers
    h: Floats
    fit: Floats
    gap: Floats
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
        self._rim, self._cells = (np.ascontiguousarray(np.concatenate([p, np.ones((len(p), 1))], 1).T, np.float32)
                                  for p in (self._rim_points(), cells))
        self.words = words_of_numbers() if resolution == 5 else None
        self._known, self._words_t = self._centred_words(resolution)

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

        P are the data cells and one ring around them.
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
        return flat, np.ascontiguousarray((centred / np.linalg.norm(centred, axis=1, keepdims=True)).T)

    def match(self, smooth: Image, quads: Floats) -> CoarseMatch:
        """Return the CoarseMatch of quads (N, 4, 2) [real px] in a lightly smoothed image."""
        if native.library and self.words is not None:
            return self._match_compiled(native.library, smooth, quads)
        h = homography.from_square(quads, self.half)
        rim = self._grey(smooth, h, self._rim).reshape(-1, 2, 4, len(self.ALONG))
        step = rim[:, 0] - rim[:, 1]
        contrast = np.sort(np.sort(step, 2)[:, :, len(self.ALONG) // 2], 1)[:, 1]
        step = step.reshape(len(step), -1)
        least = np.maximum(thresholds.MIN_RIM_STEP_SHARE * contrast, thresholds.MIN_RIM_STEP)
        dark = (step > least[:, None]).sum(1)
        kept = np.flatnonzero((contrast > thresholds.MIN_RIM_CONTRAST)
                              & (dark > thresholds.MIN_DARK_RIM * step.shape[1]))
        if not len(kept):
            return CoarseMatch(kept, h[kept], np.zeros(0), np.zeros(0), np.zeros(0, int))
        return CoarseMatch(kept, h[kept], *self._match(self._grey(smooth, h[kept], self._cells)))

    def _match_compiled(self, library: ctypes.CDLL, smooth: Image, quads: Floats) -> CoarseMatch:
        """Do the same as ``match`` with the compiled step of native/decoding.cpp."""
        quads, place, count = np.ascontiguousarray(quads, np.float64), native.address, len(quads)
        limits, rim, points, word_table = self.compiled_arrays()
        kept, words = np.empty((2, count), np.int64)
        h, fits = np.empty((count, 3, 3)), np.empty((2, count))
        n = library.alvar_match_coarse(
            *native.image(smooth), count, place(quads), place(limits), place(rim), points.shape[1], place(points),
            word_table.shape[1], place(word_table), place(kept), place(h), place(fits),
            place(words))
        return CoarseMatch(kept[:n], h[:n], fits[0, :n], fits[1, :n], words[:n])

    def compiled_arrays(self) -> tuple[Floats, ...]:
        """Return what native/decoding.cpp needs: limits, points of the rim and of the cells, words."""
        limits = np.array([self.half, thresholds.MIN_RIM_STEP_SHARE, thresholds.MIN_RIM_STEP,
                           thresholds.MIN_RIM_CONTRAST, thresholds.MIN_DARK_RIM])
        return limits, self._rim, self._cells, self._words_t

    def fit(self, smooth: Image, quad: Floats, spread: float) -> float:
        """Return the fit of the best code word to the cells of one quad (4, 2), ``spread`` times as far apart."""
        if native.library and self.words is not None:
            quad, place = np.ascontiguousarray(quad, np.float64), native.address
            _, _, points, words = self.compiled_arrays()
            return float(native.library.alvar_coarse_fit(
                *native.image(smooth), place(quad), ctypes.c_double(self.half), ctypes.c_double(spread),
                points.shape[1], place(points), words.shape[1], place(words)))
        h = homography.from_square(quad[None], self.half)
        cells = self._cells * np.array([[spread], [spread], [1]], np.float32)
        return float(self._match(self._grey(smooth, h, cells))[0][0])

    def _grey(self, smooth: Image, h: Floats, points: Floats) -> Floats:
        p = h.astype(np.float32) @ points
        inverse = 1 / p[:, 2]
        x, y = p[:, 0] * inverse, p[:, 1] * inverse
        return cv2.remap(smooth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)

    def _match(self, grey: Floats) -> tuple[Floats, Floats, Integers]:
        """Return, for greys (N, P), the fit of the best word, its gap to the second best and its index, each (N,)."""
        spread = (grey * grey) @ self._known.T - (grey @ self._known.T) ** 2 / self._known.sum(1)
        fit = in_chunks(grey, self._words_t) / np.sqrt(np.maximum(spread, 1.0))
        word = fit.argmax(1)
        rows = np.arange(len(fit))
        best = fit[rows, word]
        fit[rows, word] = -1
        return best, best - fit.max(1), word


class Reader:
    """Reads aligned markers of one resolution and margin (both in cells); ``grid`` is that of the aligned values."""

    def __init__(self, grid: Grid, resolution: int = code.MIN_RESOLUTION, margin: int = code.MARGIN) -> None:
        self.resolution, self.margin, self.grid = resolution, margin, grid
        reach = self.resolution / 2 + min(0.5, margin / 2)
        self._inside = np.abs(self.grid.line) < reach
        x, y = (v.ravel() for v in np.meshgrid(grid.line[self._inside], grid.line[self._inside]))
        light = np.stack([np.ones_like(x), x, y, x * y], 1)
        self._light = np.ascontiguousarray(np.linalg.qr(light)[0], np.float32)
        self._seen = words_of_numbers() if resolution == 5 else np.zeros((0, 5, 5), bool)
        self._words = self._seen.reshape(-1, 25).astype(np.float32)
        self._words_t = np.ascontiguousarray(self._words.T)
        self._inside_line = grid.line[self._inside].astype(np.float32)
        self.region = int(self._inside.argmax()), int(self._inside.sum())  # first and number of the samples in a row

    def read(self, values: Floats, covariance: Covariance, noise: Floats) -> list[Reading]:
        """Return the best Reading of each marker of resolution 5.

        ``values`` (M, P) [greys] are those on the grid, ``covariance`` is the blur in cells. ``noise`` (M,) [greys] is
        the standard deviation of the values' noise, which does not reduce the fit.
        """
        if native.library:
            return self._read_compiled(native.library, values, covariance, noise)
        ex, ey = self._coverage(covariance)
        flat = self._region(values).reshape(len(values), -1)
        grey = (flat - (flat @ self._light) @ self._light.T).reshape(len(values), ey.shape[1], ex.shape[1])
        matched = (ey.transpose(0, 2, 1) @ grey @ ex).reshape(len(values), -1)
        return [self._number(*each) for each in zip(matched, grey, ex, ey, noise)]

    def _read_compiled(self, library: ctypes.CDLL, values: Floats, covariance: Covariance,
                       noise: Floats) -> list[Reading]:
        """Do the same as ``read`` with the compiled step of native/appearance.cpp."""
        grey, place = np.ascontiguousarray(self._region(values), np.float32), native.address
        variance, noise = np.array([covariance.xx, covariance.yy], np.float64), np.ascontiguousarray(noise, np.float64)
        out, words = np.empty((2, len(grey))), np.empty(len(grey), np.int64)
        library.alvar_read(len(grey), grey.shape[1], place(grey), place(self._inside_line), self.resolution,
                           place(self._light), place(NORMAL_STEP), place(variance), place(noise), len(self._words),
                           place(self._words_t), ctypes.c_double(thresholds.MAX_NOISE_SHARE), place(out), place(words))
        return [self.of_word(*each) for each in zip(words.tolist(), *out.tolist())]

    def compiled_arrays(self) -> tuple[Floats, ...]:
        """Return what native/appearance.cpp needs: the samples in a row [cells], light, words."""
        return self._inside_line, self._light, self._words_t

    def _coverage(self, covariance: Covariance) -> tuple[Floats, Floats]:
        """Return how much columns and rows of data cells cover each column and row of samples; each (M, S, n)."""
        inner = slice(self.margin, self.margin + self.resolution)
        both = np.concatenate([covariance.xx, covariance.yy])
        coverage = self.grid.profiles(both)[:, 0, self._inside, inner]
        return coverage[:len(covariance.xx)], coverage[len(covariance.xx):]

    def _region(self, values: Floats) -> Floats:
        side = self.grid.count
        return values.reshape(-1, side, side)[:, self._inside][:, :, self._inside]

    def _gram(self, ex: Floats, ey: Floats) -> Floats:
        n = self.resolution ** 2
        side = len(ex)
        rows = ey.T @ self._light.reshape(side, -1)
        light = (ex.T @ rows.reshape(-1, side, self._light.shape[1])).reshape(n, -1)
        product = ((ey.T @ ey)[:, None, :, None] * (ex.T @ ex)[None, :, None, :]).reshape(n, n)
        return product - light @ light.T

    def _number(self, matched: Floats, grey: Floats, ex: Floats, ey: Floats, noise: float) -> Reading:
        power = np.einsum('ij,ij->i', in_chunks(self._words, self._gram(ex, ey)), self._words)
        energy = without_noise(float((grey * grey).sum()), grey.size * float(noise) ** 2)
        fit = self._words @ matched / np.sqrt(np.maximum(power, 1e-6) * (energy + 1e-6))
        second, best = np.argpartition(fit, -2)[-2:]
        if fit[second] > fit[best]:
            second, best = best, second
        return self.of_word(best, fit[best], fit[best] - fit[second])

    def of_word(self, word: int, fit: float, gap: float) -> Reading:
        """Return the Reading of a code word (index turns * 256 + number)."""
        turns, number = divmod(int(word), 256)
        return Reading(code.Content(code.NUMBER, number, 0, turns), float(fit), float(gap), self._seen[word])

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
