"""teleop_twist_keyboard: reads keys and publishes velocities on cmd_vel.

Threading contract: keys are read and velocities published in the main thread. The shutdown, in
another thread, sends the last velocity; a lock orders both.
"""
import math
import os
import select
import sys
import threading
import time

import rospy
from geometry_msgs.msg import Twist, TwistStamped

from plain_support import ABSURD
from rospy_support import nodes
from rospy_support.key_terminal import KeyTerminal
from rospy_support.parameters import Boolean, Number, Table, Text
from rospy_support.topics import LatestPublisher
from twist_keyboard.core.steering import HELP, QUIT, STILL, Steering, keys_in

PARAMETERS = Table(Number('~speed', 0.5, 0.0, ABSURD, 'm/s'), Number('~turn', 1.0, 0.0, ABSURD, 'rad/s'),
                   Number('~speed_limit', 1000.0, 0.0, ABSURD, 'm/s'),
                   Number('~turn_limit', 1000.0, 0.0, ABSURD, 'rad/s'),
                   Number('~repeat_rate', 0.0, 0.0, 1000.0, 'Hz'), Number('~key_timeout', 0.5, 0.0, 3600.0, 's'),
                   Boolean('~stamped', False), Text('~frame_id', ''))
REMINDER = 2.5  # [s] while there is no subscriber
POLL = 0.1  # [s]


class TwistKeyboard:
    """Publishes the velocity that the keys have chosen. rospy must be initialised."""

    def __init__(self):
        """Read the parameters and register the topic."""
        speed, turn, speed_limit, turn_limit, rate, timeout, self._stamped, self._frame = PARAMETERS.read()
        self._steering = Steering(speed, turn, speed_limit, turn_limit)
        self._period = 1.0 / rate if rate else math.inf
        self._timeout = timeout or math.inf  # [s] without a key before the robot stops
        self._publisher = LatestPublisher('cmd_vel', TwistStamped if self._stamped else Twist)
        self._wake, wake_writer = os.pipe()
        self._lock, self._ended = threading.RLock(), False
        rospy.on_shutdown(self._stop)
        rospy.on_shutdown(lambda: os.write(wake_writer, b'.'))

    def run(self, descriptor):
        """Read keys from a file descriptor and publish, until its end, Ctrl-C, or the shutdown."""
        if not self._wait_for_subscriber():
            return
        with KeyTerminal(descriptor):
            self._publish()
            print(HELP, self._steering.speeds, sep='\n', flush=True)
            while self._wait_and_act(descriptor):
                pass
        self._stop()

    def _wait_for_subscriber(self):
        """Return whether there is one; it waits for that until the shutdown."""
        reminded = time.monotonic()
        while not self._publisher.wanted():
            if select.select([self._wake], [], [], POLL)[0]:
                return False
            if time.monotonic() > reminded + REMINDER:
                reminded = time.monotonic()
                print(f'Waiting for subscriber to connect to {self._publisher.resolved_name}', flush=True)
        return True

    def _wait_and_act(self, descriptor):
        """Wait for keys or for the time to publish again; return whether to continue."""
        silent_from = time.monotonic() + self._timeout
        while True:
            wait = min(silent_from - time.monotonic(), self._period)
            ready, _, _ = select.select([descriptor, self._wake], [], [], None if wait == math.inf else max(0.0, wait))
            if ready or time.monotonic() >= silent_from:
                break
            self._publish()
        if self._wake in ready:
            return False
        return self._press(descriptor) if ready else self._silence()

    def _press(self, descriptor):
        """Read keys and act on them; return whether to continue."""
        try:
            data = os.read(descriptor, 1024)
        except OSError:  # the terminal was closed
            return False
        for key in keys_in(data.decode(errors='replace')):
            if key == QUIT:
                return False
            for line in self._steering.press(key):
                print(line, flush=True)
            self._publish()
        return bool(data)

    def _silence(self):
        """Stop the robot, because no key was pressed for too long; return True, to continue."""
        if self._steering.direction != STILL or self._period < math.inf:
            self._steering.direction = STILL
            self._publish()
        return True

    def _stop(self):
        """Send a last velocity of zero."""
        with self._lock:
            self._steering.direction = STILL
            self._publish()
            self._ended = True

    def _publish(self):
        message = TwistStamped() if self._stamped else Twist()
        if self._stamped:
            message.header.stamp, message.header.frame_id = rospy.Time.now(), self._frame
        twist = message.twist if self._stamped else message
        velocity = self._steering.velocity
        twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z = velocity
        with self._lock:
            if not self._ended:
                self._publisher.publish(message)


def main():
    """Run teleop_twist_keyboard on the standard input."""
    nodes.init_node('teleop_twist_keyboard', PARAMETERS)
    TwistKeyboard().run(sys.stdin.fileno())
