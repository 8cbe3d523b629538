"""Read markers that a lamp is reflected across, as in laminate: the black border shows how much light it adds.

Such glare is a straight stripe, and on the black border nothing but the stripe is bright. So the border gives the light
at each distance from a line along the stripe; without this light, cells are readable unless glare saturates both black
and white.
"""
from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

from alvar_core import code
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.detection import thresholds
from alvar_core.detection.acceptance import Shortfall, above
from alvar_core.detection.light import Light
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import words_of_numbers

PER_CELL, BINS = 6, 5  # samples, distances from the stripe, in each cell
COARSE, FINE = np.radians(np.arange(0, 180, 4)), np.radians(np.arange(-3, 4))


class WithoutGlare(NamedTuple):
    """A marker that was read: index of its code word, its fit, up to 1, and the ``image`` without the glare on it."""

    word: int
    fit: float
    image: PreparedImage


class _Stripe(NamedTuple):
    """A stripe of glare: the ``angle`` [rad] across it, and the ``light`` that it adds at ``places`` [cells] there."""

    angle: float
    places: Floats
    light: Floats

    def at(self, x: Floats, y: Floats) -> Floats:
        """Return the light that it adds at x, y [cells] of the marker."""
        found: Floats = np.interp(x * np.cos(self.angle) + y * np.sin(self.angle), self.places, self.light)
        return found


def may_be_there(image: PreparedImage) -> bool:
    """Return whether an image has saturated places."""
    return bool(image.grey.max() >= thresholds.SATURATED)


def likely(rim: Floats) -> Integers:
    """Return the indices of quads to read, best first; ``rim`` (N,): share of the rim that is an edge."""
    order = np.argsort(-rim)
    chosen: Integers = order[rim[order] > thresholds.MIN_GLARE_RIM][:thresholds.MAX_GLARE_READ]
    return chosen


class GlareReader:
    """Reads markers of resolution 5 and ``margin`` cells."""

    def __init__(self, margin: int) -> None:
        n, inner = code.MIN_RESOLUTION + 2 * margin, code.MIN_RESOLUTION / 2
        self._half, self._side = n / 2, n * PER_CELL
        line = (np.arange(self._side) + 0.5) / PER_CELL - self._half
        self._x, self._y = np.meshgrid(line, line)
        reach = np.maximum(np.abs(self._x), np.abs(self._y))
        self._border = (reach < self._half - 0.2) & (reach > inner + 0.2)
        within = [np.abs((v + inner) % 1 - 0.5) < 0.3 for v in (self._x, self._y)]
        self._data = (reach < inner) & within[0] & within[1]
        column, row = (np.floor(v[self._data] + inner).astype(int) for v in (self._x, self._y))
        self._cell = row * code.MIN_RESOLUTION + column
        self._in_cell = np.bincount(self._cell)
        self._words = words_of_numbers().reshape(-1, code.MIN_RESOLUTION ** 2).astype(np.float32)
        self._square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32) * self._side - np.float32(0.5)

    def read(self, image: PreparedImage, quad: Floats) -> WithoutGlare | tuple[Shortfall, int] | None:
        """Return the marker at a quad (4, 2) [real px], if a stripe fits its border and its code is sure.

        Else return the threshold that it misses and the word that it resembles, or -1; None without glare.
        """
        to_patch: Floats = np.asarray(cv2.getPerspectiveTransform(quad.astype(np.float32), self._square), float)
        grey = cv2.warpPerspective(image.grey, to_patch, (self._side, self._side))
        if (grey >= thresholds.SATURATED).mean() < thresholds.MIN_SATURATED:
            return None
        light = image.light.of(grey).astype(np.float32)
        saturated = float(image.light.of(np.full((1, 1), thresholds.SATURATED, np.uint8))[0, 0])
        border = light[self._border]
        black = float(np.percentile(border, 25))
        stripe = self._stripe(border, black)
        added = stripe.at(self._x, self._y)
        cells, data = light[self._data] - black, added[self._data]
        room = saturated - black - data  # more than black: up to here, white is seen
        even = cells - data
        white = float(np.percentile(even[room > 0], 85)) if (room > 0).any() else 0.0
        off = np.abs(border - black - added[self._border])[border < saturated]
        share, error = (each / max(white, 1.0) for each in (stripe.light.max(), off.mean() if len(off) else np.inf))
        missed = above(('MIN_GLARE_WHITE', white, thresholds.MIN_GLARE_WHITE),
                       ('MIN_GLARE', float(share), thresholds.MIN_GLARE))
        if missed is None and not error <= thresholds.MAX_GLARE_ERROR:
            missed = ('MAX_GLARE_ERROR', float(error), thresholds.MAX_GLARE_ERROR)
        if missed is not None:
            return missed, -1
        word, fit, missed = self._word(even / np.minimum(white, np.maximum(room, 1.0)),
                                       room > thresholds.MIN_GLARE_ROOM * white)
        if missed is not None:
            return missed, word
        return WithoutGlare(word, fit, self._without(image, to_patch, stripe))

    def _stripe(self, border: Floats, black: float) -> _Stripe:
        angle = 0.0
        for angles in (COARSE, FINE):
            angle += float(angles[np.argmin([self._spread(border, angle + each) for each in angles])])
        bins = self._bins(angle)
        places = np.unique(bins)
        order = np.argsort(bins, kind='stable')
        parts = np.split(border[order], np.flatnonzero(np.diff(bins[order])) + 1)
        light = np.array([max(float(np.median(part)) - black, 0.0) for part in parts])
        return _Stripe(angle, (places + 0.5) / BINS - 2 * self._half, light)

    def _bins(self, angle: float) -> Integers:
        across = self._x[self._border] * np.cos(angle) + self._y[self._border] * np.sin(angle)
        bins: Integers = np.floor((across + 2 * self._half) * BINS).astype(int)
        return bins

    def _spread(self, border: Floats, angle: float) -> float:
        """Return how much the light of the border varies along stripes at an angle, up to a constant."""
        bins = self._bins(angle)
        sums, counts = np.bincount(bins, border), np.bincount(bins)
        return -float((sums ** 2 / np.maximum(counts, 1)).sum())

    def _word(self, shares: Floats, seen: Bools) -> tuple[int, float, Shortfall | None]:
        """Return the best code word of samples (P,), 0 black to 1 white, of which some are ``seen``, and its fit.

        The Shortfall is None if the word is sure.
        """
        counts = np.bincount(self._cell[seen], minlength=len(self._in_cell))
        cells = np.bincount(self._cell[seen], np.clip(shares[seen], -0.3, 1.3), len(counts)) / np.maximum(counts, 1)
        known = counts > thresholds.MIN_GLARE_SEEN * self._in_cell
        error = ((self._words - cells) ** 2 * known).sum(1)
        best, next_one = np.argpartition(error, 1)[:2]
        missed = above(('MIN_GLARE_SCORE_GAP', float(error[next_one] - error[best]), thresholds.MIN_GLARE_SCORE_GAP))
        if missed is None and not error[best] <= thresholds.MAX_GLARE_MISFIT:
            missed = ('MAX_GLARE_MISFIT', float(error[best]), thresholds.MAX_GLARE_MISFIT)
        return int(best), 1 - float(error[best]) / max(int(known.sum()), 1), missed

    def _without(self, image: PreparedImage, to_patch: Floats, stripe: _Stripe) -> PreparedImage:
        """Return the image without the stripe on the marker and around it."""
        margin = 1.5 * PER_CELL * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], np.float32)
        patch = cv2.perspectiveTransform((self._square + margin)[None], np.linalg.inv(to_patch))[0]
        height, width = image.grey.shape
        left, top = np.maximum(np.floor(patch.min(0)), 0).astype(int)
        right, bottom = np.minimum(np.ceil(patch.max(0)), [width - 1, height - 1]).astype(int)
        u, v = np.meshgrid(np.arange(left, right + 1), np.arange(top, bottom + 1))
        x, y, w = np.tensordot(to_patch, np.stack([u, v, np.ones_like(u)]), 1)
        added = stripe.at((x / w + 0.5) / PER_CELL - self._half, (y / w + 0.5) / PER_CELL - self._half)
        grey = image.grey.copy()
        part = grey[top:bottom + 1, left:right + 1]
        part[:] = _less(image.light, part, added)
        return PreparedImage(grey, image.camera, None, image.light)


def _less(light: Light, grey: Image, added: Floats) -> Image:
    """Return greys without the light that is added to them."""
    less: Image = np.round(light.greys(np.clip(light.of(grey) - added, 0, 255))).astype(np.uint8)
    return less
