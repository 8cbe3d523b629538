"""Track markers over images: the last poses show where to search; only markers in the current image are reported.

* In every frame, the tracker searches for the markers of the last frame at their expected positions. It reads their
  cells again, so that a swapped, turned or covered marker is reported correctly in the same frame.
* If a marker is missing, it searches the surroundings in the same frame, also for one in uneven light.
* The passes of the search of the whole image (thresholds.PASSES) are spread over ``full_every`` frames; each of them
  finds most new markers. While no marker is tracked, every frame runs all passes.
* One of ``full_every`` frames, and the first one, searches for new markers in uneven light.
* A caller with time left before the next image calls search_rest(). It runs the passes that update() skipped, and the
  next update() examines what they have found.

Of the two poses of the planar ambiguity, the tracker chooses the one that agrees with the motion so far, unless the
image alone decides.

Not thread-safe: one thread calls update().
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


@dataclass(eq=False)  # compared by identity: several may have the same id, and arrays have no single truth value
class Track:
    """A marker that is being tracked.

    ``detection`` is the last Detection; ``before`` (4, 2) [px]: the corners one frame earlier, None if it was not
    detected there; ``missed``: frames since the detection; ``evidence`` [chi2] for its pose against the other one.
    """

    detection: Detection
    before: Floats | None
    missed: int
    evidence: float


class Tracker:
    """Detects markers in the images of one camera; spreads the full search over ``full_every`` frames."""

    def __init__(self, detector: Detector, full_every: int = 3) -> None:
        if not isinstance(full_every, int) or full_every < 1:
            raise ValueError(f'full_every {full_every!r}: a whole number of at least 1 is needed')
        self.detector, self.full_every = detector, full_every
        self.reset()

    def reset(self) -> None:
        """Forget all markers."""
        self.tracks: list[Track] = []
        self._frame = 0
        self._shape: tuple[int, ...] = ()
        self._hints: list[Floats] = []  # corners that the next update() examines
        self._stripes: float | None = None  # angle [rad] in the last image that was searched for stripes
        self._skipped: tuple[PreparedImage, list[Pass]] | None = None  # the last image, the passes not run on it

    def update(self, image: Image, camera: Camera) -> list[Detection]:
        """Return the Detections in the next image; raise ImageError or CameraError."""
        self._skipped = None
        prepared = self.detector.prepare(image, camera)
        if prepared.grey.shape != self._shape:
            self.reset()
            self._shape = prepared.grey.shape
        self._frame += 1
        return self._tracked(self._search(prepared))

    def search_rest(self) -> None:
        """Run the passes that the last update() skipped; its image must be unchanged.

        The markers found are not reported, but the next update() examines their positions.
        """
        skipped, self._skipped = self._skipped, None
        if skipped is None or not skipped[1]:
            return
        image, passes = skipped
        parts: list[Floats] = []
        quads = candidates.candidates(image.smooth, passes, self.detector.buffers, parts)
        known = [t.detection.corners for t in self.tracks if t.missed == 0]
        if known:
            quads = quads[~_alike(quads, np.asarray(known))]
        self._hints = [d.corners for d in self.detector.examine(image, quads, parts)]

    def _search(self, image: PreparedImage) -> list[Detection]:
        image.before = [each.detection for each in self.tracks]
        expected = self._expected()
        phase, count = self._frame % self.full_every, len(thresholds.PASSES)
        alone = not len(expected)
        runs = [alone or k * self.full_every // count == phase for k in range(count)]
        passes = [each for each, run in zip(thresholds.PASSES, runs) if run]
        self._skipped = image, [each for each, run in zip(thresholds.PASSES, runs) if not run]
        uneven = phase == 0 or self._frame == 1
        parts: list[Floats] | None = [] if uneven else None
        quads = candidates.candidates(image.smooth, passes, self.detector.buffers, parts)
        if not alone:
            quads = np.concatenate([expected, quads[~_alike(quads, expected)]])
        found = self.detector.examine(image, quads, parts)
        if parts:
            self._stripes = image.stripes
        missing = [t.detection.corners for t in self.tracks
                   if t.missed < thresholds.SEARCHED_FRAMES and not any(d.id == t.detection.id for d in found)]
        if not missing:
            return found
        image.stripes = self._stripes
        quads = np.concatenate([missing, self._near(image, missing)])
        return best_of_overlapping(found + self.detector.examine(image, quads))

    def _expected(self) -> Floats:
        """Return the expected corners (K, 4, 2): the last ones, and those moved on by the last motion."""
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
        """Return the candidates in the surroundings of the expected quads."""
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
    """Return boxes around quads, with a margin; boxes that overlap are joined."""
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
    """Add a box to boxes; join it with those that it overlaps."""
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
    """Return which quads (N,) have nearly the position and size of an expected one, and need not be read twice.

    ``quads`` (N, 4, 2), ``expected`` (K, 4, 2).
    """
    side, there = homography.mean_side(quads)[:, None], np.sqrt(homography.area(expected))
    away = np.abs(quads.mean(1)[:, None] - expected.mean(1)).max(2)
    ratio = thresholds.SAME_SIZE
    alike = (away < thresholds.SAME_PLACE * there) & (side < ratio * there) & (there < ratio * side)
    known: Bools = alike.any(1)
    return known


def _nearest(tracks: Sequence[Track], detection: Detection) -> Track | None:
    """Return the nearest track, which the detection continues; None if all are too far away."""
    best = min(tracks, key=lambda t: math.dist(t.detection.centre, detection.centre), default=None)
    if best is None:
        return None
    reach = thresholds.TRACK_REACH * detection.side * (1 + best.missed)
    return best if math.dist(best.detection.centre, detection.centre) <= reach else None


def _covered_by(track: Track, found: Sequence[Detection]) -> bool:
    """Return whether another marker is now where this one was."""
    centre = track.detection.corners.mean(0)
    return any(np.abs(d.corners.mean(0) - centre).max() < thresholds.COVERED_BY * np.ptp(d.corners, 0).max()
               for d in found)


def _weighed(detection: Detection, track: Track | None) -> tuple[Detection, float]:
    """Choose between the two poses, using earlier frames; change the Detection, and return it with the evidence.

    The evidence is a sum of chi2 differences over frames, in which older ones decay. From AMBIGUOUS_CHI2 on, the pose
    is sure.
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
