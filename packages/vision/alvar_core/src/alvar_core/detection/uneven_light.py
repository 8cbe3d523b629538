"""Find markers in uneven light: local contrast decides the code, the edges of the cells give the corners."""
from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from alvar_core import code, native
from alvar_core.arrays import Bools, Floats
from alvar_core.detection import broken_outlines, candidates, edge_alignment, glare, homography, thresholds
from alvar_core.detection.acceptance import Ended, Shortfall, above, edges
from alvar_core.detection.detection import Detection
from alvar_core.detection.edge_alignment import EdgeFit, EdgePoints
from alvar_core.detection.glare import GlareReader, WithoutGlare
from alvar_core.detection.local_contrast import LocalDecoder
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import black_cells

_UNSEEN, _UNSURE = ('EDGES_SEEN', 0.0, thresholds.MIN_SEEN_EDGES), ('SAME_WORD', 0.0, 0.0)  # Shortfalls


class Found(NamedTuple):
    """A marker that was found.

    ``word``: index of its code word, ``fit`` and ``score_gap`` of that; ``corners`` (4, 2) [ideal px], their
    ``covariance`` (8, 8) [px^2]; ``thin``: the white margin is too narrow to measure the rim; ``image``: that
    without glare, if the marker was found there.
    """

    word: int
    fit: float
    score_gap: float
    corners: Floats
    covariance: Floats
    thin: bool
    image: PreparedImage | None = None

    @property
    def margin_ratio(self) -> float:
        """Return the score gap as a share of what the word leaves unexplained."""
        return self.score_gap / (thresholds.BEST_FIT - min(self.fit, 1.0))


class UnevenLight:
    """Finds markers of resolution 5 and ``margin`` cells."""

    def __init__(self, margin: int) -> None:
        self.decoder = LocalDecoder(margin)
        self.half = self.decoder.half
        self.margin, half = margin, self.half
        self._scale = edge_alignment.scale_of(half)
        self._inner_edges = edges(black_cells(self.decoder.words, margin))
        self._points: dict[tuple[int, str], EdgePoints] = {}  # of the code words seen so far
        self._square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self._glare_reader = GlareReader(margin)
        self._near, self._far = (self._rim_points(beyond) for beyond in (thresholds.RIM_NEAR, thresholds.RIM_FAR))

    @staticmethod
    def free_parts(image: PreparedImage, parts: Sequence[Floats], known: Sequence[Detection]) -> list[Floats]:
        """Return the straight parts (K, 2, 2) of each array that are edges and do not lie on a ``known`` marker."""
        free = [each[free_of(known, each.mean(1))] for each in parts]
        return [broken_outlines.distinct_parts(image.smooth, each) if len(each) else each for each in free]

    def find(self, image: PreparedImage, quads: Floats, parts: Sequence[Floats], known: Sequence[Detection] = (),
             ended: list[Ended] | None = None) -> list[Found]:
        """Return the markers among quads (N, 4, 2) [real px] and in the straight ``parts`` that are free.

        ``known`` markers are not searched for again. ``ended`` gets quads whose rim is good enough to be read, but that
        are no markers.
        """
        for each in parts:
            quads = np.concatenate([quads, broken_outlines.squares(each)])
        quads = quads[free_of(known, quads.mean(1))]
        if not len(quads):
            return []
        found = self._by_contrast(image, quads, ended)
        return found + self._in_glare(image, quads, found, ended)

    def _by_contrast(self, image: PreparedImage, quads: Floats, ended: list[Ended] | None) -> list[Found]:
        """Return the markers among quads (N, 4, 2) [real px] that local contrasts show."""
        h = homography.from_square(quads, self.half)
        rim, _ = self.decoder.rim(image.smooth, h)
        likely = np.flatnonzero(rim > thresholds.MIN_LOCAL_RIM)
        chosen = likely[np.argsort(-rim[likely])][:thresholds.MAX_LOCAL_READ]
        if not len(chosen):
            return []
        quads, h = quads[chosen], h[chosen]
        match = self.decoder.match(image.smooth, h)
        promising = []
        for m, (fit, score_gap, plain) in enumerate(zip(match.fit, match.score_gap, match.plain)):
            missed = above(('MIN_FIRST_PLAIN', plain, thresholds.MIN_FIRST_PLAIN),
                           ('MIN_FIRST_FIT', fit, thresholds.MIN_FIRST_FIT),
                           ('MIN_FIRST_SCORE_GAP', score_gap, thresholds.MIN_FIRST_SCORE_GAP))
            if missed is None:
                promising.append(m)
            elif ended is not None:
                ended.append((quads[m], *missed, int(match.word[m])))
        order = candidates.distinct(quads, match.fit, np.array(promising, int))[:thresholds.MAX_LOCAL]
        found: list[Found] = []
        for m in order:
            centre = quads[m].mean(0)
            if any(np.abs(each.corners.mean(0) - centre).max() < 0.4 * np.ptp(quads[m], 0).max() for each in found):
                continue
            one = self.aligned(image, quads[m], int(match.word[m]), ended=ended)
            if one is not None:
                found.append(one)
        return found

    def _in_glare(self, image: PreparedImage, quads: Floats, known: Sequence[Found],
                  ended: list[Ended] | None) -> list[Found]:
        """Return the markers at quads (N, 4, 2) [real px], away from known ones, after a stripe of glare is removed."""
        found: list[Found] = []
        if not glare.may_be_there(image):
            return found
        shown = self.decoder.contrasts(image.smooth, homography.from_square(quads, self.half), self._far)
        rim = (shown.reshape(len(quads), -1) > thresholds.MIN_LOCAL_CONTRAST).mean(1)
        for quad in quads[glare.likely(rim)]:
            if any(math.dist(each.corners.mean(0), quad.mean(0)) < thresholds.OVERLAP * np.ptp(quad, 0).max()
                   for each in [*known, *found]):
                continue
            seen = self._glare_reader.read(image, quad)
            if seen is None:
                continue
            if not isinstance(seen, WithoutGlare):
                if ended is not None:
                    ended.append((quad, *seen[0], seen[1]))
                continue
            one = self.aligned(seen.image, quad, seen.word, True, ended)
            if one is not None:
                found.append(one._replace(fit=seen.fit, score_gap=0.0, image=seen.image))
        return found

    def aligned(self, image: PreparedImage, quad: Floats, word: int, known: bool = False,
                ended: list[Ended] | None = None) -> Found | None:
        """Return the marker with a code word at a quad (4, 2) [real px]; None if its edges are not there.

        The word is not read again if it is ``known``. ``ended`` gets a quad that is no marker.
        """
        found = self._aligned(image, quad, word, known)
        if isinstance(found, Found):
            return found
        if ended is not None:
            ended.append((quad, *found, word))
        return None

    def _aligned(self, image: PreparedImage, quad: Floats, word: int, known: bool) -> Found | Shortfall:
        h = homography.from_square(image.camera.to_ideal(quad)[None], self.half)[0]
        for _ in range(3):
            fit = self._fit(image, h, word)
            if fit is None:
                return _UNSEEN
            h, result = fit
            again = self.decoder.match(image.smooth, self._real(image, h))
            if known or int(again.word[0]) == word:
                break
            word = int(again.word[0])
        else:
            return _UNSURE
        rim, thin = again.rim[0], self._is_thin(image, h)
        if thin:
            fitted = self._without_paper(image, h, word)
            if fitted is None:
                return _UNSEEN
            h, result, covariance = fitted
            again = self.decoder.match(image.smooth, self._real(image, h))
            if not known and int(again.word[0]) != word:
                return _UNSURE
            if result.seen < thresholds.THIN_MARGIN_RIM:
                return 'THIN_MARGIN_RIM', float(result.seen), thresholds.THIN_MARGIN_RIM
            rim = self._thin_rim(image, h)
        else:
            covariance = self._of_corners(h, result.covariance)
        margin_ratio = again.score_gap[0] / (thresholds.BEST_FIT - again.fit[0])
        missed = above(('LOCAL_PLAIN', again.plain[0], thresholds.LOCAL_PLAIN),
                       ('LOCAL_RIM', rim, thresholds.LOCAL_RIM),
                       ('MIN_SEEN_EDGES', result.seen, thresholds.MIN_SEEN_EDGES))
        if missed is None and not known:
            plain = [('PLAIN_LOCAL_FIT', again.fit[0], thresholds.PLAIN_LOCAL_FIT),
                     ('PLAIN_LOCAL_MARGIN_RATIO', margin_ratio, thresholds.PLAIN_LOCAL_MARGIN_RATIO)]
            missed = above(('LOCAL_FIT', again.fit[0], thresholds.LOCAL_FIT),
                           ('LOCAL_SCORE_GAP', again.score_gap[0], thresholds.LOCAL_SCORE_GAP),
                           ('LOCAL_MARGIN_RATIO', margin_ratio, thresholds.LOCAL_MARGIN_RATIO),
                           *(plain if self.is_plain(word) else ()))
        if missed is not None:
            return missed
        corners = homography.apply(h[None], self._square)[0]
        covariance = covariance + np.eye(8) * thresholds.CORNER_MODEL_ERROR ** 2
        return Found(word, float(again.fit[0]), float(again.score_gap[0]), corners, covariance, thin)

    def is_plain(self, word: int) -> bool:
        """Return whether dark things look like this code word by chance, so that its thresholds are higher."""
        return bool(self._inner_edges[word] <= thresholds.PLAIN_EDGES)

    def _of_corners(self, h: Floats, covariance: Floats) -> Floats:
        """Return the covariance (8, 8) [px^2] of the corners, from that of small changes of ``h``."""
        jacobian = homography.corner_derivative(h[None], self.half)[0]
        of_corners: Floats = jacobian @ covariance @ jacobian.T
        return of_corners

    def _without_paper(self, image: PreparedImage, h: Floats, word: int) -> tuple[Floats, EdgeFit, Floats] | None:
        """Return homography (3, 3), EdgeFit and covariance of the corners (8, 8) [px^2] with a thin white margin.

        Darkness beyond the margin moves all edges of the rim outward equally. So the rim gives the shape, the code the
        size.
        """
        inner = self._fit(image, h, word, 'code')
        outer = self._fit(image, h, word, 'rim', thresholds.THIN_MARGIN_REACH)
        if inner is None or outer is None:
            return None
        inside = self._square * (code.MIN_RESOLUTION / 2 / self.half)
        moved = inner[0] @ homography.small(np.concatenate([np.zeros((1, 8)), np.eye(8) * 1e-5]))
        size = homography.mean_side(homography.apply(moved, inside))
        by_change = (size[1:] / size[0] - 1) / 1e-5
        grown = size[0] / float(homography.mean_side(homography.apply(outer[0][None], inside))[0])
        h = outer[0] @ np.diag([grown, grown, 1.0])
        corners = homography.apply(h[None], self._square)[0]
        apart = (corners - corners.mean(0)).ravel()
        variance = by_change @ inner[1].covariance @ by_change
        return h, outer[1], self._of_corners(h, outer[1].covariance) + np.outer(apart, apart) * variance

    def _edges(self, word: int, which: str) -> EdgePoints:
        """Return the EdgePoints of a code word: those of its 'code', of its 'rim', or 'all'."""
        if (word, which) not in self._points:
            points = edge_alignment.edges_of_cells(black_cells(self.decoder.words[word], self.margin))
            if which != 'all':
                chosen = (np.abs(points.middle).max(1) == self.half) == (which == 'rim')
                points = EdgePoints(points.middle[chosen], points.outward[chosen])
            self._points[word, which] = points
        return self._points[word, which]

    def _rim_points(self, beyond: float) -> Floats:
        """Return homogeneous points (3, 2 E), E inside the rim and E ``beyond`` [cells] it."""
        line, sides = ((np.arange(6 * self.half) + 0.5) / 3 - self.half), []  # three for each cell, as contrasts() asks
        for reach in (self.half - thresholds.RIM_INSIDE, self.half + beyond):
            full = np.full(len(line), reach)
            sides += [[line, -full], [full, line], [line, full], [-full, line]]
        return np.ascontiguousarray(np.concatenate([[*side, np.ones(len(line))] for side in sides], 1), np.float32)

    def _beyond(self, image: PreparedImage, h: Floats, points: Floats) -> Floats:
        """Return the contrasts (E,) across the rim, from inside to beyond it."""
        return self.decoder.contrasts(image.smooth, self._real(image, h), points).ravel()

    def _is_thin(self, image: PreparedImage, h: Floats) -> bool:
        """Return whether the white margin is so narrow that darkness beyond it disturbs the edges of the rim."""
        near, far = (self._beyond(image, h, points) for points in (self._near, self._far))
        return bool((far < thresholds.THIN_MARGIN_STEP * np.median(near)).mean() > thresholds.THIN_MARGIN_SHARE)

    def _thin_rim(self, image: PreparedImage, h: Floats) -> float:
        """Return the share of the rim beyond which it is white."""
        near = self._beyond(image, h, self._near)
        least = max(thresholds.MIN_LOCAL_CONTRAST, thresholds.MIN_LOCAL_SHARE * float(np.median(near)))
        return float((near > least).mean())

    def _real(self, image: PreparedImage, h: Floats) -> Floats:
        if not image.camera.distorted:
            return h[None]
        corners = homography.apply(h[None], self._square)
        real = np.stack(image.camera.to_real(corners[..., 0], corners[..., 1]), -1)
        return homography.from_square(real, self.half)

    def _fit(self, image: PreparedImage, h: Floats, word: int, which: str = 'all',
             reach: float | None = None) -> tuple[Floats, EdgeFit] | None:
        """Return the homography (3, 3) after the alignment with edges, and the EdgeFit.

        ``reach`` [cells]: half the width that is read across an edge, thresholds.LOCAL_REACH by default.
        """
        reach = thresholds.LOCAL_REACH if reach is None else reach
        corners = homography.apply(h[None], self._square)
        longest = float(np.linalg.norm(np.roll(corners, -1, 1) - corners, axis=2).max())
        cell = float(homography.mean_side(corners)[0]) ** 2 / longest / (2 * self.half)  # its smaller width if tilted
        result = edge_alignment.fit_plane(image.grey, image.camera, h, self._edges(word, which), self._scale,
                                          min(reach * cell, thresholds.MAX_LOCAL_REACH), thresholds.LOCAL_STEPS,
                                          image.light)
        if result is None:
            return None
        return edge_alignment.changed(h, result.parameters), result


def free_of(known: Sequence[Detection], points: Floats) -> Bools:
    """Return which points (N, 2) [px] do not lie on a known marker."""
    if not known:
        return np.ones(len(points), bool)
    squares = [(*each.centre, thresholds.KNOWN_REACH * each.side) for each in known]
    free: Bools = native.steps.free_of(squares=squares, points=points)
    return free
