"""What a Detector finds: one marker each."""
import math
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np

from alvar_core.rotations import quaternion_from_matrix


@dataclass
class Detection:
    """One marker.

    id: its number, or its text; corners (4, 2) real px: top left, top right, bottom right, bottom left as drawn;
    rotation (3, 3), position (3,) m and quaternion (x y z w): the marker in the camera's optical frame;
    confidence 0..1; ambiguity 0..0.5: probability of the other pose; ambiguous: not to be told apart in this picture;
    error: rms reprojection error of the corners, px; solutions: both poses (pose.Solution), best first.
    """

    id: object
    corners: np.ndarray
    rotation: np.ndarray
    position: np.ndarray
    confidence: float
    ambiguity: float
    ambiguous: bool
    error: float
    solutions: list = field(repr=False)
    features: dict = field(repr=False, default_factory=dict)

    @cached_property
    def centre(self):
        """Mean of the corners, real px."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return (ax + bx + cx + dx) / 4, (ay + by + cy + dy) / 4

    @cached_property
    def side(self):
        """Side of a square of the same area, px."""
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = self.corners.tolist()
        return math.sqrt(abs((ax - cx) * (by - dy) - (ay - cy) * (bx - dx)) / 2)

    def covers(self, point):
        """Whether a point, real px, lies on the marker."""
        if math.dist(point, self.centre) > 4 * self.side:  # a square that is seen at all is not longer
            return False
        return cv2.pointPolygonTest(self.corners.astype(np.float32), point, False) >= 0

    @property
    def confidence_percent(self):
        """Confidence as a whole number from 0 to 100."""
        return int(round(100 * min(1.0, max(0.0, self.confidence))))

    @property
    def quaternion(self):
        """Orientation x y z w in the camera's optical frame."""
        return quaternion_from_matrix(self.rotation)


def best_of_overlapping(found):
    """Of Detections that lie on each other the one with the highest confidence; cells of a marker are no marker."""
    kept = []
    for d in sorted(found, key=lambda d: -d.confidence):
        if all(math.dist(d.centre, k.centre) > 0.4 * d.side and not k.covers(d.centre) for k in kept):
            kept.append(d)
    return kept
