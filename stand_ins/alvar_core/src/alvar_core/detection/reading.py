"""Reading the cells of a marker: soft decisions against every code word of ALVAR's 5x5 numbers, or cell by cell."""
import functools
from dataclasses import dataclass

import cv2
import numpy as np

from alvar_core import code
from alvar_core.detection import homography

NOISE_SHARE = 0.3


def black_cells(white, margin):
    """(..., n + 2 margin,) squared black masks of markers with data cells `white` (..., n, n) bool."""
    white = np.asarray(white, bool)
    return np.pad(~white, [(0, 0)] * (white.ndim - 2) + [(margin, margin)] * 2, constant_values=True)


@functools.lru_cache(maxsize=1)
def words_of_numbers():
    """(1024, 5, 5) bool: row turns * 256 + number, as seen when numpy.rot90(seen, turns) stands upright."""
    upright = [code.encode(number) for number in range(256)]
    words = np.array([np.rot90(cells, -turns) for turns in range(4) for cells in upright])
    words.flags.writeable = False  # one for all
    return words


def in_chunks(a, b, limit=250000):
    """a @ b in pieces below the size from which OpenBLAS starts threads, whose start costs more than the product."""
    rows = max(1, limit // (b.shape[0] * b.shape[1]))
    if len(a) <= rows:
        return a @ b
    return np.concatenate([a[i:i + rows] @ b for i in range(0, len(a), rows)])


def without_noise(energy, noise):
    """Energy without the share that noise has in it; that share is never taken for more than NOISE_SHARE."""
    return energy - np.minimum(noise, NOISE_SHARE * energy)


@dataclass(frozen=True)
class Reading:
    """What was read: content (code.Content), fit 0..1, gap to the next best code word, cells as seen (n, n) bool."""

    content: object
    fit: float
    gap: float
    white: np.ndarray


@dataclass
class Look:
    """Of the quads with a dark rim: their indices, homographies, the best code word's fit, gap and index, contrast."""

    kept: np.ndarray
    h: np.ndarray
    fit: np.ndarray
    gap: np.ndarray
    word: np.ndarray
    contrast: np.ndarray


class Glance:
    """A first look at roughly placed quads: is the rim dark, and which code word do the cells resemble?

    One grey value a cell is read, of the data cells and one ring of the rim, and some along the outer edge.
    """

    ALONG = np.array([-0.75, -0.4, 0.0, 0.4, 0.75])
    DEPTHS = (0.4, -0.7)

    def __init__(self, resolution, margin, min_contrast=5.0, min_share=0.7):
        self.half = resolution / 2 + margin
        self.min_contrast, self.min_share = min_contrast, min_share
        n = resolution + 2
        line = np.arange(n) - (n - 1) / 2
        cells = np.stack([np.tile(line, n), np.repeat(line, n)], 1)
        self.rim, self.inner = (np.concatenate([p, np.ones((len(p), 1))], 1).T.astype(np.float32)
                                for p in (self._rim_points(), cells))
        self.seen = words_of_numbers() if resolution == 5 else None
        self._set_words(resolution)

    def _rim_points(self):
        points = []
        for depth in self.DEPTHS:
            x, y = self.ALONG * self.half, np.full(len(self.ALONG), -(self.half + depth))
            for _ in range(4):
                points.append(np.stack([x, y], 1))
                x, y = -y, x
        return np.concatenate(points)

    def _set_words(self, resolution):
        if resolution == 5:
            words, known = np.pad(self.seen, ((0, 0), (1, 1), (1, 1))), np.ones((1, 7, 7))
        else:
            mask, white = code.fixed_cells(resolution)
            words = np.array([np.rot90(np.pad(white, 1), -turns) for turns in range(4)])
            known = np.array([np.rot90(np.pad(mask, 1, constant_values=True), -turns) for turns in range(4)])
        self.known = known.reshape(len(known), -1).astype(np.float32)
        words = words.reshape(len(words), -1).astype(np.float32)
        words = (words - (words * self.known).sum(1, keepdims=True) / self.known.sum(1, keepdims=True)) * self.known
        self.words_t = np.ascontiguousarray((words / np.linalg.norm(words, axis=1, keepdims=True)).T)

    def look(self, smooth, quads):
        """Look at quads (N, 4, 2), real px, over a lightly smoothed picture."""
        h = homography.from_square(quads, self.half)
        rim = self._grey(smooth, h, self.rim).reshape(-1, 2, 4, len(self.ALONG))
        step = rim[:, 0] - rim[:, 1]
        contrast = np.sort(np.sort(step, 2)[:, :, len(self.ALONG) // 2], 1)[:, 1]
        step = step.reshape(len(step), -1)
        edge = (step > np.maximum(0.35 * contrast, 2.0)[:, None]).sum(1)
        kept = np.flatnonzero((contrast > self.min_contrast) & (edge > self.min_share * step.shape[1]))
        fit, gap, word = self._match(self._grey(smooth, h[kept], self.inner)) if len(kept) else (np.zeros(0),) * 3
        return Look(kept, h[kept], fit, gap, word, contrast[kept])

    def fit(self, smooth, quad, spread):
        """Fit of the best code word with the cells of one quad (4, 2), `spread` times as far apart."""
        h = homography.from_square(quad[None], self.half)
        return float(self._match(self._grey(smooth, h, self.inner * np.float32([[spread], [spread], [1]])))[0][0])

    def _grey(self, smooth, h, points):
        p = h.astype(np.float32) @ points
        inverse = 1 / p[:, 2]
        x, y = p[:, 0] * inverse, p[:, 1] * inverse
        return cv2.remap(smooth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(np.float32)

    def _match(self, grey):
        spread = (grey * grey) @ self.known.T - (grey @ self.known.T) ** 2 / self.known.sum(1)
        fit = in_chunks(grey, self.words_t) / np.sqrt(np.maximum(spread, 1.0))
        word = fit.argmax(1)
        rows = np.arange(len(fit))
        best = fit[rows, word]
        fit[rows, word] = -1
        return best, best - fit.max(1), word


class Reader:
    """Reads aligned markers of one resolution and margin (both in cells); `grid` is that of the aligned values."""

    def __init__(self, grid, resolution=5, margin=2):
        self.resolution, self.margin, self.grid = resolution, margin, grid
        reach = self.resolution / 2 + min(0.5, margin / 2)
        self.region = np.abs(self.grid.line) < reach
        x, y = (v.ravel() for v in np.meshgrid(grid.line[self.region], grid.line[self.region]))
        light = np.stack([np.ones_like(x), x, y, x * y], 1)
        self.light = np.linalg.qr(light)[0].astype(np.float32)
        if resolution == 5:
            self.seen = words_of_numbers()
            self.words = self.seen.reshape(1024, 25).astype(np.float32)

    def read(self, values, cov, noise):
        """The best Reading of each marker of resolution 5: grey values (M, P) on the grid; cov as align.covariance.

        noise (M,): standard deviation of the values' noise, which does not count against a reading.
        """
        ex, ey = self._coverage(cov)
        flat = self._region(values).reshape(len(values), -1)
        grey = (flat - (flat @ self.light) @ self.light.T).reshape(len(values), ey.shape[1], ex.shape[1])
        matched = (ey.transpose(0, 2, 1) @ grey @ ex).reshape(len(values), -1)
        return [self._number(*each) for each in zip(matched, grey, ex, ey, noise)]

    def _coverage(self, cov):
        inner = slice(self.margin, self.margin + self.resolution)
        coverage = self.grid.profiles(np.concatenate(cov[:2]))[:, 0, self.region, inner]
        return coverage[:len(cov[0])], coverage[len(cov[0]):]

    def _region(self, values):
        side = self.grid.count
        return values.reshape(-1, side, side)[:, self.region][:, :, self.region]

    def _gram(self, ex, ey):
        n = self.resolution ** 2
        side = len(ex)
        light = (ex.T @ (ey.T @ self.light.reshape(side, -1)).reshape(-1, side, self.light.shape[1])).reshape(n, -1)
        product = ((ey.T @ ey)[:, None, :, None] * (ex.T @ ex)[None, :, None, :]).reshape(n, n)
        return product - light @ light.T

    def _number(self, matched, grey, ex, ey, noise):
        power = np.einsum('ij,ij->i', in_chunks(self.words, self._gram(ex, ey)), self.words)
        energy = without_noise(float((grey * grey).sum()), grey.size * float(noise) ** 2)
        fit = self.words @ matched / np.sqrt(np.maximum(power, 1e-6) * (energy + 1e-6))
        second, best = np.argpartition(fit, -2)[-2:]
        if fit[second] > fit[best]:
            second, best = best, second
        return self.of_word(best, fit[best], fit[best] - fit[second])

    def of_word(self, word, fit, gap):
        """Reading of a code word (index turns * 256 + number)."""
        turns, number = divmod(int(word), 256)
        return Reading(code.Content(code.NUMBER, number, 0, turns), float(fit), float(gap), self.seen[word])

    def read_cells(self, shares, cov):
        """As read(), of any resolution, cell by cell: shares (M, P) are 0 where black and 1 where white paper is."""
        ex, ey = self._coverage(cov)
        grey = self._region(shares)
        matched = (ey.transpose(0, 2, 1) @ grey @ ex).reshape(len(shares), -1)
        return [self._cellwise(*each) for each in zip(matched, grey, ex, ey)]

    def _cellwise(self, matched, grey, ex, ey):
        n = self.resolution
        gram = ((ey.T @ ey)[:, None, :, None] * (ex.T @ ex)[None, :, None, :]).reshape(n * n, n * n)
        cells = np.linalg.solve(gram + np.eye(n * n) * 0.02 * np.trace(gram) / (n * n), matched)
        white = (cells > np.sort(cells)[-3:].mean() / 2).reshape(n, n)
        content = code.decode(white)
        upright = content and self._redrawn(content, white)
        if upright is None:
            return None
        white = np.rot90(upright, -content.turns)
        w = white.ravel().astype(np.float32)
        fit = w @ matched / np.sqrt(max(w @ gram @ w, 1e-6) * (float((grey * grey).sum()) + 1e-6))
        return Reading(content, float(fit), 1.0, white)

    def _redrawn(self, content, seen):
        """The upright cells of a marker of this content, of the drawings the nearest to what was seen; None if none."""
        drawings = []
        for strong in (False, True):
            try:
                drawings.append(code.encode(content.value, content.kind, strong, self.resolution))
            except code.CodeError:
                continue
        upright = np.rot90(seen, content.turns)
        drawings = [d for d in drawings if (d != upright).sum() <= 2]
        return min(drawings, key=lambda d: int((d != upright).sum()), default=None)
