"""A DrawnWorld that is shared between the thread that steps it and the threads of rospy's callbacks.

Threading contract: ``lock`` guards world and canvas and is held for microseconds; registering with the master and
drawing images happen without it.
"""
import rospy

from kinematic_core.worlds.turtle_world import BACKGROUND, START
from sim_ros.recording import RecordedWorld
from turtlesim.core.drawn_world import DrawnWorld
from turtlesim.core.recording import COLUMNS, TURTLE, event_name, fields


class SharedWorld(RecordedWorld):
    """A DrawnWorld, ``drawn``, with its lock; ``world`` is the TurtleWorld in it."""

    def __init__(self, background, start=START):
        self.drawn = DrawnWorld(background, start=start)
        self._first_background = background
        super().__init__(self.drawn.world, COLUMNS, fields, lambda refusal: rospy.logerr('%s', refusal))

    def step(self):
        """Do the same as DrawnWorld.step, under the lock."""
        with self.lock:
            readings = self.drawn.step()
            self.record_step(readings)
            return readings

    def record(self, path):
        """Start a recording as RecordedWorld.record does, before the first step; its first row contains the start."""
        recorder = super().record(path)
        if self.world.start != START:
            recorder.note('start', *self.world.start)
        if self._first_background != BACKGROUND:
            recorder.note('clear', *self._first_background)
        return recorder

    def note(self, event, *values, turtle=TURTLE, request=None):
        """Note an event of turtlesim.core.recording.EVENTS, as RecordedWorld.note does."""
        super().note(event_name(event, turtle), *values, request=request)

    def image(self):
        """Return a copy of the canvas's RGB bytes and (name, x, y_down, theta) of every turtle, at the same moment."""
        with self.lock:
            turtles = [(turtle.name, turtle.x, turtle.y_down, turtle.theta)
                       for _, turtle in sorted(self.world.turtles.items())]
            return self.drawn.canvas.tobytes(), turtles
