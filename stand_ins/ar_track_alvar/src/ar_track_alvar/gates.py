"""What is let through: pictures by their rate, markers by how well they fit."""
import numpy as np

from alvar_core.detection import homography


class RateGate:
    """Lets through at most ``rate`` [Hz] on average; one that comes a bit early is not lost. Time may jump back."""

    def __init__(self, rate):
        self.rate = rate
        self._due = -np.inf

    def open(self, now):
        """Return whether something that comes ``now`` [s] may pass, and count it if so."""
        period = 1.0 / self.rate
        if self._due - period <= now < self._due:  # earlier than that: time has jumped back
            return False
        self._due = min(max(self._due, now - period), now) + period
        return True


def fit_error(detection):
    """Rms distance of the corners from where the pose puts them, in parts of the side as it is seen."""
    return detection.error / np.sqrt(abs(homography.area(detection.corners[None])[0]))


class ErrorGate:
    """Lets through markers by fit_error(): stricter for ids that were not in the picture before."""

    def __init__(self):
        self._before = set()

    def reset(self):
        """Forget what was in the last picture."""
        self._before = set()

    def passed(self, detections, max_new, max_track):
        """Return the Detections of the next picture that fit well enough."""
        kept = [d for d in detections if fit_error(d) <= (max_track if d.id in self._before else max_new)]
        self._before = {d.id for d in kept}
        return kept
