#!/usr/bin/env python3
"""turtle_teleop_key in a real terminal (pty) and behind a pipe: its messages, its end, the state of the terminal."""
import fcntl
import os
import pty
import signal
import subprocess
import termios
import threading
import unittest

import roslib.packages
import rospy
from geometry_msgs.msg import Twist

from rospy_support.own_master import start_master
from rostest_support.common import DEADLINE, Collected, Process, nightly, node_api, run, until

TELEOP = roslib.packages.find_node('turtlesim', 'turtle_teleop_key')[0]
UP, DOWN, RIGHT, LEFT = b'\x1b[A', b'\x1b[B', b'\x1b[C', b'\x1b[D'


class Terminal:
    """A terminal with turtle_teleop_key running in it. Use it in a with statement."""

    def __init__(self, *arguments, **environment):
        self._user, self._program = pty.openpty()
        self._printed = b''
        self.mode_before = self.mode()
        self.process = subprocess.Popen([TELEOP, *arguments], stdin=self._program, stdout=self._program,
                                        stderr=self._program, start_new_session=True, preexec_fn=_use_terminal,
                                        env=dict(os.environ, **environment))
        threading.Thread(target=self._read, daemon=True).start()

    def mode(self):
        """Return the terminal's settings."""
        return termios.tcgetattr(self._program)

    def printed(self):
        """Return the output so far."""
        return self._printed.decode(errors='replace')

    def wait_for(self, text):
        """Wait until a text was printed."""
        until(lambda: text in self.printed(), f'{text!r} in {self.printed()!r}')

    def press(self, keys):
        """Press keys, given as the bytes that they send."""
        os.write(self._user, keys)

    def wait_for_end(self):
        """Return the exit code."""
        return self.process.wait(DEADLINE)

    def _read(self):
        try:
            while True:
                self._printed += os.read(self._user, 4096)
        except OSError:
            pass  # closed

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        os.close(self._program)
        os.close(self._user)


def _use_terminal():
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


def twist(linear=0.0, angular=0.0):
    message = Twist()
    message.linear.x, message.angular.z = linear, angular
    return message


def sends_to_somebody(node):
    """Return whether a node itself takes its turtle1/cmd_vel for connected; the subscriber does so a little earlier."""
    _, _, connections = node_api(node).getBusInfo('/test')
    return [connection for connection in connections if connection[2] == 'o' and connection[4] == '/turtle1/cmd_vel']


def kill_node(name):
    """Do what rosnode kill does."""
    try:
        node_api(name).shutdown('/test', 'test')
    except OSError:
        pass  # the node may end before it has answered


class TeleopTest(unittest.TestCase):

    def setUp(self):
        self.received = Collected('turtle1/cmd_vel', Twist)

    def ready(self, terminal):
        """Wait until the program listens to keys and this test to it."""
        terminal.wait_for('the focus')
        until(lambda: sends_to_somebody('/teleop_turtle'), 'a connection with turtle_teleop_key')
        return terminal

    def piped(self, keys, *arguments):
        """Return the exit code of a teleop whose input is a pipe with these keys."""
        return subprocess.run([TELEOP, *arguments], input=keys, timeout=DEADLINE, check=False).returncode

    def assert_received(self, *twists):
        until(lambda: len(self.received.messages) >= len(twists), f'{len(twists)} Twists; {self.received.messages}')
        self.assertEqual(list(twists), self.received.messages)

    def test_teleop_sends_one_twist_a_key_press(self):
        """Each arrow key sends its Twist at once, other keys nothing; q ends it."""
        with Terminal() as terminal:
            self.ready(terminal)
            expected = []
            for key, command in ((UP, twist(2.0)), (DOWN, twist(-2.0)), (LEFT, twist(0.0, 2.0)),
                                 (RIGHT, twist(0.0, -2.0)), (UP, twist(2.0)), (UP, twist(2.0))):
                terminal.press(key)
                expected.append(command)
                self.assert_received(*expected)
            terminal.press(b'xABCD\x1b\r' + LEFT)  # keys that mean nothing, then one that does
            self.assert_received(*expected, twist(0.0, 2.0))
            terminal.press(b'q' + UP)
            self.assertEqual(0, terminal.wait_for_end())
            self.assert_received(*expected, twist(0.0, 2.0))

    def test_teleop_says_what_the_keys_do(self):
        """The help names keys, topic and speeds; keys are not echoed."""
        for name in ('scale_linear', 'scale_angular'):
            self.addCleanup(rospy.delete_param, f'/teleop_turtle/{name}')
        with Terminal('_scale_linear:=1.5', '_scale_angular:=0.5') as terminal:
            self.ready(terminal)
            for text in ('arrow keys', '/turtle1/cmd_vel', '1.5 m/s', '0.5 rad/s', 'q  ', 'Ctrl-C', 'terminal'):
                self.assertIn(text, terminal.printed())
            terminal.press(b'z' + UP)
            self.assert_received(twist(1.5))
            self.assertNotIn('z', terminal.printed().split('the focus')[1])  # keys are not shown

    def test_teleop_reads_a_pipe_to_its_end_and_loses_nothing(self):
        """Input from a pipe: all keys are sent, its end ends the node."""
        for _ in range(3):
            self.received.messages.clear()
            self.assertEqual(0, self.piped(UP + RIGHT + b'x' + DOWN))
            self.assert_received(twist(2.0), twist(0.0, -2.0), twist(-2.0))

    @nightly
    def test_teleop_scales(self):
        """scale_linear and scale_angular beside the node, private ones before them."""
        self.addCleanup(rospy.delete_param, '/scale_linear')
        self.addCleanup(rospy.delete_param, '/scale_angular')
        rospy.set_param('/scale_linear', 3)  # beside the node, where turtlesim reads it
        rospy.set_param('/scale_angular', 0.5)
        self.assertEqual(0, self.piped(UP + LEFT))
        self.assert_received(twist(3.0), twist(0.0, 0.5))
        self.assertEqual(0, self.piped(UP + LEFT, '_scale_linear:=-1.0', '__name:=other'))
        self.assert_received(twist(3.0), twist(0.0, 0.5), twist(-1.0), twist(0.0, 0.5))

    @nightly
    def test_teleop_puts_the_terminal_back_however_it_ends(self):
        """q, Ctrl-C, Ctrl-backslash, Ctrl-D, SIGTERM, SIGHUP, rosnode kill."""
        ends = {'q': lambda terminal: terminal.press(b'q'),
                'Ctrl-C': lambda terminal: terminal.press(b'\x03'),
                'Ctrl-\\': lambda terminal: terminal.press(b'\x1c'),
                'Ctrl-D': lambda terminal: terminal.press(b'\x04'),
                'SIGTERM': lambda terminal: terminal.process.send_signal(signal.SIGTERM),
                'SIGHUP': lambda terminal: terminal.process.send_signal(signal.SIGHUP),
                'rosnode kill': lambda _: kill_node('/teleop_turtle')}
        for name, end in ends.items():
            with Terminal() as terminal:
                self.ready(terminal)
                self.assertNotEqual(terminal.mode_before, terminal.mode())
                end(terminal)
                self.assertEqual(0, terminal.wait_for_end(), name)
                self.assertEqual(terminal.mode_before, terminal.mode(), name)
                self.assertNotIn('Traceback', terminal.printed(), name)

    @nightly
    def test_teleop_ends_well_when_the_master_is_gone(self):
        """Without a master: q still ends it and the terminal is put back."""
        uri, master = start_master(lambda command: Process(*command))
        with master:
            with Terminal(ROS_MASTER_URI=uri) as terminal:
                terminal.wait_for('the focus')
                master.stop()
                terminal.press(UP)
                terminal.wait_for('No subscriber on')
                terminal.press(b'q')
                self.assertEqual(0, terminal.wait_for_end())
                self.assertEqual(terminal.mode_before, terminal.mode())
                self.assertNotIn('Traceback', terminal.printed())


if __name__ == '__main__':
    run(TeleopTest)
