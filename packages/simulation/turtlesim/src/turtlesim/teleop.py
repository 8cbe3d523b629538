"""turtle_teleop_key: drive turtle1 with the arrow keys of a terminal, one Twist per key press.

Threading contract: keys are read and Twists published in the main thread; other threads only wake it.
"""
from __future__ import annotations

import os
import re
import select
import sys
import threading
import time
from typing import Iterator

import rosgraph
import rospy
from geometry_msgs.msg import Twist

from plain_support import ABSURD
from rospy_support import nodes
from rospy_support.key_terminal import KeyTerminal
from rospy_support.parameters import Number, Table
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher, SubscriptionListener

TOPIC = 'turtle1/cmd_vel'
LISTENERS_DEADLINE = 3.0  # [s] for all subscribers that the master knows to connect, after the first one has
WARNING_PERIOD = 5.0  # [s]
QUIT = 'quit'
DIRECTIONS = {'up': (1, 0), 'down': (-1, 0), 'left': (0, 1), 'right': (0, -1)}  # key: (forward, counter-clockwise)
SCALES = [Number(f'{prefix}scale_{kind}', 2.0, -ABSURD, ABSURD, unit)  # turtlesim's
          for kind, unit in (('linear', 'm/s'), ('angular', 'rad/s')) for prefix in ('~', '')]
PARAMETERS = Table(*SCALES)

HELP = """\
The arrow keys drive a turtle, on {topic}:
  up, down      forward, backward at {linear:g} m/s
  left, right   turn left, right at {angular:g} rad/s
  q             end (Ctrl-C too)
A press lasts one second; hold a key to continue. The window with the focus gets the keys:
click on this terminal, not on the turtle's window."""

_ARROWS = {b'A': 'up', b'B': 'down', b'C': 'right', b'D': 'left'}
_PLAIN = {ord('q'): QUIT, ord('Q'): QUIT, 0x03: QUIT, 0x04: QUIT}  # the last two: Ctrl-C and Ctrl-D as bytes
_SEQUENCE = re.compile(rb'\x1b(?:\[(?P<parameters>[0-?]{0,30})[ -/]{0,2}|O)(?P<final>[@-~])')
_BEGUN = re.compile(rb'\x1b(?:\[[0-?]{0,30}[ -/]{0,2}|O)?\Z')
_PRESS = re.compile(rb'(?:1(?:;\d+(?::[12])?)?)?\Z')  # no parameters, or 1;MODIFIER, not the release of a key (:3)


class KeyDecoder:
    """Converts the bytes that a terminal sends into keys; sequences may be split over several reads.

    A key is 'up', 'down', 'left', 'right' (with or without Shift, Alt, Ctrl) or QUIT; all others are ignored.
    """

    def __init__(self) -> None:
        self._rest = b''

    def feed(self, data: bytes) -> list[str]:
        """Return the list of the keys that ``data`` completes, in order."""
        data, position = self._rest + data, 0
        keys: list[str | None] = []
        while position < len(data) and not _BEGUN.match(data, position):
            sequence = _SEQUENCE.match(data, position)
            if sequence:
                keys.append(_arrow(sequence))
                position = sequence.end()
            else:
                keys.append(_PLAIN.get(data[position]))
                position += 1
        self._rest = data[position:]
        return [key for key in keys if key is not None]


def _arrow(sequence: re.Match[bytes]) -> str | None:
    return _ARROWS.get(sequence['final']) if _PRESS.match(sequence['parameters'] or b'') else None


def keys_from(descriptor: int, wake: int) -> Iterator[str]:
    """Yield the keys from a file descriptor, until QUIT, its end, or until ``wake`` has something to read."""
    decoder = KeyDecoder()
    while True:
        ready, _, _ = select.select([descriptor, wake], [], [])
        if wake in ready:
            return
        try:
            data = os.read(descriptor, 1024)
        except OSError:  # the terminal was closed
            return
        if not data:
            return
        for key in decoder.feed(data):
            if key == QUIT:
                return
            yield key


class TeleopNode:
    """Publishes the velocities of the keys on turtle1/cmd_vel. rospy must be initialised."""

    def __init__(self) -> None:
        self._linear = _scale('scale_linear')
        self._angular = _scale('scale_angular')
        self._listened, self._pressed = threading.Event(), False
        self._throttle = WallThrottle(WARNING_PERIOD)
        self._publisher = LatestPublisher(TOPIC, Twist, SubscriptionListener(self._listened.set))
        self._wake, wake_writer = os.pipe()
        rospy.on_shutdown(lambda: os.write(wake_writer, b'.'))
        rospy.on_shutdown(self._listened.set)

    def run(self, descriptor: int) -> None:
        """Read keys from a file descriptor and publish, until its end, a key that quits, or the shutdown."""
        with KeyTerminal(descriptor) as terminal:
            print(HELP.format(topic=self._publisher.resolved_name, linear=self._linear, angular=self._angular),
                  flush=True)
            if not terminal.is_terminal:
                self._wait_for_listeners()
            for key in keys_from(descriptor, self._wake):
                self._press(key)

    def _press(self, key: str) -> None:
        forward, turn = DIRECTIONS[key]
        twist = Twist()
        twist.linear.x = self._linear * forward
        twist.angular.z = self._angular * turn
        if not self._pressed:
            self._pressed = True
            self._wait_for_connections(1 if self._listeners() else 0)
        if not self._publisher.wanted():
            self._throttle.warn('no subscriber', 'No subscriber on %s. Is the simulator running? '
                                'rosrun turtlesim turtlesim_node', self._publisher.resolved_name)
        self._publisher.publish(twist)

    def _wait_for_listeners(self) -> None:
        """Wait for subscribers: keys from a file or program come at once, before any node could have connected."""
        listeners = self._listeners()
        if not listeners:
            rospy.loginfo('Waiting for a subscriber on %s', self._publisher.resolved_name)
        self._listened.wait()
        self._wait_for_connections(len(listeners))

    def _listeners(self) -> list[str]:
        """Return the names of the subscribing nodes; on a loaded machine they connect later."""
        try:
            subscribers = rosgraph.Master(rospy.get_name()).getSystemState()[1]
        except (OSError, rosgraph.MasterException):
            return []
        return dict(subscribers).get(self._publisher.resolved_name, [])

    def _wait_for_connections(self, number: int) -> None:
        deadline = time.monotonic() + LISTENERS_DEADLINE
        while self._publisher.get_num_connections() < number and time.monotonic() < deadline:
            self._listened.clear()
            if self._publisher.get_num_connections() < number:
                self._listened.wait(deadline - time.monotonic())


def _scale(name: str) -> float:
    """Return the private parameter, else the one in the node's namespace, which turtlesim uses."""
    private = PARAMETERS['~' + name]
    return private.read(None if rospy.has_param(private.name) else PARAMETERS[name].read())


def main() -> None:
    nodes.init_node('teleop_turtle', PARAMETERS)
    TeleopNode().run(sys.stdin.fileno())
