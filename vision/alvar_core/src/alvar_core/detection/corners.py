"""Measure the corners of aligned markers, and their covariance."""
from __future__ import annotations

import ctypes

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats
from alvar_core.detection import edge_alignment, edge_refiner, homography, thresholds
from alvar_core.detection.alignment import Alignment
from alvar_core.detection.edge_alignment import EdgeAligner, EdgePoints, Plane, changed
from alvar_core.detection.edge_refiner import EdgeRefiner
from alvar_core.detection.prepared_image import PreparedImage


class CornerEstimator:
    """Measures corners of markers with ``cells`` cells per side.

    Each large one is measured three times: by the alignment, by its outer edges and by the edges of all its cells. The
    mean weighted by the covariances is more exact than each of them.
    """

    def __init__(self, cells: int) -> None:
        half = cells / 2
        self.cells = cells
        self.square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self._edges, self._aligner = EdgeRefiner(cells), EdgeAligner()
        self._scale = edge_alignment.scale_of(half)

    def start(self, state: Alignment) -> Floats:
        """Return the corners (M, 4, 2) [ideal px] according to the alignment."""
        return homography.apply(state.h, self.square)

    def bow(self, image: PreparedImage, corners: Floats) -> Floats:
        """Return the second largest height [px] of a side's bow, (M,), of markers with corners (M, 4, 2) [ideal px]."""
        return self._edges.bow(image.pyramid, image.camera, corners)

    def measure(self, image: PreparedImage, state: Alignment, corners: Floats,
                black: Bools, kept: Floats) -> tuple[Floats, Floats]:
        """Return the corners (M, 4, 2) [ideal px] and their inverse covariance (M, 8, 8) [1/px^2].

        ``corners`` are those of ``start``; they are changed in place. ``black`` (M, n, n): the cells of the markers;
        ``kept`` (M,): share of the samples that agree.
        """
        compiled = native.library_for(image.camera)
        if compiled:
            return self._measure_compiled(*compiled, image, state, corners, black, kept)
        side = np.sqrt(homography.area(corners))
        covariance = self._covariance(state, side, kept)
        large = np.flatnonzero(side > thresholds.MIN_EDGE_SIDE)
        moved = np.zeros(len(corners), bool)
        if len(large):
            sigma = np.sqrt(state.blur[large]) * 2.0 ** state.level[large]
            sharp, of_edges, good = self._edges.refine(image.pyramid, image.camera, state.h[large], sigma)
            for m, *seen in zip(large[good], sharp[good], of_edges[good]):
                moved[m] |= self._combine(corners[m], covariance[m], *seen)
        for m in large:
            of_cells = self._by_cells(image, corners[m], edge_alignment.edges_of_cells(black[m]))
            moved[m] |= of_cells is not None and self._combine(corners[m], covariance[m], *of_cells)
        covariance[moved] += _floor(np.full(moved.sum(), thresholds.CORNER_MODEL_ERROR))
        return corners, np.linalg.inv(covariance)

    def _by_cells(self, image: PreparedImage, corners: Floats, points: EdgePoints) -> tuple[Floats, Floats] | None:
        """Return the corners (4, 2) according to the edges of all cells and their covariance (8, 8), or None."""
        h = homography.from_square(corners[None], self.cells / 2)[0]
        cell = float(homography.mean_side(corners[None])[0]) / self.cells
        reach = min(thresholds.LOCAL_REACH * cell, thresholds.MAX_LOCAL_REACH)
        fit = self._aligner.fit(image.grey, image.camera, Plane(h), np.zeros((1, 8)), points, self._scale, reach,
                                thresholds.CELL_STEPS, reach)[0]
        if fit is None or fit.seen <= thresholds.MIN_SEEN_EDGES:
            return None
        h = changed(h, fit.parameters)[None]
        jacobian = homography.corner_derivative(h, self.cells / 2)[0]
        covariance = jacobian @ fit.covariance @ jacobian.T * thresholds.CELL_VARIANCE
        return homography.apply(h, self.square)[0], covariance

    def _combine(self, corners: Floats, covariance: Floats, sharp: Floats, of_sharp: Floats) -> bool:
        """Change corners (4, 2) and their covariance (8, 8) to the weighted mean with others; False if too far off."""
        move = sharp - corners
        reach = thresholds.MAX_EDGE_MOVE * np.sqrt(homography.area(corners[None])[0]) / self.cells
        if not np.abs(move).max() < reach:
            return False
        share = covariance @ np.linalg.inv(covariance + of_sharp)
        corners += (share @ move.ravel()).reshape(4, 2)
        covariance -= share @ covariance
        return True

    def _measure_compiled(self, library: ctypes.CDLL, lens: Floats, image: PreparedImage, state: Alignment,
                          corners: Floats, black: Bools, kept: Floats) -> tuple[Floats, Floats]:
        """Do the same as ``measure`` with the compiled step of native/corners.cpp."""
        information, place = np.empty((len(corners), 8, 8)), native.address
        blur, noise, share = np.array([state.blur, state.noise, kept], np.float64)
        constants = self.compiled_arrays()
        corners, cells = np.ascontiguousarray(corners), np.ascontiguousarray(black)
        h, level, normal = (np.ascontiguousarray(each) for each in (state.h, state.level, state.normal))
        library.alvar_measure_corners(
            *native.image(image.pyramid.full), place(lens), len(corners), self.cells, place(h), place(blur),
            place(level), place(noise), place(share), place(normal), place(cells), *map(place, constants),
            place(corners), place(information))
        return corners, information

    def compiled_arrays(self) -> tuple[Floats, ...]:
        """Return what native/corners.cpp needs: scale of changes, limits of outer edges, of all edges, of corners."""
        return self._scale, edge_refiner.compiled_limits(), edge_alignment.compiled_limits(), np.array([
            thresholds.SAMPLES_PER_CELL, thresholds.MIN_EDGE_SIDE, thresholds.MAX_EDGE_MOVE,
            thresholds.CORNER_MODEL_ERROR, thresholds.ALIGNED_ERROR, thresholds.MISFIT_ERROR,
            thresholds.COARSE_CORNER_ERROR, thresholds.CORNER_NOISE_FACTOR, thresholds.LOCAL_REACH,
            thresholds.MAX_LOCAL_REACH, thresholds.CELL_STEPS, thresholds.MIN_SEEN_EDGES, thresholds.CELL_VARIANCE])

    def _covariance(self, state: Alignment, side: Floats, kept: Floats) -> Floats:
        """Return the covariance (M, 8, 8) [px^2] of the aligned corners; ``side`` (M,) [px] is that of the markers."""
        noise = np.maximum(state.noise, 1.0)[:, None, None]
        coarse = thresholds.COARSE_CORNER_ERROR * (side / self.cells / thresholds.SAMPLES_PER_CELL) ** 2
        covariance: Floats = self._spread(state) * (thresholds.CORNER_NOISE_FACTOR * noise ** 2)
        misfit = np.maximum(thresholds.ALIGNED_ERROR, thresholds.MISFIT_ERROR * (1 - kept))
        covariance += _floor(np.maximum(misfit * 2.0 ** state.level, coarse))
        return covariance

    def _spread(self, state: Alignment) -> Floats:
        """Return the covariance (M, 8, 8) of the corners [ideal px] for noise 1."""
        jacobian = homography.corner_derivative(state.h, self.cells / 2)
        spread: Floats = jacobian @ state.spread() @ jacobian.transpose(0, 2, 1)
        return spread


def _floor(sigma: Floats) -> Floats:
    """Return the covariance (M, 8, 8) of corners with independent errors of ``sigma`` (M,) [px]."""
    return np.eye(8) * sigma[:, None, None] ** 2
