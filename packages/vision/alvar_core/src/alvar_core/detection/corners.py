"""Measure the corners of aligned markers, and their covariance.

The alignment (alignment.py) reads large markers in a reduced image, with a few samples per cell, which limits its
accuracy. Here the grey is read in the full-size image across the four sides of the black square. The position of the
step from black to white is computed from the area under the grey values, which noise and blur change little. A robust
least-squares fit gives the line of each side, and the corners are the intersections. Sides are counted clockwise from
the upper one, corners from its left end.
"""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats, Image
from alvar_core.detection import edge_alignment, homography
from alvar_core.detection.alignment import Aligner, Alignment
from alvar_core.detection.prepared_image import PreparedImage


def corners_seen(light: Image | Floats, corners: Floats, reaches: Sequence[int]) -> Floats | None:
    """Return the exact corners (4, 2) [real px] of a dark quadrilateral near approximate ``corners``.

    Each is measured alone, within each of ``reaches`` [px] in turn. Return None if one of them is not found, or lies
    outside of the image.
    """
    found: Floats = np.asarray(corners, np.float32).reshape(-1, 1, 2)
    until = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 30, 0.01)
    for reach in reaches:
        before = found.copy()
        if not ((found >= 0) & (found <= np.subtract(light.shape[::-1], 1))).all():
            return None
        cv2.cornerSubPix(light, found, (reach, reach), (-1, -1), until)  # in place
        if (found == before).all(2).any():  # cornerSubPix leaves a corner that it does not find
            return None
    return found.reshape(-1, 2).astype(np.float64)


class CornerEstimator:
    """Measures corners of markers with ``cells`` cells per side.

    Each large one is measured three times: by the alignment, by its outer edges and by the edges of all its cells. The
    mean weighted by the covariances is more exact than each of them.
    """

    def __init__(self, cells: int) -> None:
        half = cells / 2
        self.cells = cells
        self.square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self.scale = edge_alignment.scale_of(half)

    def start(self, state: Alignment) -> Floats:
        """Return the corners (M, 4, 2) [ideal px] according to the alignment."""
        return homography.apply(state.h, self.square)

    def bow(self, image: PreparedImage, corners: Floats) -> Floats:
        """Return the height [px] of the second largest bow of a side, (M,), by corners (M, 4, 2) [ideal px].

        Bent paper bends at least two sides; a crease, or an object that covers part of a side, bends only one. If the
        largest bow is much larger than the second, thresholds.BOW_OF_ONE weighs it. A bow within the noise counts 0.
        """
        bows: Floats = native.steps.bows(grey=image.pyramid.full, lens=image.camera.lens, corners=np.asarray(corners),
                                         cells=self.cells, light=image.light.steps, limit=native.limit)
        return bows

    def measure(self, image: PreparedImage, aligner: Aligner, state: Alignment, corners: Floats,
                black: Bools, inlier_share: Floats) -> tuple[Floats, Floats]:
        """Return the corners (M, 4, 2) [ideal px] and their inverse covariance (M, 8, 8) [1/px^2].

        ``aligner`` has made the ``state``; ``corners`` are those of ``start``. ``black`` (M, n, n): the cells of the
        markers; ``inlier_share`` (M,): share of the samples that agree.
        """
        found: tuple[Floats, Floats] = native.steps.measure_corners(
            aligner=aligner.steps, **image.pyramid.memory, full=image.pyramid.full, lens=image.camera.lens,
            light=image.light.steps, state=state, black=black, inlier_share=inlier_share, scale=self.scale,
            corners=corners, limit=native.limit)
        return found
