"""Measure features of aligned candidates, and decide which candidates are markers."""
from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
        self._share, self._weight = aligner.share, aligner.fixed_weight.sum()
        g, cells = aligner.grid, aligner.grid.cells
        self._data_samples = np.flatnonzero(g.reach < -margin + 0.5)
        x, y = g.x[self._data_samples], g.y[self._data_samples]
        self._smooth_basis = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1))[0]
        half = cells / 2
        strip = (g.reach > 0) & (g.reach < 1 / thresholds.SAMPLES_PER_CELL)
        strips = [strip & beyond for beyond in (g.x < -half, g.x > half, g.y < -half, g.y > half)]
        column, row = (np.floor(v + half) for v in (g.x, g.y))
        members = [(row == y) & (column == x) for y in range(cells) for x in range(cells)]
        chosen = np.array(members + strips)
        # (P, cells^2 + 4): turns samples into their means in each cell and in the four strips around the marker
        self._means = (chosen / chosen.sum(1, keepdims=True)).T.astype(np.float32)
        self._is_data = np.pad(np.ones((resolution, resolution), bool), margin).ravel()

    def likeness(self, state: Alignment, noise: Floats) -> Floats:
        """Return the normalised correlation (M,) of the image with the drawn marker, corrected for noise."""
        v = state.values - (state.values @ self._share)[:, None]
        t = state.template - (state.template @ self._share)[:, None]
        with np.errstate(invalid='ignore'):
            energy = without_noise((v * v) @ self._share, noise ** 2)
            likeness: Floats = ((v * t) @ self._share) / np.sqrt(energy * ((t * t) @ self._share) + 1e-6)
        return likeness

    def _detail(self, state: Alignment, noise: Floats) -> Floats:
        """Return the correlation (M,) of the data cells with their drawing, corrected for noise.

        Smooth changes of brightness, up to second order in x and y, are removed first.
        """
        both = np.concatenate([state.values, state.template]).take(self._data_samples, 1)
        both -= (both @ self._smooth_basis) @ self._smooth_basis.T
        v, t = both[:len(state.h)], both[len(state.h):]
        energy = without_noise((v * v).sum(1), len(self._data_samples) * noise ** 2)
        detail: Floats = (v * t).sum(1) / np.sqrt(energy * (t * t).sum(1) + 1e-6)
        return detail

    def features(self, state: Alignment, likeness: Floats, noise: Floats) -> list[Features]:
        """Return the Features of each marker, without those of its Reading."""
        means = ((state.values - state.model) / state.gain) @ self._means
        bad = np.abs(means[:, :-4]) > thresholds.BAD_CELL
        inside = bad[:, self._is_data].sum(1)
        columns = (likeness, means[:, -4:].min(1), self._detail(state, noise), inside, bad.sum(1) - inside,
                   state.weights.sum(1) / self._weight, state.contrast, state.noise, state.blur)
        return [Features(*row) for row in zip(*(column.tolist() for column in columns))]
