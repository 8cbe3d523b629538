"""The search for markers of resolution 5 in even light: all steps on all candidates in one call of native/search.cpp.

It only names candidates that need a closer look, because cells may be covered; the Detector examines them.
"""
from __future__ import annotations

from typing import Any, Mapping, NamedTuple

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats
from alvar_core.detection.acceptance import Appearance, Ended, Features, edges
from alvar_core.detection.alignment import Aligner
from alvar_core.detection.candidates import Turns
from alvar_core.detection.corners import CornerEstimator
from alvar_core.detection.light import Evidence
from alvar_core.detection.pose import Solution
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import CoarseDecoder, Reader

NUMBERS = range(256)  # of markers of resolution 5


class Seen(NamedTuple):
    """A marker: its number, corners (4, 2) [real px] as drawn, their information (8, 8), its poses and Features.

    ``evidence``: its measurement of gamma (light.Evidence).
    """

    number: int
    corners: Floats
    information: Floats
    solutions: list[Solution]
    features: Features
    evidence: Evidence


class Search:
    """Finds markers with the parts of a Detector; ``black_words`` (1024, n, n): the black cells of all code words."""

    def __init__(self, decoder: CoarseDecoder, aligner: Aligner, appearance: Appearance, reader: Reader,
                 corners: CornerEstimator, black_words: Bools) -> None:
        self._steps = native.steps.Search(decoder=decoder.steps, aligner=aligner.steps, appearance=appearance.steps,
                                          reader=reader.steps, scale=corners.scale, black_words=black_words,
                                          edges=edges(black_words))

    def find(self, image: PreparedImage, quads: Floats, size: float, sizes: Mapping[int | str, float], turns: Turns,
             ended: list[Ended] | None = None,
             ask: bool = False) -> tuple[list[Seen], Any, Any, Floats]:
        """Return the markers Seen among quads (N, 4, 2) [real px], unsure ones, well read ones, and refined quads.

        What lies on a square before it whose code is sure, or on a marker with a better code, is left out. If there are
        too many candidates, only those are searched whose turn it is. ``size`` [m] is that of markers not in ``sizes``.
        An unsure quad has ``h`` (3, 3), ``blur`` and ``level``, from which an alignment starts, and ``word``, ``fit``
        and ``score_gap`` of the coarse decoding. A well read quad that is no marker has ``quad`` (4, 2) and ``word``.
        ``ended`` gets all others. With ``ask``, markers have evidence.
        """
        found = self._steps.find(
            smooth=image.smooth, **image.pyramid.memory, full=image.pyramid.full, lens=image.camera.lens,
            light=image.light.steps, ask=ask, noise=image.noise, quads=quads,
            sizes=_sizes(size, sizes),
            most=turns.most, first=turns.first, limit=native.limit, ended=ended)
        turns.passed(found['left_out'])
        return _seen(found['markers']), found['unsure'], found['well_read'], found['refined']


def _sizes(size: float, sizes: Mapping[int | str, float]) -> Floats:
    """Return the size [m] of the marker with each number."""
    out = np.full(len(NUMBERS), size)
    for number, own in sizes.items():
        if number in NUMBERS:
            out[int(number)] = own
    return out


def _seen(markers: Any) -> list[Seen]:
    """Return the markers in an array of records; whole columns are converted, since a record takes 20 times longer."""
    solutions = markers['solutions']
    poses = zip(solutions['rotation'], solutions['position'], solutions['error'].tolist(), solutions['chi2'].tolist())
    return [Seen(number, corners, information, [Solution(*each) for each in zip(*both)][:count],
                 Features._make(features), Evidence(*evidence))
            for number, corners, information, count, both, features, evidence in zip(
                markers['number'].tolist(), markers['corners'], markers['information'], markers['poses'].tolist(),
                poses, markers['features'].tolist(), markers['evidence'].tolist())]
