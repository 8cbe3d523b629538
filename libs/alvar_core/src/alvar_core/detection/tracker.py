"""Marker tracking over images: the last poses tell where to look; only what is in the current image is reported.

* Every frame, the markers of the last frame are looked for where they should be now. Their cells are read again, so a
  swapped, turned or covered marker is reported correctly in the same frame.
* Around a marker that is missing the image is searched at once.
* The passes of the search of the whole image (thresholds.PASSES) are spread over `full_every` frames; any one of them
  finds most new markers. While no marker is tracked, every frame runs all passes.
* A caller with time left before the next image calls search_rest(): it runs the passes that update() skipped, and the
  next update() looks where they found something.

Of the two poses of the planar ambiguity, the tracker chooses the one that agrees with the motion so far, unless the
image alone decides.

Not thread safe: one thread calls update().
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence, Tuple

import numpy as np

from alvar_core.arrays import Bools, Floats, Image
from alvar_core.camera import Camera
from alvar_core.detection import candidates, homography, pose, thresholds
from alvar_core.detection.detection import Detection, best_of_overlapping
from alvar_core.detection.detector import Detector
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.thresholds import Pass
from alvar_core.rotations import angle_between


@dataclass(eq=False)  # compared by identity: several may have one id, and arrays cannot be compared
class Track:
    """A marker being tracked.

    detection: the last one; before: its corners one frame earlier, (4, 2) px, None if it was not seen then; missed:
    frames since; evidence: chi2 for its pose against the other one.
    """

    detection: Detection
    before: Floats | None
    missed: int
    evidence: float


class Tracker:
    """Detector over a sequence of images of one camera.  full_every: frames over which the full search is spread."""

    def __init__(self, detector: Detector, full_every: int = 3) -> None:
        if not isinstance(full_every, int) or full_every < 1:
            raise ValueError(f'full_every {full_every!r}: a whole number of at least 1 is needed')
        self.detector, self.full_every = detector, full_every
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.tracks: list[Track] = []
        self._frame = 0
        self._shape: tuple[int, ...] = ()
        self._hints: list[Floats] = []  # corners to look at next
        self._skipped: tuple[PreparedImage, list[Pass]] | None = None  # the last image, the passes not run on it

    def update(self, image: Image, camera: Camera) -> list[Detection]:
        """Return the Detections of the next image. Raises ImageError, CameraError."""
        self._skipped = None
        prepared = self.detector.prepare(image, camera)
        if prepared.grey.shape != self._shape:
            self.reset()
            self._shape = prepared.grey.shape
        self._frame += 1
        return self._tracked(self._search(prepared))

    def search_rest(self) -> None:
        """Run the passes that the last update() skipped; its image must be unchanged.

        What is found is not reported: the next update() looks there.
        """
        skipped, self._skipped = self._skipped, None
        if skipped is None or not skipped[1]:
            return
        image, passes = skipped
        quads = candidates.candidates(image.smooth, passes, self.detector.buffers)
        known = [t.detection.corners for t in self.tracks if t.missed == 0]
        if known:
            quads = quads[~_alike(quads, np.asarray(known))]
        self._hints = [d.corners for d in self.detector.examine(image, quads)]

    def _search(self, image: PreparedImage) -> list[Detection]:
        expected = self._expected()
        phase, count = self._frame % self.full_every, len(thresholds.PASSES)
        alone = not len(expected)
        runs = [alone or k * self.full_every // count == phase for k in range(count)]
        passes = [each for each, run in zip(thresholds.PASSES, runs) if run]
        self._skipped = image, [each for each, run in zip(thresholds.PASSES, runs) if not run]
        quads = candidates.candidates(image.smooth, passes, self.detector.buffers)
        if not alone:
            quads = np.concatenate([expected, quads[~_alike(quads, expected)]])
        found = self.detector.examine(image, quads)
        missing = [t.detection.corners for t in self.tracks
                   if t.missed < thresholds.SEARCHED_FRAMES and not any(d.id == t.detection.id for d in found)]
        quads = self._near(image, missing)
        return best_of_overlapping(found + self.detector.examine(image, quads)) if len(quads) else found

    def _expected(self) -> Floats:
        """Corners (K, 4, 2) where the markers should be now: as last seen, and moved on by their last motion."""
        quads, self._hints = self._hints, []
        for track in self.tracks:
            last = track.detection.corners
            quads.append(last)
            if track.before is not None and track.missed == 0:
                step = last - track.before
                if np.abs(step).max() > thresholds.MIN_TRACKED_STEP * track.detection.side:
                    quads.append(last + step)
        expected = np.array(quads).reshape(-1, 4, 2)
        return expected[homography.area(expected) > 0]

    def _near(self, image: PreparedImage, expected: Sequence[Floats]) -> Floats:
        """Candidates in the surroundings of the expected quads."""
        height, width = image.grey.shape
        found = [np.zeros((0, 4, 2))]
        for x0, y0, x1, y1 in _boxes(expected, width, height):
            quads = candidates.candidates(np.ascontiguousarray(image.smooth[y0:y1, x0:x1]))
            found.append(quads + [x0, y0])
        return np.concatenate(found)

    def _tracked(self, found: Sequence[Detection]) -> list[Detection]:
        """Continue, start and end tracks with the Detections of this frame; return them with their poses chosen."""
        old: dict[int | str, list[Track]] = {}
        for track in self.tracks:
            old.setdefault(track.detection.id, []).append(track)
        out, tracks = [], []
        for detection in found:
            last = _nearest(old.get(detection.id, []), detection)
            if last is not None:
                old[detection.id].remove(last)
            detection, evidence = _weighed(detection, last)
            before = last.detection.corners if last is not None and last.missed == 0 else None
            out.append(detection)
            tracks.append(Track(detection, before, 0, evidence))
        for group in old.values():
            for track in group:
                if track.missed < thresholds.TRACK_MEMORY and not _covered_by(track, out):
                    tracks.append(replace(track, missed=track.missed + 1, before=None))
        self.tracks = tracks
        return out


Box = Tuple[int, int, int, int]  # left, top, right, bottom, px


def _boxes(quads: Sequence[Floats], width: int, height: int) -> list[Box]:
    """Boxes around quads with room to spare; boxes that touch are joined."""
    boxes: list[Box] = []
    for quad in quads:
        low, high = quad.min(0), quad.max(0)
        spare = thresholds.SEARCH_SPARE * (high - low).max() + 8
        low, high = np.maximum(low - spare, 0), np.minimum(high + spare + 1, [width, height])
        box = int(low[0]), int(low[1]), int(high[0]), int(high[1])
        if box[2] - box[0] >= 16 and box[3] - box[1] >= 16:
            boxes = _joined(boxes, box)
    return boxes


def _joined(boxes: Sequence[Box], box: Box) -> list[Box]:
    """The boxes and another one; those that it touches become one with it."""
    apart = list(boxes)
    while True:
        other = next((b for b in apart if _touch(b, box)), None)
        if other is None:
            return [*apart, box]
        apart.remove(other)
        box = (min(box[0], other[0]), min(box[1], other[1]), max(box[2], other[2]), max(box[3], other[3]))


def _touch(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _alike(quads: Floats, expected: Floats) -> Bools:
    """Which quads (N, 4, 2) lie where an expected one (K, 4, 2) lies and are about as large: read those only once."""
    side, there = homography.mean_side(quads)[:, None], np.sqrt(homography.area(expected))
    away = np.abs(quads.mean(1)[:, None] - expected.mean(1)).max(2)
    ratio = thresholds.SAME_SIZE
    alike = (away < thresholds.SAME_PLACE * there) & (side < ratio * there) & (there < ratio * side)
    known: Bools = alike.any(1)
    return known


def _nearest(tracks: Sequence[Track], detection: Detection) -> Track | None:
    """The track that a detection may continue, None if all are too far away."""
    best = min(tracks, key=lambda t: math.dist(t.detection.centre, detection.centre), default=None)
    if best is None:
        return None
    reach = thresholds.TRACK_REACH * detection.side * (1 + best.missed)
    return best if math.dist(best.detection.centre, detection.centre) <= reach else None


def _covered_by(track: Track, found: Sequence[Detection]) -> bool:
    """Whether another marker is now where this one was."""
    centre = track.detection.corners.mean(0)
    return any(np.abs(d.corners.mean(0) - centre).max() < thresholds.COVERED_BY * np.ptp(d.corners, 0).max()
               for d in found)


def _weighed(detection: Detection, track: Track | None) -> tuple[Detection, float]:
    """Choose between the two poses with the help of the past; return the Detection, changed, and the evidence for it.

    Evidence is a sum of chi2 differences over frames, older ones decaying: from AMBIGUOUS_CHI2 on it is sure.
    """
    solutions = detection.solutions
    if pose.are_one(solutions):
        return detection, thresholds.MAX_EVIDENCE
    gain = pose.scaled_difference(solutions)
    if track is None or track.missed > thresholds.EVIDENCE_FRAMES:
        return detection, min(gain, thresholds.MAX_EVIDENCE)
    turns = [angle_between(track.detection.rotation, solution.rotation) for solution in solutions]
    first, second = (min(turn, thresholds.MAX_TURN) ** 2 for turn in turns)
    motion = (second - first) / thresholds.TURN_SIGMA ** 2
    past = track.evidence * thresholds.EVIDENCE_DECAY * min(abs(motion), 1.0)
    total = gain + (past if turns[0] <= turns[1] else -past)
    best = 0 if total >= 0 else 1
    chosen, other = solutions[best], solutions[1 - best]
    detection.rotation, detection.position, detection.error = chosen.rotation, chosen.position, chosen.error
    detection.ambiguity = 1 / (1 + math.exp(min(abs(total) / 2, 50)))
    detection.ambiguous = bool(abs(total) < thresholds.AMBIGUOUS_CHI2)
    detection.solutions = [chosen, other]
    return detection, min(abs(total), thresholds.MAX_EVIDENCE)
