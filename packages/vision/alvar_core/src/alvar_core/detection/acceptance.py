"""Measure features of aligned candidates, and decide which candidates are markers."""
from __future__ import annotations

from typing import Any, NamedTuple, Tuple

import numpy as np

from alvar_core import native
from alvar_core.arrays import ArrayLike, Floats, Integers
from alvar_core.detection import thresholds
from alvar_core.detection.alignment import Aligner, Alignment

UNREAD = 10 ** 6  # edges of cells that are not read
Shortfall = Tuple[str, float, float]  # the first threshold that a candidate misses, its value, what is needed
# Where the search for a candidate ended: its corners (4, 2) [real px], its Shortfall, the code word it resembles, or -1
Ended = Tuple[Floats, str, float, float, int]


class Features(NamedTuple):
    """The measured features of a candidate.

    * ``likeness``: correlation of the image with the drawn marker, up to 1
    * ``outside``: grey of the darkest of the four strips around the marker minus that of paper, divided by the contrast
    * ``outside_but_one``: the same for the second darkest strip
    * ``correlation``: of the data cells with the drawing, after smooth changes of brightness are removed
    * ``bad_inside``, ``bad_rim``: number of data cells and of border cells that differ from the drawing
    * ``inlier_share``: share of the samples that agree with the drawing (inliers)
    * ``contrast``, ``noise`` [greys]; ``blur``: variance [px^2 at the level]
    * ``fit``, ``score_gap``: as in Reading; ``edges``: number of edges between its black and white cells
    """

    likeness: float
    outside: float
    correlation: float
    bad_inside: int
    bad_rim: int
    inlier_share: float
    contrast: float
    noise: float
    blur: float
    fit: float = 0.0
    score_gap: float = 0.0
    edges: int = UNREAD
    outside_but_one: float = 0.0

    @classmethod
    def of_row(cls, row: Any) -> Features:
        """Return the Features in a record of the compiled steps."""
        return cls(**dict(zip(row.dtype.names, row.tolist())))


def edges(black: ArrayLike) -> Integers:
    """Return the number of edges between black and white cells of markers (..., n, n), bool, without the outer ones."""
    black = np.asarray(black, bool)
    count: Integers = ((black[..., 1:, :] != black[..., :-1, :]).sum((-2, -1))
                       + (black[..., 1:] != black[..., :-1]).sum((-2, -1)))
    return count


def shortfall(f: Features) -> Shortfall | None:
    """Return the first threshold that a candidate misses; None for a marker."""
    found: Shortfall | None = native.steps.shortfall(features=_compiled(f), limit=native.limit)
    return found


def may_be_covered(f: Features, fit: float) -> bool:
    """Return whether a candidate that these features reject may be a partly covered marker.

    ``fit``: that of its Reading.
    """
    return bool(native.steps.may_be_covered(features=_compiled(f._replace(fit=fit)), limit=native.limit))


def is_sure(f: Features) -> bool:
    """Return whether the code is too clear to be chance: the candidate is a marker even if its corners were wrong."""
    return bool(native.steps.is_sure(features=_compiled(f), limit=native.limit))


def unpromising(state: Alignment, m: int, likeness: float, cells: int) -> Shortfall | None:
    """Return the first threshold that aligned marker ``m`` misses before its cells are read, as ``shortfall`` does."""
    found: Shortfall | None = native.steps.unpromising(
        h=state.h[m], blur=state.blur[m], level=state.level[m], likeness=likeness, cells=cells, limit=native.limit)
    return found


def above(*checks: Shortfall) -> Shortfall | None:
    """Return the first of (threshold, value, what it must exceed) that does not hold; None if all do."""
    return next((each for each in checks if not each[1] > each[2]), None)


def _compiled(f: Features) -> Any:
    return native.steps.Features(**f._asdict())


class Appearance:
    """Compares aligned markers of one resolution and margin (cells) with their drawings.

    The methods take an Alignment of M markers; ``noise`` (M,) [greys] is the standard deviation of the values' noise.
    """

    def __init__(self, aligner: Aligner, resolution: int, margin: int) -> None:
        g, cells = aligner.grid, aligner.grid.cells
        data = np.flatnonzero(g.reach < -margin + 0.5)
        x, y = g.x[data], g.y[data]
        smooth = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1)
        half = cells / 2
        strip = (g.reach > 0) & (g.reach < 1 / thresholds.SAMPLES_PER_CELL)
        strips = [strip & (np.abs(beside) < half) & beyond for beside, beyond in
                  ((g.y, g.x < -half), (g.y, g.x > half), (g.x, g.y < -half), (g.x, g.y > half))]
        column, row = (np.floor(v + half) for v in (g.x, g.y))
        members = [(row == y) & (column == x) for y in range(cells) for x in range(cells)]
        group = np.full(len(g.x), -1)  # the cell, or the strip, that a sample counts in
        for k, each in enumerate(members + strips):
            group[each] = k
        self.steps = native.steps.Appearance(
            cells=cells, weight=float(aligner.fixed_weight.sum()), share=aligner.share, smooth=np.linalg.qr(smooth)[0],
            data=data, group=group, is_data=np.pad(np.ones((resolution, resolution), bool), margin).ravel())

    def features(self, state: Alignment, noise: Floats) -> list[Features]:
        """Return the Features of each marker, without those of its Reading.

        The likeness is NaN where the homography is not finite.
        """
        return [Features.of_row(row) for row in self.steps.features(state=state, noise=noise, limit=native.limit)]
