"""Measure the corners of aligned markers, and their covariance."""
from __future__ import annotations

import numpy as np

from alvar_core.arrays import Floats
from alvar_core.detection import homography, thresholds
from alvar_core.detection.alignment import Alignment
from alvar_core.detection.edge_refiner import EdgeRefiner
from alvar_core.detection.prepared_image import PreparedImage


class CornerEstimator:
    """Measures corners of markers with ``cells`` cells per side: by the alignment, and by the edges of large ones."""

    def __init__(self, cells: int) -> None:
        half = cells / 2
        self.cells = cells
        self.square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self._edges = EdgeRefiner(cells)
        self._homogeneous = np.concatenate([self.square, np.ones((4, 1))], 1)[:, :, None]
        # (4, 2 or 3, 8): derivative of the corners, before the homography, by its small changes (homography.small)
        self._jacobian_basis = np.array([(homography.small(np.eye(8)) @ p - p)[..., 0].T for p in self._homogeneous])

    def start(self, state: Alignment) -> Floats:
        """Return the corners (M, 4, 2) [ideal px] according to the alignment."""
        return homography.apply(state.h, self.square)

    def bow(self, image: PreparedImage, corners: Floats) -> Floats:
        """Return the second largest height [px] of a side's bow, (M,), of markers with corners (M, 4, 2) [ideal px]."""
        return self._edges.bow(image.pyramid, image.camera, homography.from_square(corners, self.cells / 2))

    def measure(self, image: PreparedImage, state: Alignment, corners: Floats,
                kept: Floats) -> tuple[Floats, Floats]:
        """Return the corners (M, 4, 2) [ideal px] and their inverse covariance (M, 8, 8) [1/px^2].

        ``corners`` are those of ``start``; they are changed in place. ``kept`` (M,): share of the samples that agree.
        """
        side = np.sqrt(homography.area(corners))
        covariance = self._covariance(state, side, kept)
        large = np.flatnonzero(side > thresholds.MIN_EDGE_SIDE)
        if len(large):
            sigma = np.sqrt(state.blur[large]) * 2.0 ** state.level[large]
            sharp, of_edges, good = self._edges.refine(image.pyramid, image.camera, state.h[large], sigma)
            moved = sharp - corners[large]
            good &= np.abs(moved).max((1, 2)) < thresholds.MAX_EDGE_MOVE * side[large] / self.cells
            large, moved = large[good], moved[good].reshape(-1, 8, 1)
            before = covariance[large]
            share = before @ np.linalg.inv(before + of_edges[good])  # weight of the edges
            corners[large] += (share @ moved).reshape(-1, 4, 2)
            floor = _floor(np.full(len(large), thresholds.CORNER_MODEL_ERROR))
            covariance[large] = before - share @ before + floor
        return corners, np.linalg.inv(covariance)

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
        h = state.h[:, None]
        p = h @ self._homogeneous  # (M, 4, 3, 1)
        jacobian = (h[:, :, :2] - p[:, :, :2] / p[:, :, 2:] * h[:, :, 2:]) / p[:, :, 2:] @ self._jacobian_basis
        jacobian = jacobian.reshape(-1, 8, 8)
        spread: Floats = jacobian @ state.spread() @ jacobian.transpose(0, 2, 1)
        return spread


def _floor(sigma: Floats) -> Floats:
    """Return the covariance (M, 8, 8) of corners with independent errors of ``sigma`` (M,) [px]."""
    return np.eye(8) * sigma[:, None, None] ** 2
