"""Whether a transform has changed enough to be sent."""
import math
from typing import NamedTuple, Optional, Sequence, Tuple

MIN_RATE, MAX_RATE = 0.01, 1000.0  # [Hz]
MAX_FRAMES = 1000  # of a request


class InvalidRequest(ValueError):
    """A request that cannot be served; the text says why."""


class Transform(NamedTuple):
    """A translation (x, y, z) [m] and a rotation, the quaternion (x, y, z, w)."""

    translation: Tuple[float, ...]
    rotation: Tuple[float, ...]


class Thresholds(NamedTuple):
    """How far a transform must move [m] or turn [rad] to be sent again; 0: it is always sent."""

    linear: float
    angular: float

    def passed(self, sent: Optional[Transform], now: Transform) -> bool:
        """Return whether to send ``now`` after ``sent``, which is None if nothing was sent."""
        return (sent is None or not self.linear or not self.angular
                or distance(sent.translation, now.translation) > self.linear
                or angle(sent.rotation, now.rotation) > self.angular)


def distance(first: Sequence[float], second: Sequence[float]) -> float:
    """Return the distance [m] between two points."""
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(first, second)))


def angle(first: Sequence[float], second: Sequence[float]) -> float:
    """Return the angle [rad], 0 to pi, between two rotations; q and -q are the same rotation."""
    length = math.sqrt(sum(part * part for part in first) * sum(part * part for part in second))
    if not length:
        return 0.0
    return 2.0 * math.acos(min(1.0, abs(sum(a * b for a, b in zip(first, second))) / length))


def check(frames: Sequence[str], target: str, thresholds: Thresholds, rate: float) -> None:
    """Raise InvalidRequest if a request cannot be served."""
    if not target.strip('/'):
        raise InvalidRequest('target_frame is empty; it must be the name of a frame')
    if not all(frame.strip('/') for frame in frames):
        raise InvalidRequest('source_frames has an empty name')
    if len(frames) > MAX_FRAMES:
        raise InvalidRequest(f'source_frames has {len(frames)} names; {MAX_FRAMES} are allowed')
    if not MIN_RATE <= rate <= MAX_RATE:
        raise InvalidRequest(f'rate is {rate:g} Hz; it must be from {MIN_RATE:g} to {MAX_RATE:g}')
    if not (0.0 <= thresholds.linear < math.inf and 0.0 <= thresholds.angular < math.inf):
        raise InvalidRequest(f'trans_thres is {thresholds.linear:g} and angular_thres {thresholds.angular:g}; '
                             'they must be at least 0')
