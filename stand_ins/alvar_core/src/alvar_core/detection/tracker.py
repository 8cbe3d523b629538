"""Marker tracking over images: the last poses tell where to look; only what is in the current image is reported.

* Every frame, the markers of the last frame are looked for where they should be now. Their cells are read again, so a
  swapped, turned or covered marker is reported correctly in the same frame.
* Around a marker that is missing the image is searched at once.
* The passes of the search of the whole image (candidates.PASSES) are spread over `full_every` frames; any one of them
  finds most new markers. While no marker is tracked, every frame runs all passes.
* A caller with time left before the next image calls search_rest(): it runs the passes that update() skipped, and the
  next update() looks where they found something.

Of the two poses of the planar ambiguity, the tracker chooses the one that agrees with the motion so far, unless the
image alone decides.

Not thread safe: one thread calls update().
"""
import math
from dataclasses import dataclass, replace

import numpy as np

from alvar_core.detection import candidates, homography, pose
from alvar_core.detection.detection import best_of_overlapping
from alvar_core.rotations import angle_between

MOTION_SIGMA = np.radians(12.0)  # how far a marker may turn between frames without being odd
MEMORY_FRAMES, LOOKED_FOR_FRAMES = 10, 3
WITHIN_REACH = 0.1  # of the side: a motion that the refinement of the corners makes up for
EVIDENCE_DECAY, EVIDENCE_LIMIT = 0.9, 40.0


@dataclass(eq=False)  # each is itself: several may have one id, and arrays cannot be compared
class Track:
    """A marker being followed: its last Detection, corners one frame earlier, frames since, rotation, evidence."""

    detection: object
    before: np.ndarray
    missed: int
    rotation: np.ndarray
    evidence: float


class Tracker:
    """Detector over a sequence of pictures of one camera.  detector: Detector; full_every: frames, 1 or more."""

    def __init__(self, detector, full_every=3):
        if not isinstance(full_every, int) or full_every < 1:
            raise ValueError(f'full_every {full_every!r}: a whole number from 1 on is needed')
        self.detector, self.full_every = detector, full_every
        self.reset()

    def reset(self):
        """Forget everything."""
        self.tracks, self.frame, self.shape = [], 0, None
        self._hints, self._rest = [], None  # corners to look at next; (view, passes not made) of the last picture

    def update(self, picture, camera):
        """Return the Detections of the next picture.  Raises PictureError."""
        self._rest = None
        view = self.detector.view(picture, camera)
        if view.grey.shape != self.shape:
            self.reset()
            self.shape = view.grey.shape
        self.frame += 1
        return self._follow(self._search(view))

    def search_rest(self):
        """Make the passes that the last update() left out; its picture must be unchanged.

        What is found is not reported: it is looked for in the next picture.
        """
        (view, passes), self._rest = self._rest or (None, ()), None
        if not passes:
            return
        quads = candidates.candidates(view.smooth, passes, self.detector.workspace)
        known = [t.detection.corners for t in self.tracks if t.missed == 0]
        if known:
            quads = quads[~_alike(quads, known)]
        self._hints = [d.corners for d in self.detector.examine(view, quads)]

    def _search(self, view):
        expected = self._expected()
        phase, count = self.frame % self.full_every, len(candidates.PASSES)
        alone = not len(expected)
        passes = [p for k, p in enumerate(candidates.PASSES) if alone or k * self.full_every // count == phase]
        self._rest = view, [p for p in candidates.PASSES if p not in passes]
        quads = candidates.candidates(view.smooth, passes, self.detector.workspace)
        if not alone:
            quads = np.concatenate([expected, quads[~_alike(quads, expected)]])
        found = self.detector.examine(view, quads)
        missing = [t.detection.corners for t in self.tracks
                   if t.missed < LOOKED_FOR_FRAMES and not any(d.id == t.detection.id for d in found)]
        quads = self._near(view, missing)
        return best_of_overlapping(found + self.detector.examine(view, quads)) if len(quads) else found

    def _expected(self):
        """Corners (K, 4, 2) where the markers should be now: as last seen, and moved on by their last motion."""
        quads, self._hints = self._hints, []
        for track in self.tracks:
            last = track.detection.corners
            quads.append(last)
            if track.before is not None and track.missed == 0:
                step = last - track.before
                if np.abs(step).max() > WITHIN_REACH * track.detection.side:
                    quads.append(last + step)
        quads = np.array(quads).reshape(-1, 4, 2)
        return quads[homography.area(quads) > 0]

    def _near(self, view, expected):
        """Candidates in the surroundings of the expected quads."""
        height, width = self.shape
        found = []
        for box in _boxes(expected, width, height):
            x0, y0, x1, y1 = box
            quads = candidates.candidates(np.ascontiguousarray(view.smooth[y0:y1, x0:x1]))
            found.append(quads + [x0, y0])
        return np.concatenate(found) if found else np.zeros((0, 4, 2))

    def _follow(self, found):
        old = {}
        for track in self.tracks:
            old.setdefault(track.detection.id, []).append(track)
        out, tracks = [], []
        for detection in found:
            track = _nearest(old.get(detection.id, []), detection)
            if track is not None:
                old[detection.id].remove(track)
            detection, rotation, evidence = _weigh(detection, track)
            before = track.detection.corners if track is not None and track.missed == 0 else None
            out.append(detection)
            tracks.append(Track(detection, before, 0, rotation, evidence))
        left = [t for group in old.values() for t in group]
        for track in left:
            if track.missed < MEMORY_FRAMES and not _covered_by(track, out):
                tracks.append(replace(track, missed=track.missed + 1, before=None))
        self.tracks = tracks
        return out


def _boxes(quads, width, height):
    """Boxes (x0, y0, x1, y1) around quads with half a side to spare, those that touch joined."""
    boxes = []
    for quad in quads:
        low, high = quad.min(0), quad.max(0)
        spare = 0.5 * (high - low).max() + 8
        low, high = np.maximum(low - spare, 0), np.minimum(high + spare + 1, [width, height])
        box = [int(low[0]), int(low[1]), int(high[0]), int(high[1])]
        if box[2] - box[0] < 16 or box[3] - box[1] < 16:
            continue
        merged = True
        while merged:
            merged = False
            for other in boxes:
                if box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]:
                    boxes.remove(other)
                    box = [min(box[0], other[0]), min(box[1], other[1]), max(box[2], other[2]), max(box[3], other[3])]
                    merged = True
                    break
        boxes.append(box)
    return boxes


def _alike(quads, expected):
    """Which quads (N, 4, 2) lie where an expected one lies and are about as large: they would only be read twice."""
    expected = np.asarray(expected)
    side, there = np.sqrt(np.abs(homography.area(quads)))[:, None], np.sqrt(homography.area(expected))
    away = np.abs(quads.mean(1)[:, None] - expected.mean(1)).max(2)
    return ((away < 0.1 * there) & (side < 1.2 * there) & (there < 1.2 * side)).any(1)


def _nearest(tracks, detection):
    best = min(tracks, key=lambda t: math.dist(t.detection.centre, detection.centre), default=None)
    if best is None or math.dist(best.detection.centre, detection.centre) > 2 * detection.side * (1 + best.missed):
        return None
    return best


def _covered_by(track, found):
    """Whether another marker is now where this one was."""
    centre = track.detection.corners.mean(0)
    return any(np.abs(d.corners.mean(0) - centre).max() < 0.5 * np.ptp(d.corners, 0).max() for d in found)


def _weigh(detection, track):
    """Choose between the two poses with the help of the past: (the Detection, changed, rotation, evidence for it).

    Evidence is a sum of chi2 differences over frames, older ones decaying: from pose.AMBIGUOUS_CHI2 on it is sure.
    """
    solutions = detection.solutions
    if len(solutions) < 2 or angle_between(solutions[0].rotation, solutions[1].rotation) < pose.SAME_ROTATION:
        return detection, detection.rotation, EVIDENCE_LIMIT
    gain = pose.scaled_difference(solutions)
    if track is None or track.missed > 2:
        return detection, detection.rotation, min(gain, EVIDENCE_LIMIT)
    turn = [angle_between(track.rotation, s.rotation) for s in solutions]
    same = turn[0] <= turn[1]
    motion = (min(turn[1], 0.5) ** 2 - min(turn[0], 0.5) ** 2) / MOTION_SIGMA ** 2
    past = track.evidence * EVIDENCE_DECAY * min(abs(motion), 1.0)
    total = gain + (past if same else -past)
    best = 0 if total >= 0 else 1
    chosen = solutions[best]
    share = 1 / (1 + math.exp(min(abs(total) / 2, 50)))
    ambiguous = bool(abs(total) < pose.AMBIGUOUS_CHI2)
    ordered = [chosen, solutions[1 - best]]
    detection.rotation, detection.position, detection.error = chosen.rotation, chosen.position, chosen.error
    detection.ambiguity, detection.ambiguous, detection.solutions = share, ambiguous, ordered
    return detection, chosen.rotation, min(abs(total), EVIDENCE_LIMIT)
