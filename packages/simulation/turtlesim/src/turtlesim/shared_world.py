"""A DrawnWorld that is shared between the thread that steps it and the threads of rospy's callbacks.

Threading contract: ``lock`` guards world and canvas and is held for microseconds; registering with the master and
drawing images happen without it.
"""
from __future__ import annotations

from typing import Any

import rospy

from kinematic_core.timing.recorder import Recorder
from kinematic_core.worlds.turtle_world import BACKGROUND, START, Colour
from sim_ros.recording import RecordedWorld
from turtlesim.core.drawn_world import DrawnWorld, Reading
from turtlesim.core.recording import COLUMNS, TURTLE, event_name, fields


class SharedWorld(RecordedWorld):
    """A DrawnWorld, ``drawn``, with its lock; ``world`` is the TurtleWorld in it."""

    def __init__(self, background: Colour, start: tuple[float, float, float] = START) -> None:
        self.drawn = DrawnWorld(background, start=start)
        self._first_background = background
        super().__init__(self.drawn.world, COLUMNS, fields, lambda refusal: rospy.logerr('%s', refusal))

    def step(self) -> list[Reading]:
        """Do the same as DrawnWorld.step, under the lock."""
        with self.lock:
            readings = self.drawn.step()
            self.record_step(readings)
            return readings

    def record(self, path: str) -> Recorder:
        """Start a recording as RecordedWorld.record does, before the first step; its first row contains the start."""
        recorder = super().record(path)
        if self.world.start != START:
            recorder.note('start', *self.world.start)
        if self._first_background != BACKGROUND:
            recorder.note('clear', *self._first_background)
        return recorder

    def note(self, event: str, *values: Any, turtle: str = TURTLE, request: Any = None) -> None:
        """Note an event of turtlesim.core.recording.EVENTS, as RecordedWorld.note does."""
        super().note(event_name(event, turtle), *values, request=request)

    def image(self) -> tuple[bytes, list[tuple[str, float, float, float]]]:
        """Return a copy of the canvas's RGB bytes and (name, x, y_down, theta) of every turtle, at the same moment."""
        with self.lock:
            turtles = [(turtle.name, turtle.x, turtle.y_down, turtle.theta)
                       for _, turtle in sorted(self.world.turtles.items())]
            return self.drawn.canvas.tobytes(), turtles
