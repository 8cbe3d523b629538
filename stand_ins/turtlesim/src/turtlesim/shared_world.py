"""A DrawnWorld shared between the thread that steps it and those in which rospy runs callbacks.

Threading contract: ``lock`` guards world and canvas and is held for microseconds; whoever registers with the
master or draws pictures does so without it.
"""
import contextlib
import threading

import rospy

from kinematic_core.validation import InvalidInput
from kinematic_core.worlds.turtle_world import BACKGROUND, START
from rospy_support.rospy_internals import caller
from turtlesim.core.drawn_world import DrawnWorld
from turtlesim.core.recording import TURTLE, Recorder


class SharedWorld(DrawnWorld):
    """A DrawnWorld with its lock."""

    def __init__(self, background, start=START):
        super().__init__(background, start=start)
        self.lock = threading.Lock()
        self._recorder = None

    @contextlib.contextmanager
    def change(self):
        """Hold the lock and hand out the TurtleWorld; what it refuses becomes the failure of a service call.

        Who changes something calls ``note``, too.
        """
        try:
            with self.lock:
                yield self.world
        except InvalidInput as refusal:
            rospy.logerr('%s', refusal)
            raise rospy.ServiceException(str(refusal)) from None

    def step(self):
        """As DrawnWorld.step, under the lock."""
        with self.lock:
            readings = super().step()
            if self._recorder is not None:
                self._record(readings)
            return readings

    def record(self, path, background):
        """Return the Recorder of a file, from the first step on; raise OSError when that cannot be.

        ``background``: as it began.
        """
        recorder = Recorder(path)
        if self.world.start != START:
            recorder.note('start', *self.world.start)
        if background != BACKGROUND:
            recorder.note('clear', *background)
        self._recorder = recorder
        return recorder

    def end_recording(self):
        """Close the recording, if there is one."""
        with self.lock:
            if self._recorder is not None:
                self._recorder.close()
                self._recorder = None

    def note(self, event, *values, turtle=TURTLE, request=None):
        """Record an event, of recording.EVENTS, that takes effect now or in the next step; the lock is held.

        ``request`` is the message or service request that asked for it.
        """
        if self._recorder is not None:
            self._recorder.note(event, *values, turtle=turtle, caller=caller(request))

    def _record(self, readings):
        try:
            self._recorder.tick(self.world.steps - 1, readings)
        except OSError as error:
            rospy.logerr('The recording ends here, after %d ticks: %s', self.world.steps - 1, error)
            self._recorder = None

    def picture(self):
        """Return a copy of the canvas's RGB bytes and (name, x, y_down, theta) of every turtle, of one moment."""
        with self.lock:
            turtles = [(turtle.name, turtle.x, turtle.y_down, turtle.theta)
                       for _, turtle in sorted(self.world.turtles.items())]
            return self.canvas.tobytes(), turtles
