"""Filter images by their rate, and markers by the error of their pose."""
from collections import deque
from typing import Deque, List, Sequence, Set, Tuple, Union

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
    """Return the rms reprojection error of the corners, as a share of the side in the image."""
    return float(detection.error / np.sqrt(abs(homography.area(detection.corners[None])[0])))


class ErrorFilter:
    """Accepts markers by fit_error(); it is stricter for ids that were not in the previous image."""

    def __init__(self) -> None:
        self._previous: Set[Union[int, str]] = set()

    def reset(self) -> None:
        """Forget the previous image."""
        self._previous = set()

    def accepted(self, detections: Sequence[Detection], max_new: float, max_track: float) -> List[Detection]:
        """Return the Detections of the next image whose error is small enough.

        The limit for tracked markers is never below the one for new markers: some launch files set ``max_track`` to 0,
        which in the original only means that every marker counts as new.
        """
        tracked = max(max_new, max_track)
        kept = [d for d in detections if fit_error(d) <= (tracked if d.id in self._previous else max_new)]
        self._previous = {d.id for d in kept}
        return kept


class MedianPose:
    """Smooths poses: returns the one of the last ``count`` poses with the smallest sum of distances to the others."""

    def __init__(self, count: int) -> None:
        self._poses: Deque[Tuple[np.ndarray, np.ndarray]] = deque(maxlen=count)

    def add(self, rotation: np.ndarray, position: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        """Add a pose, rotation (3, 3) and position (3,) [m]; return the most central one, as such a pair."""
        self._poses.append((rotation, position))
        rows = np.array([np.concatenate([turn.ravel(), place]) for turn, place in self._poses])
        distances = ((rows[:, None] - rows) ** 2).sum((1, 2))
        newest_first = len(rows) - 1 - int(np.argmin(distances[::-1]))  # the newest of equal ones
        return self._poses[newest_first]
