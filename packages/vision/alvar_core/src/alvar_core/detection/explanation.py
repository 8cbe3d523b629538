"""Say why a marker is not found: where the search for each candidate ended, in words and in a picture.

``explain`` runs the Detector, which notes the first threshold that each candidate misses. It makes no decision itself.
"""
from __future__ import annotations

import functools
import math
import textwrap
from collections import Counter
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from alvar_core.arrays import Floats, Image
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds
from alvar_core.detection.acceptance import Ended
from alvar_core.detection.detector import Detector

FOUND = 'found'


class Stage(NamedTuple):
    """A stage of the search: its name, its colour in the picture (BGR), and a sentence for each threshold."""

    name: str
    colour: tuple[int, int, int]
    sentences: dict[str, str]


REQUIREMENTS = 'CLEAR', 'UNLIKE', 'COVERED', 'CODE_COVERED', 'PLAIN'
# From the first stage to the last: of several candidates in one place, the one that got furthest counts.
STAGES = (
    Stage('sides', (150, 150, 150), {
        'MIN_SIDE_RISE': 'its sides are faint: outside it is brighter by {value:.1f} greys, more than {needed:.0f} are '
                         'needed'}),
    Stage('uneven light', (200, 120, 200), {
        'MIN_FIRST_PLAIN': 'its border is not plain: {value:.0%} of it, more than {needed:.0%} is needed',
        'MIN_FIRST_FIT': 'the edges of its cells differ from every code word: the best fit is {value:.2f}, more than '
                         '{needed:.2f} is needed',
        'MIN_FIRST_SCORE_GAP': 'the edges of its cells fit two code words alike: the best fits better by {value:.3f}, '
                               'more than {needed:.2f} is needed'}),
    Stage('stripe of glare', (120, 160, 200), {
        'MIN_GLARE_WHITE': 'it is saturated, and without that its white cells are hardly brighter than its black ones: '
                           'by {value:.0f} of 255, more than {needed:.0f} is needed',
        'MIN_GLARE': 'it is saturated, but its border shows no stripe of glare: the brightest one has {value:.0%} of '
                     'white, more than {needed:.0%} is needed',
        'MAX_GLARE_ERROR': 'it is saturated, but no straight stripe of glare explains the light on its border: it is '
                           'off by {value:.0%} of white, at most {needed:.0%} is allowed'}),
    Stage('border', (60, 60, 255), {
        'MIN_RIM_CONTRAST': 'its border is hardly darker than what is around it: by {value:.1f} greys, more than '
                            '{needed:.0f} are needed',
        'MIN_DARK_RIM': 'the border is black with white beside it on only {value:.0%} of its length, more than '
                        '{needed:.0%} is needed'}),
    Stage('code', (0, 140, 255), {
        'MIN_COARSE_FIT': 'its cells differ from every code word: the best fit is {value:.2f}, more than '
                          '{needed:.2f} is needed',
        'max_candidates': 'there are {value:.0f} candidates, and only max_candidates, {needed:.0f}, take turns in an '
                          'image'}),
    Stage('alignment', (0, 220, 255), {
        'MIN_MARKER_AREA': 'it is too small: {area:.0f} square pixels, more than {needed:.0f} are needed',
        'MIN_LIKENESS': 'it does not look like the marker that it resembles most: likeness {value:.2f}, more than '
                        '{needed:.2f} is needed',
        'MAX_BLUR': 'it is blurred over {value:.2f} cells, less than {needed:.2f} is needed'}),
    Stage('glare', (80, 200, 255), {
        'MIN_GLARE_SCORE_GAP': 'its cells beside the stripe of glare fit two code words alike: the best fits better by '
                               '{value:.2f} cells, more than {needed:.1f} is needed',
        'MAX_GLARE_MISFIT': 'without the stripe of glare, its cells differ from every code word: the best is off by '
                            '{value:.2f} cells, at most {needed:.1f} is allowed'}),
    Stage('edges', (255, 80, 200), {
        'EDGES_SEEN': 'too few edges of its cells are seen; {needed:.0%} are needed',
        'MIN_SEEN_EDGES': 'only {value:.0%} of the edges of its cells are seen, more than {needed:.0%} is needed',
        'THIN_MARGIN_RIM': 'the white margin is narrow, and {value:.0%} of the edges of the black border are seen; '
                           '{needed:.0%} are needed then',
        'LOCAL_PLAIN': 'its border is not plain: {value:.0%} of it, more than {needed:.0%} is needed',
        'LOCAL_RIM': 'white follows its black border on only {value:.0%} of its length, more than {needed:.0%} is '
                     'needed',
        **dict.fromkeys(('LOCAL_FIT', 'PLAIN_LOCAL_FIT'), 'the edges of its cells differ from that code word: the fit '
                        'is {value:.2f}, more than {needed:.2f} is needed'),
        'LOCAL_SCORE_GAP': 'the edges of its cells fit two code words alike: the best fits better by {value:.3f}, '
                           'more than {needed:.3f} is needed',
        **dict.fromkeys(('LOCAL_MARGIN_RATIO', 'PLAIN_LOCAL_MARGIN_RATIO'),
                        'the best code word is hardly better than the next: by {value:.2f} of what it leaves '
                        'unexplained, more than {needed:.2f} is needed')}),
    Stage('reading', (255, 160, 0), {
        'CHANGED_FIT': 'its cells are no code word: the best fit is {value:.2f}, more than {needed:.2f} is needed',
        'SAME_WORD': 'each time it is read it is another code word'}),
    Stage('acceptance', (255, 220, 0), {
        'MIN_SCORE_GAP': 'two code words fit it alike: the best fits better by {value:.3f}, more than {needed:.2f} is '
                         'needed',
        **dict.fromkeys(('MIN_INLIER_SHARE', 'SURE_INLIER_SHARE'),
                        'only {value:.0%} of it agrees with the drawn marker, more than {needed:.0%} is needed'),
        'SMALL_FIT': 'its cells are small, and differ from that code word: the fit is {value:.3f}, more than '
                     '{needed:.2f} is needed',
        'MAX_BAD_RIM': '{value:.0f} cells of the black border are not black; at most {needed:.0f} may be covered',
        **{name: f'along {sides} there is no white margin: the paper there is darker than white by {{darker:.0%}} of '
                 'the contrast, less than {allowed:.0%} is needed'
           for name, sides in (('MIN_OUTSIDE', 'one side'), ('SURE_OUTSIDE', 'two sides'))},
        **{f'{name}.fit': 'its cells differ from that code word: the fit is {value:.2f}, more than {needed:.2f} is '
                          'needed' for name in REQUIREMENTS},
        **{f'{name}.margin_ratio': 'the best code word is hardly better than the next: by {value:.2f} of what it '
                                   'leaves unexplained, more than {needed:.2f} is needed' for name in REQUIREMENTS},
        **{f'{name}.correlation': 'its cells do not look as drawn: correlation {value:.2f}, more than {needed:.2f} is '
                                  'needed' for name in REQUIREMENTS}}),
    Stage('margin', (255, 120, 120), {
        'NARROWER_MARGIN': 'its black border is narrower than the detector expects: with one cell less the cells fit '
                           '{needed:.2f}, as expected {value:.2f}',
        'WIDER_MARGIN': 'its black border is wider than the detector expects: with one cell more the cells fit '
                        '{needed:.2f}, as expected {value:.2f}'}),
    Stage('pose', (120, 120, 255), {
        'MAX_POSE_ERROR': 'its corners are those of no flat square: they are off by {value:.1%} of the side, less than '
                          '{needed:.0%} is needed'}))
RANKS = {threshold: rank for rank, stage in enumerate(STAGES) for threshold in stage.sentences}
FOUND_COLOUR = (60, 220, 60)
READ = {'glare', 'edges', 'acceptance', 'margin', 'pose'}  # in these stages, the code word is more than a guess
LAYOUTS = (5, 1), (5, 2), (5, 3), (7, 2), (9, 2)  # resolution and margin of other markers that are often printed
OTHER_COLOUR = (90, 90, 90)
MOST_UNREAD, MOST_EARLY = 5, 5  # listed candidates: the best that end at the code, the largest that end before it

PANEL_WIDTH, LINE, TEXT = 640, 18, 0.45  # px; size of the letters
NUMBERED_WIDTH = 800  # px of an image, from where on numbers grow with it


@dataclass
class Candidate:
    """A candidate: its ``corners`` (4, 2) [real px], the ``stage`` where it ended or FOUND, why in a ``sentence``.

    ``threshold`` is the one that it misses; ``id`` is that of a found marker.
    """

    corners: Floats
    stage: str
    sentence: str
    colour: tuple[int, int, int]
    threshold: str = ''
    id: int | str | None = None

    @property
    def side(self) -> float:
        """Return the side [px] of a square with the same area."""
        return float(homography.mean_side(self.corners[None])[0])

    def away(self, point: tuple[float, float]) -> float:
        """Return the distance [px] of a point outside; 0 inside."""
        return max(0.0, -cv2.pointPolygonTest(self.corners.astype(np.float32), point, True))


@dataclass
class Explanation:
    """The ``candidates`` in one image that are listed, best first, and the number of ``others``.

    ``cells``: along a marker's side.
    """

    cells: int
    candidates: list[Candidate]
    others: list[Candidate]

    @property
    def lines(self) -> list[str]:
        """Return a line for each candidate, with its number, and one for the others."""
        lines = [self._line(number, each) for number, each in enumerate(self.candidates, 1)]
        if self.others:
            counts = Counter(each.stage for each in self.others)
            lines.append(f'{len(self.others)} others are even less like a marker; they end at '
                         + ', '.join(f'{stage.name} ({counts[stage.name]})' for stage in STAGES if counts[stage.name]))
        if not self.candidates:
            lines.append('There is no dark quadrilateral on something brighter. A marker needs a white margin, at '
                         'least as wide as a cell, and must lie wholly in the image.')
        return lines

    def at(self, point: tuple[float, float]) -> str:
        """Return the line of the candidate that a point [px] lies on, or of the nearest one.

        Of several, it is the one that may be a marker, because its white cells are candidates, too; or the smallest.
        """
        x, y = point
        if not self.candidates:
            return f'At {x:.0f}, {y:.0f} there is no dark quadrilateral, nor anywhere else.'
        every = self.candidates + self.others
        number, nearest = min(enumerate(every, 1), key=lambda each: (
            each[1].away(point), each[1].stage not in (FOUND, *READ), each[1].side))
        away = nearest.away(point)
        said = f'there is no dark quadrilateral on something brighter; the nearest is {away:.0f} px away; of it: '
        return f'At {x:.0f}, {y:.0f}: {said if away else ""}{self._line(number, nearest)}'

    def outlined(self, image: Image) -> Image:
        """Return a BGR image with the candidates' outlines and numbers."""
        picture = image.copy() if image.ndim == 3 else cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
        for each in self.others:
            cv2.polylines(picture, [each.corners.round().astype(np.int32)], True, OTHER_COLOUR, 1, cv2.LINE_AA)
        for number, each in reversed(list(enumerate(self.candidates, 1))):
            cv2.polylines(picture, [each.corners.round().astype(np.int32)], True, each.colour,
                          3 if each.stage == FOUND else 2, cv2.LINE_AA)
            left, bottom = float(each.corners[:, 0].min()), float(each.corners[:, 1].max())
            _write(picture, str(number), left, bottom + LINE - 4, each.colour)
        return picture

    def draw(self, image: Image) -> Image:
        """Return the image of ``outlined`` with the lines below it."""
        picture = self.outlined(image)
        if picture.shape[1] < PANEL_WIDTH:  # the lines need this width
            picture = cv2.copyMakeBorder(picture, 0, 0, 0, PANEL_WIDTH - picture.shape[1], cv2.BORDER_CONSTANT)
        columns = int(picture.shape[1] / (17 * TEXT)) - 2
        rows = [(row, colour) for line, colour in zip(self.lines, self._colours())
                for row in textwrap.wrap(line, columns, subsequent_indent='    ')]
        panel = np.zeros((LINE * (len(rows) + 1), picture.shape[1], 3), np.uint8)
        for k, (row, colour) in enumerate(rows, 1):
            cv2.putText(panel, row, (6, LINE * k), cv2.FONT_HERSHEY_SIMPLEX, TEXT, colour, 1, cv2.LINE_AA)
        return np.concatenate([picture, panel])

    def _line(self, number: int, candidate: Candidate) -> str:
        side = candidate.side
        return (f'{number}: {candidate.sentence} ({side:.0f} px wide, {side / self.cells:.1f} px per cell, '
                f'at {candidate.corners[:, 0].mean():.0f}, {candidate.corners[:, 1].mean():.0f})')

    def _colours(self) -> list[tuple[int, int, int]]:
        return [each.colour for each in self.candidates] + [(220, 220, 220)] * 2


def explain(detector: Detector, image: Image, camera: Camera) -> Explanation:
    """Return the Explanation of what a Detector finds in an image; raise as Detector.detect does."""
    found, ended = detector.explain(image, camera)
    candidates = [Candidate(each.corners, FOUND, f'found as marker {each.id}' + (f', but {each.reason}'
                            if each.reason else ''), FOUND_COLOUR, id=each.id) for each in found]
    elsewhere = _of_other_layouts(detector, image, camera)
    places: list[Candidate] = []
    for each in sorted(ended, key=_how_far, reverse=True):
        other = _candidate(each)
        x, y = other.corners.mean(0)
        if any(known.covers((x, y)) for known in found) or any(_alike(other, known) for known in places):
            continue
        said = next((said for there, said in elsewhere if _alike(other, there)), '')
        places.append(replace(other, sentence=other.sentence + said))
    code = next(rank for rank, stage in enumerate(STAGES) if stage.name == 'code')
    ranks = [RANKS[each.threshold] for each in places]
    late, unread, early = ([each for each, rank in zip(places, ranks) if which(rank)]
                           for which in (code.__lt__, code.__eq__, code.__gt__))
    early.sort(key=lambda each: (-RANKS[each.threshold], -each.side))
    return Explanation(detector.cells, candidates + late + unread[:MOST_UNREAD] + early[:MOST_EARLY],
                       unread[MOST_UNREAD:] + early[MOST_EARLY:])


@functools.lru_cache(maxsize=len(LAYOUTS))
def _detector_of(resolution: int, margin: int) -> Detector:
    return Detector(1.0, resolution, margin)


def _of_other_layouts(detector: Detector, image: Image, camera: Camera) -> list[tuple[Candidate, str]]:
    """Return the markers that a detector of another resolution or margin finds, each with a sentence about it."""
    found = []
    for resolution, margin in LAYOUTS:
        names = [f'marker_resolution {resolution}'] * (resolution != detector.resolution)
        names += [f'marker_margin {margin}'] * (margin != detector.margin)
        if names:
            found += [(Candidate(each.corners, FOUND, '', FOUND_COLOUR),
                       f'. With {" and ".join(names)} it is marker {each.id}')
                      for each in _detector_of(resolution, margin).detect(image, camera)]
    return found


def _how_far(ended: Ended) -> tuple[int, float]:
    """Return how far a candidate got: the stage, and how near it was to the threshold."""
    _, threshold, value, needed, _ = ended
    rank = RANKS[threshold]
    return rank, value / needed if needed > 0 and math.isfinite(value) else 0.0


def _candidate(ended: Ended) -> Candidate:
    quad, threshold, value, needed, word = ended
    stage = STAGES[RANKS[threshold]]
    sentence = stage.sentences[threshold].format(value=value, needed=needed, darker=-value, allowed=-needed,
                                                 area=max(value, 0.0))
    if word >= 0 and stage.name in READ:
        sentence = f'perhaps marker {word % 256}, but {sentence}'
    return Candidate(np.asarray(quad), stage.name, sentence, stage.colour, threshold)


def _alike(one: Candidate, other: Candidate) -> bool:
    """Return whether two candidates are in the same place: the same square, found twice."""
    away = math.dist(one.corners.mean(0), other.corners.mean(0))
    return away < thresholds.OVERLAP * min(one.side, other.side) and one.side < 1.5 * other.side < 2.25 * one.side


def _write(picture: Image, text: str, x: float, y: float, colour: tuple[int, int, int]) -> None:
    """Write a number, dark around it, so that it is readable on any background."""
    larger = max(1.0, picture.shape[1] / NUMBERED_WIDTH)
    at = int(min(max(x, 2), picture.shape[1] - 20 * larger)), int(min(max(y, LINE), picture.shape[0] - 4))
    for pen, ink in ((4, (0, 0, 0)), (1, colour)):
        cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, 0.6 * larger, ink, round(pen * larger), cv2.LINE_AA)
