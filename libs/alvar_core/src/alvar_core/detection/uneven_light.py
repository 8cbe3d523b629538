"""Find markers in uneven light: local contrast decides the code, the edges of the cells give the corners."""
from __future__ import annotations

from typing import NamedTuple, Sequence

import numpy as np

from alvar_core.arrays import Bools, Floats
from alvar_core.detection import broken_outlines, candidates, edge_alignment, homography, thresholds
from alvar_core.detection.detection import Detection
from alvar_core.detection.edge_alignment import EdgeAligner, EdgeFit, EdgePoints
from alvar_core.detection.local_contrast import LocalDecoder
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import black_cells


class Found(NamedTuple):
    """A marker that was found.

    ``word``: index of its code word, ``fit`` and ``gap`` of that; ``corners`` (4, 2) [ideal px], their ``covariance``
    (8, 8) [px^2].
    """

    word: int
    fit: float
    gap: float
    corners: Floats
    covariance: Floats


class UnevenLight:
    """Finds markers of resolution 5 and ``margin`` cells."""

    def __init__(self, margin: int) -> None:
        self.decoder, self.aligner = LocalDecoder(margin), EdgeAligner()
        self.half = self.decoder.half
        self.margin, half = margin, self.half
        self._scale = edge_alignment.scale_of(half)
        self._square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])

    @staticmethod
    def free_parts(image: PreparedImage, parts: Sequence[Floats], known: Sequence[Detection]) -> list[Floats]:
        """Return the straight parts (K, 2, 2), of each of the arrays, that are edges and lie on no marker known."""
        free = [each[free_of(known, each.mean(1))] for each in parts]
        return [broken_outlines.distinct_parts(image.smooth, each) if len(each) else each for each in free]

    def find(self, image: PreparedImage, quads: Floats, parts: Sequence[Floats],
             known: Sequence[Detection] = ()) -> list[Found]:
        """Return the markers among quads (N, 4, 2) [real px] and in the straight ``parts`` that are free.

        Markers that are ``known`` are not searched for again.
        """
        for each in parts:
            quads = np.concatenate([quads, broken_outlines.squares(each)])
        quads = quads[free_of(known, quads.mean(1))]
        if not len(quads):
            return []
        h = homography.from_square(quads, self.half)
        rim, _ = self.decoder.rim(image.smooth, h)
        likely = np.flatnonzero(rim > thresholds.MIN_LOCAL_RIM)
        chosen = candidates.distinct(quads, rim, likely)[:2 * thresholds.MAX_LOCAL]
        if not chosen:
            return []
        quads, h = quads[chosen], h[chosen]
        match = self.decoder.match(image.smooth, h)
        likely = np.flatnonzero((match.fit > thresholds.MIN_FIRST_FIT) & (match.gap > thresholds.MIN_FIRST_GAP)
                                & (match.plain > thresholds.MIN_FIRST_PLAIN))
        order = likely[np.argsort(-match.fit[likely])][:thresholds.MAX_LOCAL].tolist()
        found: list[Found] = []
        for m in order:
            centre = quads[m].mean(0)
            if any(np.abs(each.corners.mean(0) - centre).max() < 0.4 * np.ptp(quads[m], 0).max() for each in found):
                continue
            one = self.aligned(image, quads[m], int(match.word[m]))
            if one is not None:
                found.append(one)
        return found

    def aligned(self, image: PreparedImage, quad: Floats, word: int) -> Found | None:
        """Return the marker with a code word at a quad (4, 2) [real px]; None if its edges are not there."""
        h = homography.from_square(image.camera.to_ideal(quad)[None], self.half)[0]
        for _ in range(3):
            fit = self._fit(image, h, word)
            if fit is None:
                return None
            h, result = fit
            again = self.decoder.match(image.smooth, self._real(image, h))
            if int(again.word[0]) == word:
                break
            word = int(again.word[0])
        else:
            return None
        surplus = again.gap[0] / (thresholds.BEST_FIT - again.fit[0])
        # a rim of which each edge agrees may have a thin margin: what is beyond is darker again
        outer = np.abs(self._edges(word).middle).max(1) == self.half
        rim = again.rim[0] > thresholds.LOCAL_RIM or (again.fit[0] > thresholds.THIN_MARGIN_FIT
                                                      and result.agrees[outer].mean() > thresholds.THIN_MARGIN_RIM)
        shown = again.plain[0] > thresholds.LOCAL_PLAIN and rim and result.seen > thresholds.MIN_SEEN_EDGES
        good = (again.fit[0] > thresholds.LOCAL_FIT and again.gap[0] > thresholds.LOCAL_GAP
                and surplus > thresholds.LOCAL_SURPLUS and shown)
        if not good:
            return None
        corners = homography.apply(h[None], self._square)[0]
        moves = homography.apply(h @ homography.small(np.eye(8) * 1e-5), self._square) - corners
        jacobian = moves.reshape(8, 8).T / 1e-5
        covariance = jacobian @ result.covariance @ jacobian.T + np.eye(8) * thresholds.CORNER_MODEL_ERROR ** 2
        return Found(word, float(again.fit[0]), float(again.gap[0]), corners, covariance)

    def _edges(self, word: int) -> EdgePoints:
        return edge_alignment.edges_of_cells(black_cells(self.decoder.words[word], self.margin))

    def _real(self, image: PreparedImage, h: Floats) -> Floats:
        if not image.camera.distorted:
            return h[None]
        corners = homography.apply(h[None], self._square)
        real = np.stack(image.camera.to_real(corners[..., 0], corners[..., 1]), -1)
        return homography.from_square(real, self.half)

    def _fit(self, image: PreparedImage, h: Floats, word: int) -> tuple[Floats, EdgeFit] | None:
        """Return the homography (3, 3) after the alignment with the edges, and the EdgeFit."""
        corners = homography.apply(h[None], self._square)
        cell = float(homography.mean_side(corners)[0]) / (2 * self.half)
        reach = min(thresholds.LOCAL_REACH * cell, thresholds.MAX_LOCAL_REACH)
        result = self.aligner.fit(image.grey, image.camera, edge_alignment.Plane(h), np.zeros((1, 8)),
                                  self._edges(word), self._scale, reach, thresholds.LOCAL_STEPS)[0]
        if result is None:
            return None
        return edge_alignment.changed(h, result.parameters), result


def free_of(known: Sequence[Detection], points: Floats) -> Bools:
    """Return which points (N, 2) [px] lie on no marker that is known."""
    free = np.ones(len(points), bool)
    for each in known:
        free &= np.abs(points - each.centre).max(1) > thresholds.KNOWN_REACH * each.side
    return free
