"""Find candidates: quadrilaterals in a grey image that could be the black square of a marker.

Quads are (4, 2) real pixel corners, clockwise in the image (for an upright marker: top left, top right, bottom right,
bottom left); which corner comes first is not known yet.
"""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats, Image, Integers
from alvar_core.detection import thresholds
from alvar_core.detection.acceptance import Ended
from alvar_core.detection.prepared_image import ImageBuffers
from alvar_core.detection.thresholds import Pass


def mean_around(smooth: Image, window: int, buffers: ImageBuffers) -> Image:
    """Return the mean of the window (width and height) around each pixel."""
    return cv2.blur(smooth, (window, window), dst=buffers.get('dark', *smooth.shape),
                    borderType=cv2.BORDER_REPLICATE | cv2.BORDER_ISOLATED)


def candidates(smooth: Image, passes: Sequence[Pass] | None = None, buffers: ImageBuffers | None = None,
               parts: list[Floats] | None = None) -> Floats:
    """Return the quads (N, 4, 2), float64, that ``passes`` find in a lightly smoothed grey image.

    The default is all of thresholds.PASSES. ``parts`` gets the straight parts (K, 2, 2) of the outlines of the first of
    PASSES, which is the finest. Its outlines of small squares are off by up to a quarter of the side, so they are
    searched once more in twice the resolution.
    """
    passes = thresholds.PASSES if passes is None else passes
    buffers = buffers or ImageBuffers()
    shrunk: dict[float, Image] = {1: smooth}
    quads = np.concatenate([np.zeros((0, 4, 2))] + [_one_pass(shrunk, buffers, parts, *each) for each in passes])
    if thresholds.PASSES[0] not in passes:
        return quads
    return np.concatenate([quads, native.steps.small_squares(smooth=smooth, quads=quads, limit=native.limit)])


def _shrunk(images: dict[float, Image], factor: float, buffers: ImageBuffers) -> Image:
    """Return the image shrunk by a factor; ``images`` {factor: image} has the full one and gets all that are made."""
    if factor not in images:
        full = images[1] if factor <= 2 else _shrunk(images, factor / 2, buffers)  # halving twice is faster
        ratio = min(factor, 2.0)
        width, height = int(full.shape[1] / ratio), int(full.shape[0] / ratio)
        images[factor] = cv2.resize(full, (width, height), dst=buffers.get('shrunk', height, width),
                                    interpolation=cv2.INTER_AREA if ratio >= 2 else cv2.INTER_LINEAR)
    return images[factor]


def _one_pass(images: dict[float, Image], buffers: ImageBuffers, parts: list[Floats] | None, shrink: float, window: int,
              offset: int) -> Floats:
    smooth = _shrunk(images, shrink, buffers)
    parted = parts is not None and shrink == thresholds.PASSES[0].shrink
    quads: Floats
    quads, straight = native.steps.outlines(smooth=smooth, mean=mean_around(smooth, window, buffers), offset=offset,
                                            shrink=shrink, parted=parted, limit=native.limit)
    if parts is not None and parted:
        parts.append(straight)
    return quads


def refined(smooth: Image, quads: Floats, ended: list[Ended] | None = None) -> Floats:
    """Move the sides of quads to where the grey rises most from inside to outside; return the quads (K, 4, 2).

    Quads without such a rise nearby are left out. Corners of outlines are rough: blur, noise and things that touch the
    square shift them by up to a cell. ``ended`` gets those that are left out.
    """
    found: Floats = native.steps.refined(smooth=smooth, quads=quads, limit=native.limit, ended=ended)
    return found


def distinct(quads: Floats, score: Floats, which: Integers) -> list[int]:
    """Return those of the indices ``which``, best score first, whose corners are not near those of a better quad."""
    kept: list[int] = native.steps.distinct(quads=quads, score=score, which=which.tolist(), limit=native.limit)
    return kept


class Turns:
    """Rations the search if an image has more than ``most`` candidates: each gets its turn, over several images.

    ``left_out``: how many had no turn in the last image.
    """

    def __init__(self, most: int) -> None:
        self.most, self.first, self.left_out = most, 0, 0

    def start(self) -> None:
        """Start with an image."""
        if self.left_out:
            self.first += self.most
        self.left_out = 0

    def passed(self, left_out: int) -> None:
        """Note how many candidates had no turn."""
        self.left_out = max(self.left_out, left_out)

    def of(self, quads: Floats, which: list[int]) -> list[int]:
        """Return the places in ``which``, indices of quads, whose turn it is.

        The turns go from top to bottom in the image.
        """
        places: list[int] = native.steps.in_turn(quads=quads, which=which, most=self.most, first=self.first)
        self.passed(len(which) - len(places))
        return places
