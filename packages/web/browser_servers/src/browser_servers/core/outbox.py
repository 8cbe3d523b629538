"""The data that wait for a client: answers and statuses in order, and the newest messages of each topic.

The order of sending: answers and statuses, then small messages, then large ones, each kind in the order of arrival.
Messages of a topic without a limit may be late by LATEST; then newer ones replace them, so that a slow client sees the
present, not the past. A large message that has waited for PATIENCE is sent next.

Threading contract: one thread uses an Outbox.
"""
import collections
import math
from typing import Any, Deque, Dict, NamedTuple, Optional, Tuple

SMALL = 16384  # [B]
BURST = 100  # waiting messages of a topic, if the client sets no queue length
BURST_BYTES = 1 << 20  # [B] of these messages
LATEST = 0.1  # [s]
PATIENCE = 1.0  # [s]
MAX_ANSWERS = 64 << 20  # [B] of answers and statuses
Answer = Tuple[Any, int]


class Full(Exception):
    """The client does not read its answers."""


class _Waiting(NamedTuple):
    arrived: float
    item: Any
    size: int
    kept: bool


class _Lane:
    """A topic: its waiting messages, and when the next one may be sent."""

    def __init__(self) -> None:
        self.waiting: Deque[_Waiting] = collections.deque()
        self.size = 0
        self.period, self.length, self.due = 0.0, 0, -math.inf

    def put(self, waiting: _Waiting) -> None:
        self.waiting.append(waiting)
        self.size += waiting.size
        newest_only = waiting.size > SMALL or self.period > 0
        limit = self.length or (1 if newest_only and not waiting.kept else BURST)
        while len(self.waiting) > limit or (self.size > BURST_BYTES and len(self.waiting) > 1):
            self.drop()

    def drop(self) -> _Waiting:
        first = self.waiting.popleft()
        self.size -= first.size
        return first

    def forget_late(self, now: float) -> None:
        if not self.length:
            while len(self.waiting) > 1 and not self.waiting[0].kept and self.waiting[0].arrived < now - LATEST:
                self.drop()

    def rank(self, now: float) -> Tuple[bool, float]:
        first = self.waiting[0]
        return first.size > SMALL and first.arrived > now - PATIENCE, first.arrived


class Outbox:
    """The waiting data of one client."""

    def __init__(self) -> None:
        self._answers: Deque[Answer] = collections.deque()
        self._answers_size = 0
        self._lanes: Dict[str, _Lane] = {}

    def answer(self, item: Any, size: int) -> None:
        """Add an answer or a status of ``size`` [B]; raise Full."""
        if self._answers_size + size > MAX_ANSWERS and self._answers:
            raise Full
        self._answers.append((item, size))
        self._answers_size += size

    def configure(self, topic: str, period: float, length: int) -> None:
        """Send at most one message of a topic each ``period`` [s], let ``length`` wait; 0: see the top of this file."""
        lane = self._lanes.setdefault(topic, _Lane())
        lane.period, lane.length = period, length

    def forget(self, topic: str) -> None:
        self._lanes.pop(topic, None)

    def put(self, topic: str, item: Any, size: int, now: float, kept: bool = False) -> None:
        """Add a message of a topic; ``kept``: newer ones do not replace it, as for a latched topic."""
        lane = self._lanes.get(topic)
        if lane is not None:
            lane.put(_Waiting(now, item, size, kept))

    def take(self, now: float) -> Any:
        if self._answers:
            item, size = self._answers.popleft()
            self._answers_size -= size
            return item
        ready = [lane for lane in self._lanes.values() if lane.waiting and lane.due <= now]
        if not ready:
            return None
        for lane in ready:
            lane.forget_late(now)
        lane = min(ready, key=lambda lane: lane.rank(now))
        lane.due = now + lane.period
        return lane.drop().item

    def next_due(self) -> Optional[float]:
        """Return when the next data are due, None if nothing waits."""
        if self._answers:
            return -math.inf
        return min((lane.due for lane in self._lanes.values() if lane.waiting), default=None)
