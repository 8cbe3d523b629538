"""Serve the simulator's drawing to a page: ``~drawing`` and ``~get_drawing``.

Threading contract: a separate thread publishes, and only while there is a subscriber; ``_lock`` guards the content
of the last message. numpy is loaded for the first message, so that a simulator without a page starts at once and stays
small.
"""
from __future__ import annotations

import threading
import time
from typing import Any, Sequence

import rospy

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from rospy_support import threads
from rospy_support.topics import Publisher, SubscriptionListener
from turtlesim.core.designs import FILES, design_of
from turtlesim.msg import Drawing
from turtlesim.shared_world import SharedWorld
from turtlesim.srv import GetDrawing, GetDrawingResponse

PERIOD = 1 / 60  # [s] between two messages, at least


class DrawingServer:
    """Publishes the changes of a SharedWorld."""

    def __init__(self, shared: SharedWorld) -> None:
        self._shared, self._lock = shared, threading.Lock()
        self._number = 0
        self._pixels: bytes | None = None
        self._turtles: list[Any] = []
        self._wanted, self._closed = threading.Event(), threading.Event()
        self._publisher = Publisher('~drawing', Drawing, SubscriptionListener(self._wanted.set), queue_size=10)
        rospy.Service('~get_drawing', GetDrawing, self._whole)
        self._thread = threads.keep_running('drawing', self._serve)

    def close(self) -> None:
        self._closed.set()
        self._wanted.set()
        self._thread.join(1.0)

    def _serve(self) -> None:
        while not self._closed.is_set():
            self._wanted.wait()
            self._wanted.clear()
            due = time.monotonic()
            while self._publisher.get_num_connections() and not self._closed.is_set():
                with self._lock:
                    message = self._changes()
                if message is not None:
                    self._publisher.publish(message)
                due = max(due + PERIOD, time.monotonic())
                self._closed.wait(due - time.monotonic())

    def _changes(self) -> Drawing | None:
        """Return the next message; None if nothing has changed."""
        from turtlesim.core.changes import runs
        pixels, turtles = self._shared.image()
        if pixels == self._pixels and turtles == self._turtles:
            return None
        before, self._pixels, self._turtles = self._pixels, pixels, turtles
        self._number += 1
        return _message(self._number, runs(pixels, before), turtles)

    def _whole(self, _: Any) -> GetDrawingResponse:
        from turtlesim.core.changes import runs
        with self._lock:
            if self._pixels is None or not self._publisher.get_num_connections():
                self._changes()
            number, pixels, turtles = self._number, self._pixels or b'', self._turtles
        return GetDrawingResponse(_message(number, runs(pixels), turtles))


def _message(number: int, changed: bytes, turtles: Sequence[Any]) -> Drawing:
    names, x, y_down, theta = zip(*turtles) if turtles else ((),) * 4
    return Drawing(number, changed, names, [FILES[design_of(name)] for name in names], x,
                   [ARENA_SIZE - each for each in y_down], theta)
