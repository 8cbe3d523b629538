"""The grader's end of the private connection to its simulator, sim_ros.parent_link, which no program can open.

Time and the poses of vehicles come through it, and nothing that a program publishes is mixed with them.

Threads: one receives and calls the listeners; ``step`` is called in the main thread, ``drive``, ``carry``,
``move`` and ``watch`` in any.
"""
import json
import math
import threading
import time

import rospy

from kinematic_core.timing.pacing import BEGIN
from rospy_support import rospy_internals

LONGEST = 60.0  # [s] of one wait for steps, which is repeated


class SimulatorLink:
    """Steps a simulator, and receives what truly happens in it."""

    def __init__(self, connection, dt):
        """``connection``: a socket; ``dt`` [s]: a step. Call ``listen`` once no process is forked any more."""
        self._connection, self._dt = connection, dt
        self._sending = threading.Lock()
        self._changed = threading.Condition()
        self._made = 0  # calls of ``step`` that are answered
        self._closed = False
        self._listeners, self._watched, self._reacts = {}, {}, False  # by vehicle; every how many steps
        self._followers = 0  # that want to know the time in every step
        self._moves = {}  # {panel: what to call once it is moved}
        self.ready = False  # whether the first step may be made
        self.late, self.busy = 0, ''  # of ClockStatus: steps that did not wait for the nodes, and whose fault it was

    def listen(self):
        """Receive from now on; this sets the time of rospy in this process, see ``follow``."""
        threading.Thread(target=self._receive, name='simulator', daemon=True).start()

    def step(self, count, deadline=math.inf):
        """Pause, make steps, and wait until they are made, or until ``deadline`` [s, monotonic].

        Raise OSError if the simulator has ended.
        """
        with self._changed:
            answered = self._made + 1
            self._send(step=count)
            while self._made < answered and not self._closed and time.monotonic() < deadline:
                self._changed.wait(min(LONGEST, max(0.0, deadline - time.monotonic())))
            if self._closed:
                raise ConnectionError('the simulator has ended')

    def follow(self, wanted=True):
        """Know the time in every step from now on, not only after each ``step``; ``wanted`` False: no longer.

        As long as several callers want it, it is known. Raise OSError if the simulator has ended.
        """
        with self._changed:
            self._followers += 1 if wanted else -1
            self._send(follow=self._followers > 0)

    def resume(self):
        """Let time continue. Raise OSError if the simulator has ended."""
        self._send(resume=True)

    def drive(self, linear, angular):
        """Command velocities [m/s, rad/s] of turtle1. Raise OSError if the simulator has ended."""
        self._send(drive=[linear, angular])

    def tell_time(self, every):
        """Let the nodes know the time in every ``every``-th step only. Raise OSError if the simulator has ended."""
        self._send(every=every)

    def carry(self, x, y, theta):
        """Carry the robot to a pose [m, m, rad]. Raise OSError if the simulator has ended."""
        self._send(carry=[x, y, theta])

    def move(self, name, x, y, theta, done):
        """Move a panel [m, m, rad]; call ``done(seconds)`` with the simulated time once it is there."""
        with self._changed:
            self._moves[name] = done
        self._send(move=[name, x, y, theta])

    def watch(self, vehicle, listener, every=1, reacts=False):
        """Call ``listener(steps, (x, y, theta))`` in every ``every``-th step of a vehicle, in the receiving thread.

        ``reacts``: the listener publishes something that belongs to the same step.
        """
        with self._changed:
            self._listeners.setdefault(vehicle, []).append((every, listener))
            self._watched[vehicle] = math.gcd(every, self._watched.get(vehicle, 0))
            self._reacts = self._reacts or reacts
            self._send(watch=self._watched, reacts=self._reacts)

    def time_after(self, steps):
        """Return the simulated time after so many steps, as a rospy.Time."""
        return rospy.Time(*divmod(BEGIN + steps * round(self._dt * 1e9), 1_000_000_000))

    def _send(self, **message):
        with self._sending:
            self._connection.sendall(json.dumps(message).encode() + b'\n')

    def _receive(self):
        try:
            with self._connection.makefile('rb') as lines:
                for line in lines:
                    self._take(json.loads(line))
        finally:
            with self._changed:
                self._closed = True
                self._changed.notify_all()

    def _take(self, message):
        if 'poses' in message:
            for vehicle, pose in message['poses'].items():
                for every, listener in self._listeners[vehicle]:
                    if message['steps'] % every == 0:
                        listener(message['steps'], pose)
        elif 'moved' in message:
            self._moves[message['moved']](self.time_after(message['steps']).to_sec())
        elif 'steps' in message:
            self.late, self.busy = message['late'], message['busy']
            rospy_internals.set_time(self.time_after(message['steps']))
        with self._changed:
            self._made += 'made' in message
            self.ready = self.ready or 'ready' in message
            self._changed.notify_all()
