"""Filters: images by their rate, markers by how well they fit."""
from typing import List, Sequence, Set, Union

import numpy as np

from alvar_core.detection import homography
from alvar_core.detection.detection import Detection


class RateLimiter:
    """Accepts at most ``rate`` [Hz] images on average; slightly early ones are accepted. Time may jump back."""

    def __init__(self, rate: float) -> None:
        self.rate = rate
        self._due = -np.inf

    def accept(self, now: float) -> bool:
        """Return whether an image that comes ``now`` [s] is accepted, and count it if so."""
        period = 1.0 / self.rate
        if self._due - period <= now < self._due:  # earlier than that: time has jumped back
            return False
        self._due = min(max(self._due, now - period), now) + period
        return True


def fit_error(detection: Detection) -> float:
    """Return the RMS distance of the corners from where the pose puts them, relative to the side as it is seen."""
    return float(detection.error / np.sqrt(abs(homography.area(detection.corners[None])[0])))


class ErrorFilter:
    """Accepts markers by fit_error(); it is stricter for ids that were not in the previous image."""

    def __init__(self) -> None:
        self._previous: Set[Union[int, str]] = set()

    def reset(self) -> None:
        """Forget the previous image."""
        self._previous = set()

    def accepted(self, detections: Sequence[Detection], max_new: float, max_track: float) -> List[Detection]:
        """Return the Detections of the next image that fit well enough."""
        kept = [d for d in detections if fit_error(d) <= (max_track if d.id in self._previous else max_new)]
        self._previous = {d.id for d in kept}
        return kept
