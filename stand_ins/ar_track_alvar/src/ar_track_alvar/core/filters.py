"""Filter images by their rate, and markers by the error of their pose."""
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
        """Return whether to accept an image that arrives at ``now`` [s]; if so, count it."""
        period = 1.0 / self.rate
        if self._due - period <= now < self._due:  # else time has jumped back
            return False
        self._due = min(max(self._due, now - period), now) + period
        return True


def fit_error(detection: Detection) -> float:
    """Return the rms reprojection error of the corners, as share of the side in the image."""
    return float(detection.error / np.sqrt(abs(homography.area(detection.corners[None])[0])))


class ErrorFilter:
    """Accepts markers by fit_error(); it is stricter for ids that were not in the previous image."""

    def __init__(self) -> None:
        self._previous: Set[Union[int, str]] = set()

    def reset(self) -> None:
        """Forget the previous image."""
        self._previous = set()

    def accepted(self, detections: Sequence[Detection], max_new: float, max_track: float) -> List[Detection]:
        """Return the Detections of the next image whose error is small enough."""
        kept = [d for d in detections if fit_error(d) <= (max_track if d.id in self._previous else max_new)]
        self._previous = {d.id for d in kept}
        return kept
