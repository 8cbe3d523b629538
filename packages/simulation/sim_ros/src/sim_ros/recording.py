"""A simulated world that several threads share, with the recording that ``~record`` asks for.

Threading contract: ``lock`` guards the world and its recording; a thread that holds it never waits for the master or
for images.
"""
from __future__ import annotations

import contextlib
import os
import re
import threading
from typing import Any, Callable, Iterable, Iterator, Sequence

import rospy

from kinematic_core.timing.recorder import ACTIVE, Recorder
from plain_support import InvalidInput
from rospy_support import parameters
from rospy_support.rospy_internals import caller

RECORD = parameters.Text('~record', '')
PARENT = '='  # stands for the process that started the simulator; it is not a valid name of a node
NOT_OF_A_NAME = re.compile(r'[^\w/~.]')


class RecordedWorld:
    """A world, its lock, and the recording of its steps, if there is one."""

    def __init__(self, world: Any, columns: Sequence[str], fields: Callable[[Any], Iterable[object]],
                 log_refusal: Callable[[InvalidInput], object]) -> None:
        """``world`` counts its ``steps``.

        ``columns`` are the columns of the recording; ``fields(result)`` returns their values after a step with that
        result. ``log_refusal(error)`` logs an InvalidInput that makes a service call fail.
        """
        self.world = world
        self.lock = threading.Lock()
        self._columns, self._fields = columns, fields
        self._log_refusal = log_refusal
        self._recorder: Recorder | None = None

    @contextlib.contextmanager
    def change(self) -> Iterator[Any]:
        """Hold the lock and yield the world; turn an InvalidInput into the failure of a service call.

        Call ``note`` after a change.
        """
        try:
            with self.lock:
                yield self.world
        except InvalidInput as refusal:
            self._log_refusal(refusal)
            raise rospy.ServiceException(str(refusal)) from None

    def record_if_asked(self) -> None:
        """Record into the file ``~record``, unless that is empty. Raise ParameterError if that is not possible.

        Parameters outlive nodes: one that an earlier run has set must neither overwrite that run's recording nor
        prevent this node from starting.
        """
        path = RECORD.read()
        if not path:
            return
        name = rospy.resolve_name(RECORD.name)
        try:
            recorder = self.record(path)
        except OSError as error:
            raise parameters.ParameterError(
                f'parameter {name} is {path!r}: {error}; it must be a writable file, or empty. To forget '
                f'it, type: rosparam delete {name}') from None
        if recorder.path != os.path.abspath(path):
            rospy.logwarn('%s is %r, which already exists and is not overwritten: this run is recorded in %s. '
                          'If you want no recording, type: rosparam delete %s', name, path, recorder.path, name)
        rospy.loginfo('Recording %s; its name is %s until this node ends.', recorder.path, recorder.path + ACTIVE)

    def record(self, path: str) -> Recorder:
        """Record from the next step on; return the Recorder. Raise OSError if the file cannot be written."""
        self._recorder = Recorder(path, self._columns)
        return self._recorder

    def note(self, event: str, *values: Any, request: Any = None) -> None:
        """Record an event that takes effect now or in the next step. The caller must hold the lock.

        ``request`` is the message or service request that asked for it, or PARENT. The name that a caller states
        may be any text.
        """
        if self._recorder is not None:
            name = PARENT if request is PARENT else NOT_OF_A_NAME.sub('?', caller(request))
            self._recorder.note(event, *values, caller=name)

    def record_step(self, result: Any) -> None:
        """Record the step just made. The caller must hold the lock. A full disk ends only the recording."""
        if self._recorder is None:
            return
        try:
            self._recorder.tick(self.world.steps - 1, self._fields(result))
        except OSError as error:
            rospy.logerr('The recording stops here, after %d ticks: %s', self.world.steps - 1, error)
            self._recorder = None

    def end_recording(self) -> None:
        """Close the recording, if there is one."""
        with self.lock:
            if self._recorder is not None:
                self._recorder.close()
                self._recorder = None
