"""Measure the outer edges of the black square of large markers, in the full-size image, with subpixel accuracy.

The alignment (alignment.py) reads large markers in a reduced image, with a few samples per cell, which limits its
accuracy. Here the grey is read across the four sides. The position of the step from black to white is computed from
the area under the grey values, which noise and blur change little. A robust least-squares fit gives the line of each
side, and the corners are the intersections. All functions work on a batch of M markers, in cells (see alignment.py)
unless px are stated; sides are counted clockwise from the upper one, corners from its left end.
"""
from __future__ import annotations

import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats
from alvar_core.camera import Camera
from alvar_core.detection.light import LINEAR, Light
from alvar_core.detection.pyramid import Pyramid


class EdgeRefiner:
    """Measures the outer edges of markers with ``cells`` cells per side."""

    def __init__(self, cells: int) -> None:
        self._cells = cells

    def bow(self, pyramid: Pyramid, camera: Camera, corners: Floats, light: Light = LINEAR) -> Floats:
        """Return the height [px] of the second largest bow of a side, (M,), by corners (M, 4, 2) [ideal px].

        Bent paper bends at least two sides; a crease, or an object that covers part of a side, bends only one. If the
        largest bow is much larger than the second, thresholds.BOW_OF_ONE weighs it. A bow within the noise counts 0.
        """
        bows: Floats = native.steps.bows(grey=pyramid.full, lens=camera.lens, corners=np.asarray(corners),
                                         cells=self._cells, light=light.steps, limit=native.limit)
        return bows
