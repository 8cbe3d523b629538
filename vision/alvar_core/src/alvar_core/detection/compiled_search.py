"""The search for markers of resolution 5 in even light as one compiled step, native/detector.cpp.

It does what Detector._in_even_light does, but names what needs a closer look instead of taking it.
"""
from __future__ import annotations

import ctypes
from typing import Any, Mapping, NamedTuple

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats
from alvar_core.detection import thresholds
from alvar_core.detection.acceptance import Appearance, Features
from alvar_core.detection.alignment import Aligner
from alvar_core.detection.candidates import side_limits
from alvar_core.detection.corners import CornerEstimator
from alvar_core.detection.pose import Solution
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import CoarseDecoder, Reader, words_of_numbers

# The rows of native/detector.cpp: a marker, and what needs a closer look; each number is a double
RECORD = np.dtype([('number', 'f8'), ('corners', 'f8', (4, 2)), ('information', 'f8', (8, 8)), ('poses', 'f8'),
                   ('solutions', 'f8', (2, 14)), ('features', 'f8', 11)])
START = np.dtype([('h', 'f8', (3, 3)), ('word', 'f8'), ('blur', 'f8'), ('level', 'f8'), ('fit', 'f8'), ('gap', 'f8')])
WELL_READ = np.dtype([('quad', 'f8', (4, 2)), ('word', 'f8')])


class Seen(NamedTuple):
    """A marker: its number, corners (4, 2) [real px] as drawn, their information (8, 8), its poses and Features."""

    number: int
    corners: Floats
    information: Floats
    solutions: list[Solution]
    features: Features


class CompiledSearch:
    """Finds markers with ``cells`` cells per side, with the parts of a Detector."""

    def __init__(self, library: ctypes.CDLL, decoder: CoarseDecoder, aligner: Aligner, appearance: Appearance,
                 reader: Reader, corners: CornerEstimator, black_words: Bools) -> None:
        self._library = library
        coarse, align, look, read = (part.compiled_arrays() for part in (decoder, aligner, appearance, reader))
        first, inside = reader.region
        numbers = np.array([aligner.grid.cells, aligner.grid.count, len(appearance.data_samples), coarse[2].shape[1],
                            first, inside], np.int64)
        # the order of Constants in native/detector.cpp
        self._arrays = [_limits(), side_limits(), *coarse, *align, np.ascontiguousarray(black_words), *look, *read,
                        *corners.compiled_arrays(), numbers, np.array([appearance.weight])]
        self._constants = np.array([native.address(each).value for each in self._arrays], np.uintp)
        self._rows = [np.empty(thresholds.MAX_ALIGNED, kind) for kind in (RECORD, START, WELL_READ)]
        self._places = [native.address(rows) for rows in self._rows]

    def find(self, image: PreparedImage, lens: Floats, quads: Floats, size: float,
             sizes: Mapping[int | str, float]) -> tuple[list[Seen], Any, Any, Floats]:
        """Return what is Seen among quads (N, 4, 2) [real px], STARTs of others, what is WELL_READ, and refined quads.

        ``lens``: the numbers of the camera; ``size`` [m] is that of markers not in ``sizes``. START: ``h`` (3, 3),
        ``blur`` and ``level`` are where an alignment starts, ``word``, ``fit`` and ``gap`` the coarse decoding.
        """
        quads, place = np.array(quads, np.float64, order='C'), native.address
        all_sizes = np.full(len(words_of_numbers()) // 4, size)
        for number, each in sizes.items():
            if number in range(len(all_sizes)):
                all_sizes[int(number)] = each
        atlas, table = image.pyramid.memory
        found = np.zeros(4, np.int32)
        self._library.alvar_find_in_even_light(
            place(self._constants), *native.image(image.smooth), *native.image(atlas), place(table), place(lens),
            ctypes.c_double(image.noise), len(quads), place(quads), place(all_sizes), thresholds.MAX_ALIGNED,
            *self._places, place(found))
        seen, unsure, well_read = (rows[:count].copy() for rows, count in zip(self._rows, found.tolist()))
        return [_seen(*row) for row in seen], unsure, well_read, quads[:found[3]]


def _seen(number: float, corners: Floats, information: Floats, poses: float, solutions: Floats,
          features: Floats) -> Seen:
    return Seen(int(number), corners, information, [Solution.of_row(each) for each in solutions[:int(poses)]],
                Features.of_row(features))


def _limits() -> Floats:
    """Return the thresholds that native/detector.cpp needs."""
    return np.array([
        thresholds.MIN_COARSE_FIT, thresholds.COARSE_GAP_WEIGHT, thresholds.MAX_ALIGNED, thresholds.SAME_QUAD,
        thresholds.START_BLUR, *thresholds.NEXT_LEVEL, thresholds.ALIGNMENT_STEPS, thresholds.WELL_READ_FIT,
        thresholds.WELL_READ_GAP, thresholds.SAMPLED_NOISE, thresholds.MIN_MARKER_AREA, thresholds.MIN_LIKENESS,
        thresholds.MAX_BLUR, thresholds.SURE_FIT, thresholds.SURE_GAP, thresholds.CONTRAST_SPARE,
        thresholds.CHANGED_FIT, *thresholds.CODE_COVERED, *thresholds.COVERED, *thresholds.CLEAR, *thresholds.UNLIKE,
        *thresholds.SURE, thresholds.CODE_COVERED_CELLS, thresholds.WIDE_GAP, thresholds.COVERED_CELLS,
        thresholds.CLEAR_LIKENESS, thresholds.BEST_FIT, thresholds.MIN_GAP, thresholds.MIN_KEPT,
        thresholds.MAX_BAD_RIM, thresholds.MIN_OUTSIDE, thresholds.WHOLE_LIKENESS, thresholds.SURE_KEPT,
        thresholds.SURE_OUTSIDE, thresholds.SURE_MARGIN_DETAIL, thresholds.MAX_POSE_ERROR,
        thresholds.MAX_NOISE_SHARE, thresholds.BAD_CELL, thresholds.OVERLAP])
