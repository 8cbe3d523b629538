"""Score of marker detections against frames with ground truth.

The detection of an id counts if its position projects to within a side, or a tenth of the image's width, of the centre
of the marker with that id, which is unique in a frame; without a position, the id alone counts. If there are several,
the nearest one counts, and the others are doubles. All other detections are wrong ids if they lie on a marker, else
false positives. Markers with `ignore` (cut by the image's edge) count neither as found nor as missed. A flip is a
rotation error above FLIP that is not flagged.
"""
import math
import time
from dataclasses import dataclass, field

import numpy as np

from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.markers_cli import detection_record

FLIP, GOOD = 30.0, 2.0  # [degrees] error of a flip; of a pose that must not be flagged, at most
ON_MARKER = 1.15  # times a marker's size: detections inside lie on it


def flagged(detection):
    """Return whether a detection says that its pose is uncertain."""
    return bool(detection.get('ambiguous') or detection.get('doubtful'))


@dataclass
class Match:
    """A marker of a frame that counts, and its detection; None if it was missed."""

    marker: dict
    detection: dict = None

    @property
    def position_error(self):
        """Return the position error, % of the distance."""
        return 100 * math.dist(self.detection['position'], self.marker['position']) / self.marker['distance_m']

    @property
    def rotation_error(self):
        """Return the rotation error [degrees]."""
        return rotation_between(self.detection['orientation'], self.marker['orientation'])

    @property
    def flipped(self):
        """Return whether the pose is the other solution of the planar ambiguity and not flagged as uncertain."""
        return self.rotation_error > FLIP and not flagged(self.detection)


@dataclass
class Score:
    """The markers that were found in some frames, and their errors."""

    matches: list = field(default_factory=list)
    ms: list = field(default_factory=list)  # CPU times of the detector, if they were taken
    false: int = 0
    wrong: int = 0
    double: int = 0

    def add(self, other):
        """Add the counts of another Score."""
        self.matches += other.matches
        self.ms += other.ms
        self.false += other.false
        self.wrong += other.wrong
        self.double += other.double

    @property
    def found(self):
        """Return the Matches whose detection has a pose."""
        return [m for m in self.matches if m.detection and m.detection.get('position')]

    @property
    def recall(self):
        """Return the share of markers found, %; NaN without markers."""
        found = sum(m.detection is not None for m in self.matches)
        return 100 * found / len(self.matches) if self.matches else math.nan

    def position(self, percent):
        """Return a percentile of the position errors, % of the distance."""
        return _percentile([m.position_error for m in self.found], percent)

    def rotation(self, percent):
        """Return a percentile of the rotation errors [degrees]."""
        return _percentile(self.rotations(), percent)

    def rotations(self, sure=False):
        """Return the rotation errors [degrees]; ``sure``: only of poses without a flag."""
        return [m.rotation_error for m in self.found if not (sure and flagged(m.detection))]

    def flags(self, good_only=False):
        """Return for each pose (``good_only``: if it is right) whether it is flagged."""
        return [flagged(m.detection) for m in self.found if not good_only or m.rotation_error < GOOD]

    def corners(self):
        """Return the worst corner error [px] of each marker found with corners."""
        return [float(np.linalg.norm(np.subtract(m.marker['corners'], m.detection['corners']), axis=1).max())
                for m in self.matches if m.detection and m.detection.get('corners')]

    @property
    def flips(self):
        """Return the number of poses that are flipped and not flagged as ambiguous."""
        return sum(m.flipped for m in self.found)


def _percentile(values, percent):
    return float(np.percentile(values, percent)) if values else math.nan


def rotation_between(a, b):
    """Return the angle [degrees] between two quaternions of any length above 0."""
    norm = math.hypot(*a) * math.hypot(*b)
    dot = abs(sum(x * y for x, y in zip(a, b)))
    return math.degrees(2 * math.acos(min(1.0, dot / norm))) if norm else 180.0


def _seen_at(camera, position):
    """Return the pixel (x, y), not rounded, of a position (3,) [m]; None behind the camera."""
    if position[2] <= 1e-6:
        return None
    x, y = (f * p / position[2] + c for f, p, c in zip((camera.fx, camera.fy), position, (camera.cx, camera.cy)))
    return tuple(float(v) for v in camera.to_real(x, y))


def _lies_on(marker, at):
    corners = np.array(marker['corners'])
    grown = corners.mean(0) + (corners - corners.mean(0)) * ON_MARKER
    side = np.roll(grown, -1, 0) - grown
    turn = side[:, 0] * (at[1] - grown[:, 1]) - side[:, 1] * (at[0] - grown[:, 0])
    return bool((turn >= 0).all() or (turn <= 0).all())


def score_frame(frame, camera, width, detections):
    """Return a frame's Score: its entry in frames.json, Camera, image width [px], and markers_cli's detections."""
    near = [[] for _ in frame['markers']]
    score = Score()
    for detection in detections:
        at = _seen_at(camera, detection['position']) if detection.get('position') else None
        for marker, group in zip(frame['markers'], near):
            if marker['id'] != detection['id'] or detection.get('position') and at is None:
                continue
            corners = np.array(marker['corners'])
            side = float(np.linalg.norm(np.roll(corners, -1, 0) - corners, axis=1).mean())
            away = math.dist(at, _seen_at(camera, marker['position'])) if at else 0.0
            if away <= max(side, width / 10) or marker['ignore']:
                group.append((away, detection))
                break
        else:
            on = at is not None and any(_lies_on(marker, at) for marker in frame['markers'])
            score.wrong, score.false = score.wrong + on, score.false + (not on)
    for marker, group in zip(frame['markers'], near):
        if not marker['ignore']:
            group.sort(key=lambda each: each[0])
            score.matches.append(Match(marker, group[0][1] if group else None))
            score.double += max(0, len(group) - 1)
    return score


def cameras_of(truth):
    """Return {name: Camera} of a frames.json."""
    return {name: Camera(c['K'], c['D'], (c['width'], c['height'])) for name, c in truth['cameras'].items()}


def score(truth, results):
    """Return {difficulty: Score} of markers_cli's ``frames`` on a frames.json; no result counts as empty."""
    cameras, out = cameras_of(truth), {}
    for frame in truth['frames']:
        found = results.get(frame['name'], {}).get('detections', [])
        width = truth['cameras'][frame['camera']]['width']
        out.setdefault(frame['difficulty'], Score()).add(score_frame(frame, cameras[frame['camera']], width, found))
    return out


def scored(shots, detect):
    """Return the Score of Shots that ``detect`` (image, camera) gets."""
    total = Score()
    for shot in shots:
        begun = time.thread_time()
        found = detect(shot.image, shot.camera)
        total.ms.append(1e3 * (time.thread_time() - begun))
        total.add(score_frame(shot.frame, shot.camera, shot.image.shape[1], found))
    return total


def detector_of(size, **options):
    """Return the function (image, camera) of this project's detector for markers of ``size`` [m]."""
    return records_of(Detector(size, **options).detect)


def records_of(detect):
    """Return a function that returns the detections of ``detect`` as the scorer's dictionaries."""
    return lambda *arguments: [detection_record(each) for each in detect(*arguments)]
