"""Reads what truly happened in a simulator: from its recording, not from published messages.

Both simulators record every command and service call with the node that sent it (kinematic_core.timing.recorder); the
recording is read while it is being written.
"""
import csv
import io
import math
import threading

from course_grader.rules.observation import Command, Event, Sample
from kinematic_core.timing import recorder
from sim_ros.recording import PARENT  # its commands are the grader's stimuli

TURTLE = 'turtle1'
REMOVALS = 'kill', 'delete_model'
INTERNAL_EVENTS = 'start', 'timeout'  # events that no node caused


class RecordingReader:
    """Reads a growing recording into an Observed, times counted from the first tick on."""

    def __init__(self, path, dt, observed):
        """``dt`` [s]: a tick."""
        self._path, self.dt, self._observed = path, dt, observed
        self._file, self._rest, self._columns = None, '', None
        self._lock = threading.Lock()
        self.tick = 0  # the last one read

    @property
    def now(self):
        """Simulated time [s] since ``observed.start``, when the program had started."""
        return self.tick * self.dt - self._observed.start

    def read(self):
        """Read what has been written since the last call; return the time [s]. Any thread may call it."""
        with self._lock:
            self._read()
            return self.tick * self.dt

    def _read(self):
        if self._file is None:
            self._file = recorder.open_growing(self._path)
            if self._file is None:
                return
        self._rest += self._file.read()
        lines, _, self._rest = self._rest.rpartition('\n')
        for row in csv.reader(lines.splitlines()):
            if self._columns is None:
                self._columns = {name: index for index, name in enumerate(row)}
            else:
                self._take(row)

    def close(self):
        with self._lock:
            if self._file:
                self._file.close()
            self._file = io.StringIO()

    def _take(self, row):
        def field(name):
            return row[self._columns[name]]
        self.tick = int(field('tick'))
        t = self.tick * self.dt
        for event, caller in zip(field('event').split(';'), field('callers').split(';')):
            if event.strip():
                self._take_event(t, event.split(), caller)
        if field('x'):
            self._observed.track.append(Sample(t, *(float(field(name)) for name in ('x', 'y', 'theta'))))
        self._observed.seconds = self.now

    def _take_event(self, t, words, caller):
        turtle, _, name = words[0].rpartition('/')
        values = tuple(map(float, words[1:]))
        robots = self._observed.robots
        if name in INTERNAL_EVENTS or caller == PARENT or turtle not in ('', TURTLE) and not robots:
            return
        if name == 'cmd':
            if turtle in robots or not robots:  # else a robot that the program has added
                commands = robots[turtle].commands if robots else self._observed.commands
                commands.append(Command(t, *values, caller))
        elif name == 'teleport_absolute':
            self._observed.events.append(Event(t, 'teleport', values, caller))
        elif name == 'teleport_relative':
            self._observed.events.append(Event(t, name, self._after_jump(*values), caller))
        elif name == 'pen':
            self._observed.events.append(Event(t, 'pen', tuple(map(int, values)), caller))
        else:
            self._observed.events.append(Event(t, name, (turtle or TURTLE,) if name in REMOVALS else values, caller))

    def _after_jump(self, linear, angular):
        """Return approximately where a relative teleport leads, for the texts."""
        last = self._observed.track[-1] if self._observed.track else Sample(0.0, 0.0, 0.0, 0.0)
        theta = last.theta + angular
        return last.x + linear * math.cos(theta), last.y + linear * math.sin(theta), theta
