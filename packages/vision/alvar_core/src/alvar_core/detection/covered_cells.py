"""Read partly covered markers: compare only the cells that are certainly visible.

Any two code words differ in at least four cells, so a word stays unique with up to three unknown cells. Cells count as
covered if they are neither black nor white, or if they lie next to a part of the border that is not black, because an
object that covers cells crosses the border, too.
"""
from __future__ import annotations

from typing import Iterator, NamedTuple

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats
from alvar_core.detection import thresholds
from alvar_core.detection.alignment import Covariance, Grid
from alvar_core.detection.reading import words_of_numbers

NEIGHBOURS = np.ones((3, 3), np.uint8)


class CoveredReading(NamedTuple):
    """The index of a code word, the largest difference of an uncovered cell from it, and the score gap.

    The score gap is that to the next word, a difference of sums of squares.
    """

    word: int
    error: float
    score_gap: float


class CoveredReader:
    """Reads aligned markers of resolution 5 and ``margin`` cells; ``grid`` is that of the aligned values."""

    def __init__(self, grid: Grid, margin: int) -> None:
        self._grid, half = grid, grid.cells / 2
        self._inside = np.abs(grid.line) < half - margin + 1
        self._cells = grid.cells - 2 * margin + 2  # of the data, and one of the border on each side
        self._words = words_of_numbers().reshape(-1, 25).astype(np.float32)

    def read(self, shares: Floats, noise: float, blur: Covariance) -> CoveredReading | None:
        """Return the reading with the fewest unknown cells that is sure; None if there is none.

        ``shares`` (P,) are the samples, 0 black to 1 white, ``noise`` is their standard deviation; ``blur`` has one
        value in each field.
        """
        side = self._grid.count
        grey = shares.reshape(side, side)[self._inside][:, self._inside]
        profiles = native.steps.coverage(line=self._grid.line[self._inside], cells=self._cells,
                                         variance=[blur.yy, blur.xx])
        by_row, by_column = (_pseudo_inverse(each) for each in profiles)
        cells = by_row @ grey @ by_column.T
        low, high = thresholds.ODD_CELL
        spare = min(max(thresholds.ODD_NOISE * noise, low), high)
        places = ((grey < -spare) | (grey > 1 + spare)).astype(np.float32)
        odd = (profiles[0].T @ places @ profiles[1] > thresholds.ODD_PLACES) | (cells < -high) | (cells > 1 + high)
        data = cells[1:-1, 1:-1].ravel().astype(np.float32)
        for unknown in _unknown(cells, odd[1:-1, 1:-1]):
            known = ~unknown.ravel()
            if known.sum() < thresholds.MIN_UNCOVERED:
                return None
            # the part of (w - d)^2 that depends on w, which is 0 or 1
            cost = self._words @ (known * (1 - 2 * data))
            best = int(cost.argmin())
            error = float((np.abs(self._words[best] - data) * known).max())
            if error < thresholds.MAX_UNCOVERED_ERROR:
                least, cost[best] = float(cost[best]), np.inf
                score_gap = float(cost.min()) - least
                if score_gap > thresholds.MIN_UNCOVERED_SCORE_GAP:
                    return CoveredReading(best, error, score_gap)
        return None


def _unknown(cells: Floats, odd: Bools) -> Iterator[Bools]:
    """Yield which of the data cells (5, 5) may be covered, fewest first: ``odd`` ones, then those near the border.

    ``cells`` (7, 7) have one of the border on each side.
    """
    yield odd
    between = odd | (np.abs(cells[1:-1, 1:-1] - 0.5) < thresholds.BETWEEN_CELL)
    yield between
    reached = np.abs(cells) > thresholds.COVERED_BORDER
    reached[1:-1, 1:-1] = False
    for _ in range(thresholds.COVERED_DEPTH):
        reached = cv2.dilate(reached.astype(np.uint8), NEIGHBOURS) > 0
        yield between | reached[1:-1, 1:-1]


def _pseudo_inverse(coverage: Floats) -> Floats:
    gram = coverage.T @ coverage
    inverse: Floats = np.linalg.solve(gram + thresholds.CELL_RIDGE * np.trace(gram) / len(gram) * np.eye(len(gram)),
                                      coverage.T)
    return inverse
