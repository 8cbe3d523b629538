"""The marker detector: returns ids, corners and poses from an image, its camera and the marker size.

Each image is searched independently of all others; only the response of the camera (light.py) is learnt over images.

An image passes these stages, each on all candidates at once:

1. candidates.candidates finds dark quadrilaterals; candidates.refined moves their sides to where the grey rises.
2. reading.CoarseDecoder selects quads with a dark border and finds the most similar code word of each. Once that is
   sure, nothing that lies on this square is looked at.
3. alignment.Aligner fits the drawn marker to the image; reading.Reader then reads the cells again.
4. acceptance decides whether it is a marker; if not, it is read again without the cells that may be covered.
5. corners.CornerEstimator measures the corners and their covariance; pose.solve computes both poses.

uneven_light.UnevenLight then finds markers of resolution 5 that shadows, glare or bent paper hide from these stages,
and measures markers again whose greys do not fit the drawing well; with glare.GlareReader it removes the stripe that a
lamp leaves across a marker. If the image is full of parallel stripes of light, it passes all stages again without them
(striped_light). bent_paper.BentPaper measures markers whose sides are curved, or whose corners do not lie in a plane,
as a cylinder or two planes.
"""
from __future__ import annotations

import math
from numbers import Real
from typing import Mapping, NamedTuple, Sequence

import numpy as np

from alvar_core import code
from alvar_core.arrays import Bools, Floats, Image, Integers
from alvar_core.camera import Camera
from alvar_core.detection import acceptance, candidates, homography, pose, striped_light, thresholds
from alvar_core.detection.acceptance import Appearance, Ended, Features, Shortfall, may_be_covered, unpromising
from alvar_core.detection.alignment import Aligner, Alignment, Covariance, covariance
from alvar_core.detection.bent_paper import BentPaper, Sheet
from alvar_core.detection.corners import CornerEstimator, corners_seen
from alvar_core.detection.covered_cells import CoveredReader
from alvar_core.detection.detection import Detection, best_of_overlapping
from alvar_core.detection.light import MOST_AGAIN, Evidence, Response
from alvar_core.detection.prepared_image import ImageBuffers, PreparedImage
from alvar_core.detection.reading import CoarseDecoder, Reader, Reading, black_cells
from alvar_core.detection.search import Search
from alvar_core.detection.uneven_light import Found, UnevenLight, free_of

MARGINS = range(1, 11)  # [cells]

NO_SQUARE = ('its corners are those of no flat square, by {:.1%} of its side: is the lens as K and D of camera_info '
             'say, and the paper flat?')
NO_PAPER = ('its edges are those of no flat, bent or creased paper: is the lens as K and D of camera_info say, and '
            'the paper not crumpled?')


def checked_size(size: float) -> float:
    """Return a marker's size [m] as float; raise ValueError if no marker can have it."""
    if isinstance(size, (bool, str)) or not isinstance(size, Real) or not 0 < size < math.inf:
        raise ValueError(f'marker size {size!r} m: a length above 0 is needed')
    return float(size)


def checked_margin(margin: int) -> int:
    """Return a margin [cells] as int; raise ValueError if no marker can have it."""
    if isinstance(margin, bool) or not isinstance(margin, Real) or margin not in MARGINS:
        raise ValueError(f'marker margin {margin!r}: a whole number of cells from {MARGINS[0]} to {MARGINS[-1]} '
                         'is needed')
    return int(margin)


def checked_candidates(most: int) -> int:
    """Return the largest number of candidates to examine in one image; raise ValueError if it cannot be used."""
    if isinstance(most, bool) or not isinstance(most, int) or most < 1:
        raise ValueError(f'max_candidates {most!r}: a whole number of at least 1 is needed')
    return most


class _Start(NamedTuple):
    """The start values of the alignment of M markers with their drawings.

    ``h`` (M, 3, 3); ``black`` (M, n, n) cells; ``blur`` (M,), variance [px^2 at the level]; ``level`` (M,); ``words``:
    (word, fit, score_gap) of the coarse decoding for each marker, or None.
    """

    h: Floats
    black: Bools
    blur: Floats
    level: Integers
    words: list[tuple[int, float, float]] | None = None


class _Accepted(NamedTuple):
    """A candidate that is a marker: its index in the Alignment, its Reading and its Features."""

    place: int
    reading: Reading
    features: Features


class Detector:
    """Finds ALVAR markers of one resolution and margin in the images of one camera.

    ``size`` [m] is the width of the black square, ``sizes`` {id: [m]} that of markers that differ; ``resolution`` and
    ``margin`` are in cells. ``gamma`` is the exponent of the camera's response: light is grey ** gamma; None: it is
    learnt from the markers. If an image has more than ``max_candidates`` that may be markers, they take turns from
    image to image, and none is searched for in uneven light. Not thread-safe: one thread uses a Detector at a time.
    """

    def __init__(self, size: float, resolution: int = code.MIN_RESOLUTION, margin: int = code.MARGIN,
                 sizes: Mapping[int | str, float] | None = None, gamma: float | None = None,
                 max_candidates: int = thresholds.MAX_CANDIDATES) -> None:
        self.buffers, self._even_buffers = ImageBuffers(), ImageBuffers()
        self.size, self.sizes = size, {value: checked_size(each) for value, each in (sizes or {}).items()}
        self.resolution, self.margin = code.check_resolution(resolution), checked_margin(margin)
        self.cells = self.resolution + 2 * self.margin
        rim = min(thresholds.RIM_CELLS, self.margin * thresholds.RIM_SHARE)
        self._decoder = CoarseDecoder(self.resolution, self.margin)
        self._rim_aligner = Aligner(self.cells, thresholds.SAMPLES_PER_CELL, inner=rim)
        self._aligner = Aligner(self.cells, thresholds.SAMPLES_PER_CELL)
        self._appearance = Appearance(self._aligner, self.resolution, self.margin)
        self._reader = Reader(self._aligner.grid, self.resolution, self.margin)
        self._covered = CoveredReader(self._aligner.grid, self.margin) if self._decoder.words is not None else None
        self._corners, self._paper = CornerEstimator(self.cells), BentPaper(self.cells)
        self._uneven = UnevenLight(self.margin) if self._decoder.words is not None else None
        self._search = None
        self._response, self._turns = Response(gamma), candidates.Turns(checked_candidates(max_candidates))
        self._asks = False
        self._evidence: list[Evidence] = []  # of the markers in the image that is searched
        self._ended: list[Ended] | None = None  # gets the rejected candidates while explain() runs
        if self._decoder.words is not None:
            self._black_words = black_cells(self._decoder.words, self.margin)
            self._search = Search(self._decoder, self._aligner, self._appearance, self._reader, self._corners,
                                  self._black_words)

    @property
    def size(self) -> float:
        """Return the width [m] of the black square of markers that are not in ``sizes``; it can be set."""
        return self._size

    @size.setter
    def size(self, size: float) -> None:
        self._size = checked_size(size)

    @property
    def left_out(self) -> int:
        """Return how many candidates of the last image were not examined, because there were too many."""
        return self._turns.left_out

    @property
    def gamma(self) -> float:
        """Return the exponent of the camera's response: the one that is known, or as learnt so far."""
        return self._response.light.gamma

    def detect(self, image: Image, camera: Camera) -> list[Detection]:
        """Return the Detections in an image; raise ImageError or CameraError."""
        prepared = self.prepare(image, camera)
        parts: list[Floats] = []
        quads = candidates.candidates(prepared.smooth, buffers=self.buffers, parts=parts)
        return self.examine(prepared, quads, parts)

    def explain(self, image: Image, camera: Camera) -> tuple[list[Detection], list[Ended]]:
        """Return the Detections in an image, and where the search for each other candidate ended; as ``detect``."""
        ended: list[Ended] = []
        self._ended = ended
        try:
            return self.detect(image, camera), ended
        finally:
            self._ended = None

    def prepare(self, image: Image, camera: Camera) -> PreparedImage:
        """Return the image prepared for ``examine``; it is valid until the next call."""
        return PreparedImage(image, camera, self.buffers, self._response.light)

    def examine(self, image: PreparedImage, quads: Floats, parts: Sequence[Floats] | None = ()) -> list[Detection]:
        """Return the Detections among candidate quads (N, 4, 2) [real px], clockwise.

        ``parts``: those that candidates.candidates found; squares in uneven light are made of them. None: do not search
        for markers in uneven light at all, which would double the time.
        """
        found = self._in_known_light(image, quads, parts)
        if not self._response.is_known:
            for each in found:
                each.doubt_size(thresholds.UNKNOWN_GAMMA_ERROR)
        return found

    def _in_known_light(self, image: PreparedImage, quads: Floats, parts: Sequence[Floats] | None) -> list[Detection]:
        """Return the Detections; learn the camera's response from them, and measure them again if it has changed."""
        self._asks = self._response.asks()
        self._turns.start()
        for _ in range(MOST_AGAIN):
            self._evidence = []
            found = self._examined(image, quads, parts)
            if not self._response.learn(self._evidence):
                return found
            image.relight(self._response.light)
            if self._ended:
                self._ended.clear()  # the second search fills it again
        self._asks = False
        return self._examined(image, quads, parts)

    def _examined(self, image: PreparedImage, quads: Floats, parts: Sequence[Floats] | None) -> list[Detection]:
        found, refined = self._in_even_light(image, quads)
        if self._uneven is None:
            return found
        found = [self._checked(image, each) for each in found]
        striped: list[Detection] = []
        if parts is not None and not self.left_out:  # candidates without a turn would be found there
            free = self._uneven.free_parts(image, parts, found)
            striped = self._between_stripes(image, free, found)
            if striped:
                found = best_of_overlapping(found + striped)
            more = [self._of_edges(image, each) for each in self._uneven.find(image, refined, free, found, self._ended)
                    if not self._has_other_margin(each.image or image, each)]
            if more:
                found = best_of_overlapping(found + [each for each in more if each is not None])
        self._measure_bent(image, [d for d in found if d not in striped])
        return found

    def _between_stripes(self, image: PreparedImage, parts: Sequence[Floats],
                         known: Sequence[Detection]) -> list[Detection]:
        """Return the new Detections in the image after its stripes of light are removed.

        Straight ``parts`` give the angle of the stripes; without them, the angle of the last image is used.
        """
        if parts:
            image.stripes = striped_light.stripe_angle(np.concatenate(parts), math.hypot(*image.grey.shape))
        if image.stripes is None:
            return []
        even = PreparedImage(striped_light.without_stripes(image.grey, image.stripes), image.camera,
                             self._even_buffers, image.light)
        quads = candidates.candidates(even.smooth, buffers=self._even_buffers)
        quads = quads[free_of(known, quads.mean(1))]
        found = [self._checked(even, each) for each in self._in_even_light(even, quads)[0]]
        self._measure_bent(even, found)
        return found

    def _in_even_light(self, image: PreparedImage, quads: Floats) -> tuple[list[Detection], Floats]:
        """Return the Detections among quads (N, 4, 2) whose greys fit a drawing, and the refined quads (K, 4, 2)."""
        if not len(quads):
            return [], quads
        if self._search is None:
            quads = candidates.refined(image.smooth, quads, self._ended)
            return self._cell_by_cell(image, quads), quads
        seen, unsure, well_read, refined = self._search.find(image, quads, self.size, self.sizes, self._turns,
                                                             self._ended, self._asks)
        self._evidence += [each.evidence for each in seen if each.features.inlier_share > thresholds.EVEN_INLIER_SHARE]
        found = [_detection(each.number, each.corners, each.solutions, each.features, each.information)
                 for each in seen]
        if len(unsure):
            drawn = unsure['word']
            words = list(zip(drawn, unsure['fit'], unsure['score_gap']))
            found += self._finish(image, _Start(unsure['h'], self._black_words[drawn], unsure['blur'], unsure['level'],
                                                words))
        found = best_of_overlapping([each for each in found if self._is_read_well(each)])
        found += self._well_read(image, well_read['quad'], well_read['word'], found)
        return found, refined

    def _is_read_well(self, detection: Detection) -> bool:
        """Return whether the cells of a marker fit its code word, if they are so small that any cells resemble one."""
        f = detection.features
        if f is None or detection.side > thresholds.SMALL_CELL * self.cells or f.fit > thresholds.SMALL_FIT:
            return True
        self._end(detection.corners, ('SMALL_FIT', f.fit, thresholds.SMALL_FIT), int(detection.id))
        return False

    def _cell_by_cell(self, image: PreparedImage, quads: Floats) -> list[Detection]:
        """Return the Detections among refined quads, for resolutions that are read cell by cell."""
        match = self._decoder.match(image.smooth, quads, self._ended)
        quads = quads[match.kept]
        near = np.flatnonzero(match.fit > thresholds.MIN_COARSE_FIT)
        for m in np.setdiff1d(np.arange(len(quads)), near).tolist():
            self._end(quads[m], ('MIN_COARSE_FIT', float(match.fit[m]), thresholds.MIN_COARSE_FIT))
        rank = match.fit + thresholds.COARSE_SCORE_GAP_WEIGHT * match.score_gap
        distinct = candidates.distinct(quads, rank, near)
        chosen = [distinct[place] for place in self._turns.of(quads, distinct)]
        for m in set(distinct).difference(chosen):
            self._end(quads[m], ('max_candidates', len(distinct), self._turns.most))
        if not chosen:
            return []
        quads = quads[chosen]
        cell = homography.mean_side(quads) / self.cells
        h = homography.from_square(image.camera.to_ideal(quads), self.cells / 2)
        start = self._by_rim(image, h, np.searchsorted(thresholds.NEXT_LEVEL, cell), cell)
        return best_of_overlapping(self._finish(image, start))

    def _well_read(self, image: PreparedImage, quads: Floats, words: Integers,
                   known: Sequence[Detection]) -> list[Detection]:
        """Return the Detections of quads with a clear code whose greys do not fit, such as those with thin margins."""
        found: list[Detection] = []
        if not len(quads):
            return found
        middles, near = quads.mean(1), thresholds.OVERLAP * homography.mean_side(quads)
        apart = np.ones(len(quads), bool)
        if known:
            away = np.linalg.norm(middles[:, None] - np.array([each.centre for each in known]), axis=2)
            apart = (away >= near[:, None]).all(1)
        for m in np.flatnonzero(apart).tolist():
            quad, word = quads[m], int(words[m])
            if self._uneven is None or any(math.dist(each.centre, middles[m]) < near[m] for each in found):
                continue
            one = self._uneven.aligned(image, quad, word)
            least = thresholds.AGAIN_THIN_FIT if one is not None and one.thin else thresholds.AGAIN_FIT
            if self._uneven.is_plain(word):
                least = thresholds.PLAIN.fit
            if one is None or one.word != word or one.fit < least \
                    or self._has_other_margin(image, one):
                continue
            more = self._of_edges(image, one)
            found += [more] if more else []
        return found

    def _measure_bent(self, image: PreparedImage, found: Sequence[Detection]) -> None:
        """Measure markers with curved sides, or not in a plane, as bent or creased paper; change their Detections."""
        found = [each for each in found if each.side > thresholds.MIN_BENT_SIDE and not each.thin_margin]
        if not found:
            return
        bows = self._corners.bow(image, image.camera.to_ideal([each.corners for each in found]))
        for detection, bow in zip(found, bows):
            odd = detection.solutions[0].chi2 > thresholds.MAX_STRAIGHT_CHI2
            if odd or bow > (thresholds.SLIGHT_BOW if _is_not_flat(detection) else thresholds.MIN_BOW):
                sheet = detection.sheet = self._sheet(image, detection)
                if sheet is None:
                    unknown = odd or bow > thresholds.MAX_BOW
                elif sheet.is_bent:
                    _bend(detection, sheet, image.camera)
                    unknown = False
                else:  # measure the corners without a model of the paper
                    unknown = odd or sheet.doubtful and bow > thresholds.MIN_BOW
                if unknown:
                    detection.doubtful, detection.reason = True, detection.reason or NO_PAPER
                    corners = self._corners_seen(image, detection)
                    if corners is not None:
                        self._take_corners(image, detection, corners)
                    elif sheet is not None and not sheet.age and bow > thresholds.MIN_BOW \
                            and self._are_near(detection, _real_corners(sheet, image.camera)):
                        _bend(detection, sheet, image.camera)
                elif sheet is not None:
                    detection.doubtful, detection.reason = False, ''

    def _sheet(self, image: PreparedImage, detection: Detection) -> Sheet | None:
        """Return the Sheet of a marker; None if its edges cannot be followed.

        If no sheet fitted well in the last images, return the last one: a fit takes as long as ten other markers.
        """
        near = thresholds.TRACK_REACH * detection.side
        before = next((each.sheet for each in image.before if each.id == detection.id
                       and math.dist(each.centre, detection.centre) < near), None)
        if before is not None and not before.is_bent and before.age < thresholds.BENT_WAIT:
            return before._replace(age=before.age + 1)
        black = black_cells(code.encode(int(detection.id)), self.margin)
        poses = [(each.rotation, each.position) for each in detection.solutions]
        limit = thresholds.MAX_BENT_ERROR if _is_in_even_light(detection) else thresholds.MAX_UNEVEN_ERROR
        return self._paper.measure(
            image.grey, image.camera, black, poses, self.sizes.get(detection.id, self.size),
            min(thresholds.LOCAL_REACH * detection.side / self.cells, thresholds.MAX_LOCAL_REACH), limit, image.light,
            before)

    def _are_near(self, detection: Detection, corners: Floats) -> bool:
        """Return whether corners (4, 2) [real px] of the same marker are near its own."""
        away = np.linalg.norm(corners - detection.corners, axis=1).max()
        return bool(away < thresholds.MAX_CORNER_MOVE * detection.side / self.cells)

    def _corners_seen(self, image: PreparedImage, detection: Detection) -> Floats | None:
        """Return the corners (4, 2) [real px] of a marker of any shape, each measured alone; None if one is missing."""
        cell = detection.side / self.cells
        reach = [max(int(share * cell), 2) for share in thresholds.CORNER_REACHES]
        corners = corners_seen(image.light.of(image.grey), detection.corners, reach)
        return corners if corners is not None and self._are_near(detection, corners) else None

    def _take_corners(self, image: PreparedImage, detection: Detection, corners: Floats) -> None:
        """Give the Detection these corners (4, 2) [real px], if a pose fits them."""
        size = self.sizes.get(detection.id, self.size)
        solutions = pose.solve(image.camera.to_ideal(corners)[None], [size], image.camera)[0]
        if solutions:
            best = solutions[0]
            detection.corners, detection.information, detection.solutions = corners, None, solutions
            detection.rotation, detection.position, detection.error = best.rotation, best.position, best.error
            detection.ambiguity, detection.ambiguous = pose.ambiguity(solutions)
            detection.forget_size()

    def _checked(self, image: PreparedImage, detection: Detection) -> Detection:
        """Return a Detection, measured again by the edges of its cells if its greys do not fit the drawing."""
        f = detection.features
        if self._uneven is None or f is None or f.inlier_share > thresholds.EVEN_INLIER_SHARE:
            return detection
        at = image, detection.corners, int(detection.id)
        found = self._uneven.aligned(*at)
        if found is None and detection.side > thresholds.MIN_EDGE_SIDE:  # its number stays, whatever is read
            found = self._uneven.aligned(*at, known=True)
        if found is None:
            return detection
        return self._of_edges(image, found._replace(fit=max(found.fit, detection.confidence))) or detection

    def _of_edges(self, image: PreparedImage, found: Found) -> Detection | None:
        """Return the Detection of a marker that was measured by its edges; None without a pose."""
        content = self._reader.of_word(found.word, found.fit, found.score_gap).content
        order = [(k + content.turns) % 4 for k in range(4)]
        eight = np.array([2 * k + axis for k in order for axis in (0, 1)])
        corners, information = found.corners[order], np.linalg.inv(found.covariance[np.ix_(eight, eight)])
        size = self.sizes.get(content.value, self.size)
        solutions = pose.solve(corners[None], [size], image.camera, information[None])[0]
        real = np.stack(image.camera.to_real(corners[:, 0], corners[:, 1]), -1)
        side = float(homography.mean_side(real[None])[0])
        sure = found.fit > thresholds.SURE.fit and found.margin_ratio > thresholds.SURE.margin_ratio
        if _misses_pose(solutions, side) and not (sure and solutions):
            self._end(real, _missed_by_pose(solutions, side), found.word)
            return None
        share, ambiguous = pose.ambiguity(solutions)
        best = solutions[0]
        return _doubted(Detection(content.value, real, best.rotation, best.position, found.fit, share, ambiguous,
                                  best.error, solutions, None, information, thin_margin=found.thin))

    def _by_rim(self, image: PreparedImage, h: Floats, level: Integers, cell: Floats) -> _Start:
        """Align the black border alone and read the cells; leave out markers that could not be read."""
        all_black = np.ones((len(h), self.cells, self.cells), bool)
        rim_blur = _start_blur(thresholds.RIM_START_BLUR, cell, level)
        rim = self._rim_aligner.run(image.pyramid, image.camera, h, all_black, rim_blur, level,
                                    thresholds.RIM_ALIGNMENT_STEPS, redraw=(1, 3, 5))
        both, twice = np.concatenate([rim.h, h]), np.concatenate([level, level])
        blur = np.concatenate([rim.blur, _start_blur(thresholds.START_BLUR, cell, level)])
        values = self._aligner.values(image.pyramid, image.camera, both, twice)
        readings = self._reader.read_cells(self._shares(values), covariance(both, blur * 4.0 ** twice))
        fits = [reading.fit if reading else 0.0 for reading in readings]
        read, black = [], []
        for m in range(len(h)):
            better = max(m, m + len(h), key=fits.__getitem__)
            reading = readings[better]
            if reading is not None and reading.fit > thresholds.CHANGED_FIT:
                read.append(better)
                black.append(black_cells(reading.white, self.margin))
            else:
                self._end_at(image, h[m], ('CHANGED_FIT', fits[better], thresholds.CHANGED_FIT))
        return _Start(both[read], np.array(black, bool), blur[read], twice[read])

    def _shares(self, values: Floats) -> Floats:
        """Scale grey values (M, P) to 0 (the black of the border) to 1 (the brightest cells)."""
        reach = self._aligner.grid.reach
        dark = np.median(values[:, (reach < -0.2) & (reach > 0.5 - self.margin)], 1, keepdims=True)
        white = np.percentile(values[:, reach < -self.margin], 97, axis=1, keepdims=True)
        return ((values - dark) / np.maximum(white - dark, thresholds.MIN_WHITE)).astype(np.float32)

    def _finish(self, image: PreparedImage, start: _Start) -> list[Detection]:
        """Align with the drawings, read and judge; align once more if a reading differs from its coarse decoding."""
        if not len(start.h):
            return []
        state = self._aligner.run(image.pyramid, image.camera, start.h, start.black, start.blur, start.level,
                                  thresholds.ALIGNMENT_STEPS)
        noise = np.minimum(state.noise, thresholds.SAMPLED_NOISE * image.noise / 2.0 ** state.level)
        features, corners = self._appearance.features(state, noise), self._corners.start(state)
        likeness = np.array([each.likeness for each in features])
        missed = [unpromising(state, m, each, self.cells) for m, each in enumerate(likeness)]
        good = [m for m, each in enumerate(missed) if each is None]
        for m, each in enumerate(missed):
            if each is not None:
                self._end_at(image, state.h[m], each)
        if not good:
            return []
        blur = covariance(state.h, state.blur * 4.0 ** state.level)
        state, black, corners = state.take(good), start.black[good], corners[good]
        likeness, noise, blur = likeness[good], noise[good], blur.take(good)
        words = [start.words[m] for m in good] if start.words else None
        readings = self._read(state, blur, likeness, noise, words)
        features = [features[m] for m in good]
        found, changed = self._judged(image, black, corners, readings, features)
        self._uncover(image, state, blur, black, corners, readings, features, found, changed)
        settled = {each.place for each in found} | {m for m, _ in changed if words}
        for m in set(range(len(good) if self._ended is not None else 0)) - settled:
            why = self._missed(image, black[m], corners[m], readings[m], features[m])
            self._end_at(image, state.h[m], why, readings[m])
        out = self._detections(image, state, corners, found)
        if changed and words:
            again = np.array([black_cells(reading.white, self.margin) for _, reading in changed])
            which = [m for m, _ in changed]
            out += self._finish(image, _Start(state.h[which], again, state.blur[which], state.level[which]))
        return out

    def _read(self, state: Alignment, blur: Covariance, likeness: Floats, noise: Floats,
              words: Sequence[tuple[int, float, float]] | None) -> list[Reading | None]:
        """Return a Reading (or None) of each marker; where the coarse decoding was sure, keep its result."""
        readings: list[Reading | None] = [None] * len(likeness)
        for m, (word, fit, score_gap) in enumerate(words or ()):
            if fit > thresholds.SURE_FIT and likeness[m] > thresholds.SURE_FIT \
                    and score_gap > thresholds.SURE_SCORE_GAP:
                readings[m] = self._reader.of_word(word, fit, score_gap)
        rest = [m for m, reading in enumerate(readings) if reading is None]
        if rest:
            again: Sequence[Reading | None]
            if self.resolution == 5:
                again = self._reader.read(state.clipped(rest), blur.take(rest), noise[rest])
            else:
                again = self._reader.read_cells(self._shares(state.values[rest]), blur.take(rest))
            for m, reading in zip(rest, again):
                readings[m] = reading
        return readings

    def _judged(self, image: PreparedImage, black: Bools, corners: Floats, readings: Sequence[Reading | None],
                features: Sequence[Features]) -> tuple[list[_Accepted], list[tuple[int, Reading]]]:
        """Return the markers, and (index, Reading) of candidates that were read as something else than was drawn."""
        found, changed = [], []
        for m, reading in enumerate(readings):
            missed = self._missed(image, black[m], corners[m], reading, features[m])
            if reading is None:
                continue
            if missed is None:
                found.append(_Accepted(m, reading, _read(features[m], reading)))
            elif missed[0] == 'SAME_WORD':
                changed.append((m, reading))
        return found, changed

    def _missed(self, image: PreparedImage, black: Bools, corners: Floats, reading: Reading | None,
                features: Features) -> Shortfall | None:
        """Return why a candidate is no marker: it was read as something else than was drawn, or misses a threshold."""
        inner = slice(self.margin, self.margin + self.resolution)
        if reading is None:
            return 'CHANGED_FIT', 0.0, thresholds.CHANGED_FIT
        if (black[inner, inner] == reading.white).any():
            sure = reading.fit > thresholds.CHANGED_FIT
            return ('SAME_WORD', 0.0, 0.0) if sure else ('CHANGED_FIT', reading.fit, thresholds.CHANGED_FIT)
        seen = _read(features, reading)
        return acceptance.shortfall(seen) or self._other_margin(image, corners, seen.correlation)

    def _uncover(self, image: PreparedImage, state: Alignment, blur: Covariance, black: Bools, corners: Floats,
                 readings: Sequence[Reading | None], features: Sequence[Features], found: list[_Accepted],
                 changed: list[tuple[int, Reading]]) -> None:
        """Read the rejected candidates again, without the cells that may be covered."""
        if self._covered is None:
            return
        taken = [each.place for each in found]
        for m, reading in enumerate(readings):
            seen = features[m]
            if reading is None or m in taken or not may_be_covered(_read(seen, reading), reading.fit):
                continue
            near = thresholds.OVERLAP * float(homography.mean_side(corners[m:m + 1])[0])
            if any(math.dist(corners[m].mean(0), corners[k].mean(0)) < near for k in taken):
                continue
            shares, noise = (state.values[m] - state.dark[m]) / state.gain[m], seen.noise / max(seen.contrast, 1.0)
            again = self._covered.read(shares, noise, Covariance(*(each[m] for each in blur)))
            if again is None:
                continue
            reading = self._reader.of_word(again.word, 1 - again.error, again.score_gap)
            if (black_cells(reading.white, self.margin) != black[m]).any():
                changed[:] = [each for each in changed if each[0] != m] + [(m, reading)]
            elif again.score_gap > thresholds.COVERED_SCORE_GAP + thresholds.COVERED_SCORE_GAP_BY_ERROR * again.error \
                    and seen.likeness > thresholds.COVERED_LIKENESS \
                    and self._other_margin(image, corners[m], seen.correlation) is None:
                found.append(_Accepted(m, reading, _read(seen, reading)))

    def _other_margin(self, image: PreparedImage, corners: Floats, correlation: float = 0.0) -> Shortfall | None:
        """Return the margin with which the cells match a code word better, if it is one cell narrower or wider.

        Return None if the ``correlation`` is so high that the margin must be right.
        """
        if correlation > thresholds.SURE_MARGIN_CORRELATION or self._decoder.words is None:
            return None
        real = np.stack(image.camera.to_real(corners[:, 0], corners[:, 1]), -1)
        return self._decoder.other_margin(image.smooth, real)

    def _has_other_margin(self, image: PreparedImage, found: Found) -> bool:
        """Return whether a marker of uneven light has another margin."""
        missed = self._other_margin(image, found.corners)
        if missed is not None:
            self._end(np.stack(image.camera.to_real(*found.corners.T), -1), missed, found.word)
        return missed is not None

    def _end_at(self, image: PreparedImage, h: Floats, missed: Shortfall | None,
                reading: Reading | None = None) -> None:
        """Note for explain() that a candidate at ``h`` (3, 3) was rejected here."""
        if self._ended is not None:
            corners = homography.apply(h[None], self._corners.square)[0]
            word = int(reading.content.value) if reading is not None and self._search is not None else -1
            self._end(np.stack(image.camera.to_real(*corners.T), -1), missed, word)

    def _end(self, quad: Floats, missed: Shortfall | None, word: int = -1) -> None:
        """Note for explain() that a candidate quad (4, 2) [real px] was rejected here."""
        if self._ended is not None and missed is not None:
            self._ended.append((quad, *missed, word))

    def _detections(self, image: PreparedImage, state: Alignment, corners: Floats,
                    found: Sequence[_Accepted]) -> list[Detection]:
        """Return the Detections of the accepted markers whose pose fits their corners, or whose code is clear."""
        if not found:
            return []
        which = np.array([each.place for each in found])
        corners, information = self._corners.measure(
            image, self._aligner, state.take(which), corners[which],
            np.array([black_cells(each.reading.white, self.margin) for each in found]),
            np.array([each.features.inlier_share for each in found]))
        order = np.array([[(k + each.reading.content.turns) % 4 for k in range(4)] for each in found])
        eight = (2 * order[:, :, None] + [0, 1]).reshape(-1, 8)
        corners = np.take_along_axis(corners, order[:, :, None], 1)
        information = information[np.arange(len(found))[:, None, None], eight[:, :, None], eight[:, None]]
        sizes = [self.sizes.get(each.reading.content.value, self.size) for each in found]
        real = np.stack(image.camera.to_real(corners[..., 0], corners[..., 1]), -1)
        sides = np.sqrt(homography.area(real))
        out = []
        for m, solutions in enumerate(pose.solve(corners, sizes, image.camera, information)):
            sure = acceptance.is_sure(found[m].features)
            if solutions and (sure or not _misses_pose(solutions, sides[m])):
                out.append(_detection(found[m].reading.content.value, real[m], solutions, found[m].features,
                                      information[m]))
            else:
                self._end(real[m], _missed_by_pose(solutions, float(sides[m])))
        return out


def _read(features: Features, reading: Reading) -> Features:
    """Return the Features of a candidate after its cells were read."""
    return features._replace(fit=reading.fit, score_gap=reading.score_gap, edges=reading.edges)


def _misses_pose(solutions: Sequence[pose.Solution], side: float) -> bool:
    """Return whether no pose agrees with the corners of a marker that is ``side`` [px] wide."""
    return not solutions or not solutions[0].error < thresholds.MAX_POSE_ERROR * side


def _doubted(detection: Detection) -> Detection:
    """Return the Detection, marked as doubtful if its pose does not agree with its corners."""
    if _misses_pose(detection.solutions, detection.side):
        detection.doubtful = True
        detection.reason = NO_SQUARE.format(detection.error / detection.side)
    return detection


def _missed_by_pose(solutions: Sequence[pose.Solution], side: float) -> Shortfall:
    return 'MAX_POSE_ERROR', solutions[0].error / side if solutions else math.inf, thresholds.MAX_POSE_ERROR


def _detection(value: int | str, corners: Floats, solutions: list[pose.Solution], features: Features,
               information: Floats) -> Detection:
    share, ambiguous = pose.ambiguity(solutions)
    best = solutions[0]
    return _doubted(Detection(value, corners, best.rotation, best.position, features.likeness, share, ambiguous,
                              best.error, solutions, features, information))


def _is_not_flat(detection: Detection) -> bool:
    """Return whether no plane fits the corners of a marker; the limit is higher in uneven light."""
    limit = thresholds.MAX_FLAT_CHI2 if _is_in_even_light(detection) else thresholds.MAX_UNEVEN_CHI2
    return detection.solutions[0].chi2 > limit


def _is_in_even_light(detection: Detection) -> bool:
    return detection.features is not None and detection.features.inlier_share > thresholds.EVEN_INLIER_SHARE


def _real_corners(sheet: Sheet, camera: Camera) -> Floats:
    return np.stack(camera.to_real(sheet.corners[:, 0], sheet.corners[:, 1]), -1)


def _bend(detection: Detection, sheet: Sheet, camera: Camera) -> None:
    """Take the corners and the pose of a Sheet."""
    detection.corners = _real_corners(sheet, camera)
    detection.rotation, detection.position, detection.error = sheet.rotation, sheet.position, sheet.error
    detection.solutions = [pose.Solution(sheet.rotation, sheet.position, sheet.error, 0.0)]
    detection.ambiguous, detection.ambiguity = not sheet.sure, 0.0 if sheet.sure else 0.5
    detection.bend = sheet.bend
    detection.forget_size()


def _start_blur(cells: float, cell: Floats, level: Integers) -> Floats:
    """Return the variance (M,) [px^2 at the level] of a blur of ``cells`` cells, each ``cell`` (M,) [px] wide."""
    blur: Floats = np.maximum(1.0, (cells * cell / 2.0 ** level) ** 2)
    return blur
