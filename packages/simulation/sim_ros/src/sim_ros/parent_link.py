"""The private connection of a simulator to the program that has started it, which then owns the simulator's time.

It is a pair of sockets, made before the simulator was forked: no other program can open it, or send under its name. So
whatever a judgement of a program rests on, such as poses, the time, and whether nodes were late, goes through it, and
not over ROS, where every node may claim any name.

Each message is a line of JSON. The parent sends::

    {"step": N}            pause, make N steps, and answer {"made": true}
    {"resume": true}       let time continue
    {"watch": {NAME: K, ...}, "reacts": true}   send the poses of these vehicles in every K-th step; whether the parent
                           publishes in answer to them, so that such a step has to wait for it
    {"follow": true}       tell the time in every step from now on, not only after those that were requested
    {"every": N}           publish the time, and wait for the nodes, in every N-th step only
    {"drive": [V, W]}      a velocity command [m/s, rad/s]
    {"carry": [X, Y, THETA]}   the vehicle is carried there [m, m, rad]
    {"move": [NAME, X, Y, THETA]}   a panel is moved there, as soon as no vehicle is in the way

and the simulator ``{"ready": true}`` before its first step, ``{"poses": {NAME: [X, Y, THETA]}, "steps": N}`` when the
vehicles have moved in step N, ``{"moved": NAME, "steps": N}`` when a panel has been moved in it, and ``{"steps": N,
"late": N, "busy": NAMES}`` at the end of the step, see ClockStatus, or with ``made``.

Threading contract: one thread receives, another one waits for requested steps; any thread may send.
"""
from __future__ import annotations

import json
import queue
import socket
import threading
from typing import Any, Callable, Mapping, Sequence

from kinematic_core.timing.pacing import Pacer, StepRequest

LONGEST = 60.0  # [s] of one wait for requested steps, which is repeated


class ParentLink:
    """The simulator's end of the connection."""

    def __init__(self, connection: socket.socket, drive: Callable[[float, float], object] | None = None,
                 carry: Callable[[float, float, float], object] | None = None,
                 move: Callable[[str, float, float, float], object] | None = None) -> None:
        """``connection``: a socket.

        ``drive(linear, angular)`` takes commands, ``carry(x, y, theta)`` poses, and ``move(name, x, y, theta)`` those
        of a panel, if the simulator can do that.
        """
        self._connection, self._drive, self._carry, self._move = connection, drive, carry, move
        self._sending = threading.Lock()
        self._requests: queue.SimpleQueue[StepRequest] = queue.SimpleQueue()
        self._watched: dict[str, int] = {}
        self._reacts = self._follows = False  # whether the parent wants to know every step
        self._time: dict[str, Any] = {}  # of the last step
        self.every = 1  # steps between two times that the nodes get
        self.answers = False  # whether the parent publishes in answer to what was sent in this step

    def serve(self, pacer: Pacer) -> None:
        """Tell the parent that the simulator is ready, and do what it asks of a Pacer from now on."""
        self._pacer = pacer
        threading.Thread(target=self._receive, args=(pacer,), name='parent', daemon=True).start()
        threading.Thread(target=self._answer, name='requested steps', daemon=True).start()
        self._send(ready=True)

    def moved(self, steps: int, poses: Mapping[str, Sequence[float]]) -> None:
        """Send the poses that the parent watches: of those in ``poses``, {name: (x, y, theta)}, after ``steps``."""
        due = {name: list(poses[name]) for name, every in self._watched.items() if name in poses and not steps % every}
        if due:
            self._send(steps=steps, poses=due)
        self.answers = bool(due) and self._reacts

    def panel_moved(self, steps: int, name: str) -> None:
        """Send that a panel has been moved after ``steps``."""
        self._send(moved=name, steps=steps)

    def stepped(self, steps: int, late: int, busy: str) -> None:
        """Send that a step is over; ``late`` and ``busy`` as in ClockStatus, but no name if the nodes got no core."""
        self._time = {'steps': steps, 'late': late, 'busy': busy}
        if self._follows or not self._pacer.paused:  # each message wakes the parent
            self._send(**self._time)

    def _send(self, **message: Any) -> None:
        try:
            with self._sending:
                self._connection.sendall(json.dumps(message).encode() + b'\n')
        except OSError:
            pass  # the parent has ended; the simulator ends with it

    def _receive(self, pacer: Pacer) -> None:
        with self._connection.makefile('rb') as lines:
            for line in lines:
                message = json.loads(line)
                if 'step' in message:
                    self._requests.put(pacer.request(message['step']))
                elif 'resume' in message:
                    pacer.resume()
                elif 'watch' in message:
                    self._reacts, self._watched = message['reacts'], message['watch']
                elif 'follow' in message:
                    self._follows = message['follow']
                elif 'every' in message:
                    self.every = message['every']
                elif 'carry' in message and self._carry:
                    self._carry(*message['carry'])
                elif 'move' in message and self._move:
                    self._move(*message['move'])
                elif 'drive' in message and self._drive:
                    self._drive(*message['drive'])

    def _answer(self) -> None:
        while True:
            request = self._requests.get()
            while not request.wait(LONGEST):
                pass
            self._send(made=request.made, **self._time)
