"""Measure features of aligned candidates, and decide which candidates are markers."""
from __future__ import annotations

import ctypes
from typing import Any, NamedTuple

import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats
from alvar_core.detection import thresholds
from alvar_core.detection.alignment import Aligner, Alignment
from alvar_core.detection.reading import without_noise
from alvar_core.detection.thresholds import Demand


class Features(NamedTuple):
    """The measured features of a candidate.

    * ``likeness``: correlation of the image with the drawn marker, up to 1
    * ``outside``: grey of the darkest of the four strips around the marker minus that of paper, divided by the contrast
    * ``detail``: likeness of the data cells, after smooth changes of brightness are removed
    * ``bad_inside``, ``bad_rim``: number of data cells and of border cells that differ from the drawing
    * ``kept``: share of the samples that agree with the drawing
    * ``contrast``, ``noise`` [greys]; ``blur``: variance [px^2 at the level]
    * ``fit``, ``gap``: those of the Reading
    """

    likeness: float
    outside: float
    detail: float
    bad_inside: int
    bad_rim: int
    kept: float
    contrast: float
    noise: float
    blur: float
    fit: float = 0.0
    gap: float = 0.0

    @classmethod
    def of_row(cls, row: Floats) -> Features:
        """Return those of a row of native/detector.cpp."""
        likeness, outside, detail, inside, rim, *rest = row.tolist()
        return cls(likeness, outside, detail, int(inside), int(rim), *rest)


def demand(f: Features) -> Demand:
    """Return the Demand for a candidate: higher if the likeness is low or cells are covered."""
    if f.bad_inside >= thresholds.CODE_COVERED_CELLS and f.gap > thresholds.WIDE_GAP:
        return thresholds.CODE_COVERED
    if f.bad_rim + 2 * f.bad_inside >= thresholds.COVERED_CELLS:
        return thresholds.COVERED
    return thresholds.CLEAR if f.likeness > thresholds.CLEAR_LIKENESS else thresholds.UNLIKE


def accepted(f: Features) -> bool:
    """Return whether a candidate with these features is a marker."""
    asked, sure = demand(f), thresholds.SURE
    surplus = f.gap / (thresholds.BEST_FIT - min(f.fit, 1.0))
    if f.fit > sure.fit and surplus > sure.surplus and f.detail > sure.detail:
        # of bent paper only the middle agrees with the drawing
        return f.kept > thresholds.SURE_KEPT and f.outside > thresholds.SURE_OUTSIDE
    return (f.gap > thresholds.MIN_GAP and f.kept > thresholds.MIN_KEPT and f.bad_rim <= thresholds.MAX_BAD_RIM
            and (f.outside > thresholds.MIN_OUTSIDE or f.likeness > thresholds.WHOLE_LIKENESS)
            and f.fit > asked.fit and surplus > asked.surplus and f.detail > asked.detail)


def may_be_covered(f: Features, fit: float) -> bool:
    """Return whether a candidate with these features, which is no marker by them, may be one that is partly covered.

    ``fit``: that of its Reading.
    """
    return (f.kept > thresholds.MIN_KEPT and f.bad_rim <= thresholds.MAX_BAD_RIM and f.bad_rim + f.bad_inside > 0
            and f.outside > thresholds.MIN_OUTSIDE and fit > thresholds.CHANGED_FIT)


class Appearance:
    """Compares aligned markers of one resolution and margin (cells) with their drawings.

    The methods take an Alignment of M markers; ``noise`` (M,) [greys] is the standard deviation of the values' noise.
    """

    def __init__(self, aligner: Aligner, resolution: int, margin: int) -> None:
        self._share, self.weight = aligner.share, float(aligner.fixed_weight.sum())
        g, self._cells = aligner.grid, aligner.grid.cells
        cells = self._cells
        self.data_samples = np.flatnonzero(g.reach < -margin + 0.5)
        x, y = g.x[self.data_samples], g.y[self.data_samples]
        smooth = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)
        self._smooth_basis = np.ascontiguousarray(np.linalg.qr(smooth)[0], np.float32)
        half = cells / 2
        strip = (g.reach > 0) & (g.reach < 1 / thresholds.SAMPLES_PER_CELL)
        strips = [strip & (np.abs(beside) < half) & beyond for beside, beyond in
                  ((g.y, g.x < -half), (g.y, g.x > half), (g.x, g.y < -half), (g.x, g.y > half))]
        column, row = (np.floor(v + half) for v in (g.x, g.y))
        members = [(row == y) & (column == x) for y in range(cells) for x in range(cells)]
        chosen = np.array(members + strips)
        # (P, cells^2 + 4): turns samples into their means in each cell and in the four strips around the marker
        self._means = (chosen / chosen.sum(1, keepdims=True)).T.astype(np.float32)
        self._group = np.full(len(g.x), -1, np.int32)  # the row of _means that a sample counts in
        for k, each in enumerate(chosen):
            self._group[each] = k
        self._is_data = np.pad(np.ones((resolution, resolution), bool), margin).ravel()

    def features(self, state: Alignment, noise: Floats) -> list[Features]:
        """Return the Features of each marker, without those of its Reading.

        The likeness is not a number where the homography is none.
        """
        columns = (self._compiled(native.library, state, noise) if native.library
                   else self._in_numpy(state, noise))
        rows = zip(*(column.tolist() for column in (*columns, state.contrast, state.noise, state.blur)))
        return [Features(likeness, outside, detail, int(inside), int(rim), *rest)
                for likeness, detail, outside, inside, rim, *rest in rows]

    def compiled_arrays(self) -> tuple[Any, ...]:
        """Return what native/appearance.cpp needs: shares, functions of the data cells, their samples, groups, data."""
        return self._share, self._smooth_basis, self.data_samples, self._group, self._is_data

    def _compiled(self, library: ctypes.CDLL, state: Alignment, noise: Floats) -> Floats:
        """Do the same as ``_in_numpy`` with the compiled step of native/appearance.cpp."""
        count, place, noise = len(state.h), native.address, np.ascontiguousarray(noise, np.float64)
        samples = [np.ascontiguousarray(each) for each in
                   (state.values, state.template, state.model, state.gain, state.weights, self._share)]
        out = np.empty((6, count))
        library.alvar_features(
            count, len(self._share), *map(place, samples), ctypes.c_double(self.weight), place(noise),
            len(self.data_samples), place(self.data_samples), place(self._smooth_basis), self._cells,
            place(self._group), place(self._is_data), ctypes.c_double(thresholds.MAX_NOISE_SHARE),
            ctypes.c_double(thresholds.BAD_CELL), place(out))
        return out

    def _in_numpy(self, state: Alignment, noise: Floats) -> tuple[Floats, ...]:
        """Return likeness, detail, outside, bad_inside, bad_rim and kept, each (M,)."""
        with np.errstate(invalid='ignore'):
            means = ((state.values - state.model) / state.gain) @ self._means
            bad = np.abs(means[:, :-4]) > thresholds.BAD_CELL
            inside = bad[:, self._is_data].sum(1)
            return (self._likeness(state, noise), self._detail(state, noise), means[:, -4:].min(1), inside,
                    bad.sum(1) - inside, state.weights.sum(1) / self.weight)

    def _likeness(self, state: Alignment, noise: Floats) -> Floats:
        """Return the normalised correlation (M,) of the image with the drawn marker, corrected for noise."""
        v = state.values - (state.values @ self._share)[:, None]
        t = state.template - (state.template @ self._share)[:, None]
        energy = without_noise((v * v) @ self._share, noise ** 2)
        likeness: Floats = ((v * t) @ self._share) / np.sqrt(energy * ((t * t) @ self._share) + 1e-6)
        return likeness

    def _detail(self, state: Alignment, noise: Floats) -> Floats:
        """Return the correlation (M,) of the data cells with their drawing, corrected for noise.

        Smooth changes of brightness, up to second order in x and y, are removed first.
        """
        both = np.concatenate([state.values, state.template]).take(self.data_samples, 1)
        both -= (both @ self._smooth_basis) @ self._smooth_basis.T
        v, t = both[:len(state.h)], both[len(state.h):]
        energy = without_noise((v * v).sum(1), len(self.data_samples) * noise ** 2)
        detail: Floats = (v * t).sum(1) / np.sqrt(energy * (t * t).sum(1) + 1e-6)
        return detail
