#!/usr/bin/env python3
"""How a simulator begins and ends: its first names and lines, parameters, displays. Each test starts its own."""
import re
import signal
import threading
import time
import xmlrpc.client

import rosgraph
import rospy

from rostest_support.common import (
    BACKGROUND,
    DEADLINE,
    MIDDLE,
    SIMULATOR,
    Process,
    SimulatorCase,
    nightly,
    own_simulator,
    registered_names,
    run,
    until,
)

FEW_FILES = 256  # open files; 1024 are usual, which a test would take long to reach
STARTS, STARTING = 6, 0.1  # times; [s] from the first registration to the last, and a little more
NO_DISPLAY = ':4242'  # a display that no server serves


class StartupTest(SimulatorCase):

    def setUp(self):
        """The simulator does not run yet."""

    def start(self, *arguments, **environment):
        """Start a simulator; return its Process when turtle1's services are there."""
        simulator = own_simulator(*arguments, **environment)
        self.addCleanup(simulator.stop)
        self.wait_for_turtle1()
        return simulator

    def background(self):
        """Return the simulator's background parameters."""
        return tuple(rospy.get_param(f'{self.simulator}/background_{channel}') for channel in 'rgb')

    def test_turtlesim_log_at_start(self):
        """The lines that turtlesim logs at start."""
        simulator = self.start()
        simulator.wait_for_output(r'(?m)^\[INFO\].*: Starting turtlesim with node name /turtlesim$')
        simulator.wait_for_output(r'(?m)^\[INFO\].*: Spawning turtle \[turtle1\] at '
                                  r'x=\[5\.544445\], y=\[5\.544445\], theta=\[0\.000000\]$')

    def watch(self):
        """Return a list that gets the names of the simulator's services and topics, in the order of their coming.

        A thread looks at the master all the time; what comes between two looks has no order.
        """
        found, master = [], xmlrpc.client.ServerProxy(rosgraph.get_master_uri())

        def look():
            known = set()
            while not done.is_set():
                state = master.getSystemState('/test')[2]
                names = {name for kind in state for name, nodes in kind if '/turtlesim' in nodes}
                found.append(names - known)
                known |= names
        done = threading.Event()
        thread = threading.Thread(target=look, daemon=True)
        thread.start()
        self.addCleanup(thread.join, DEADLINE)
        self.addCleanup(done.set)
        return found

    def place(self, found, name):
        """Return at which look a name was seen first."""
        return until(lambda: [number for number, names in enumerate(list(found)) if name in names], name)[0]

    def test_turtlesim_order_at_start(self):
        """clear, reset, spawn and kill come first, then turtle1's: topics, then services; so do the lines of the log.

        A client that waits for /spawn or /clear and calls at once is answered, and turtle1 is there then.
        """
        found = self.watch()
        simulator = own_simulator()
        self.addCleanup(simulator.stop)
        rospy.wait_for_service('/clear', DEADLINE)
        self.call('clear')
        self.assertEqual('turtle2', self.call('spawn', 1.0, 1.0, 0.0, '').name)
        names = ('/clear', '/reset', '/spawn', '/kill', '/turtle1/cmd_vel', '/turtle1/pose', '/turtle1/color_sensor',
                 '/turtle1/set_pen', '/turtle1/teleport_relative', '/turtle1/teleport_absolute')
        places = [self.place(found, name) for name in names]
        self.assertEqual(sorted(places), places, list(zip(places, names)))
        self.assertLess(places[3], self.place(found, '/turtle2/cmd_vel'))
        lines = re.findall(r'Starting|Spawning turtle \[\w+\]|Clearing', simulator.output())
        self.assertEqual(['Starting', 'Spawning turtle [turtle1]', 'Clearing', 'Spawning turtle [turtle2]'], lines)

    def test_turtlesim_order_of_log_and_answer(self):
        """After an answer, the line of the call is in the log, before the lines of its effects."""
        simulator = own_simulator()
        self.addCleanup(simulator.stop)
        self.wait_for_turtle1()
        for name, values, last in (
                ('spawn', (3.0, 4.5, 1.57, 'anna'),
                 r'Spawning turtle \[anna\] at x=\[3\.000000\], y=\[4\.500000\], theta=\[1\.570000\]'),
                ('clear', (), r'Clearing turtlesim\.'),
                ('reset', (), r'Resetting turtlesim\.(.|\n)*Spawning turtle \[turtle1\] at x=\[5\.544445\]')):
            self.call(name, *values)
            self.assertRegex(simulator.output(), last)
            self.refused('kill', 'nobody')
            lines = simulator.output().splitlines()
            self.assertIn('Tried to kill turtle [nobody]', lines[-1])
            self.assertRegex('\n'.join(lines[:-1]), last)

    @nightly
    def test_turtlesim_background_given(self):
        """Given ones are used and kept; those that are absent get their defaults."""
        self.set_parameter('background_r', 1)
        self.start('_background_g:=2')
        self.assertEqual((1, 2, BACKGROUND[2]), self.background())
        self.assertEqual((1, 2, BACKGROUND[2]), self.color())

    @nightly
    def test_turtlesim_bad_background_at_start(self):
        """Wrong types and ranges: an error that names parameter, value and range; the simulator takes its default."""
        for value in ('red', 300, -1, 1.5, True, [1, 2]):
            self.set_parameter('background_g', value)
            simulator = self.start()
            said = simulator.wait_for_output(r'\[ERROR\].*/turtlesim/background_g.*').group()
            self.assertIn(repr(value), said)
            self.assertIn('0 to 255', said)
            self.assertEqual(BACKGROUND, self.color())
            self.set_parameter('background_g', 7)
            self.call('clear')
            self.assertEqual(7, self.color()[1])
            simulator.stop()

    @nightly
    def test_turtlesim_bad_image_rate(self):
        """A wrong image_rate ends the start with a text that names parameter, value and range."""
        for value in ('fast', 0.0, 1000.0, True):
            with own_simulator(f'_image_rate:={value}') as simulator:
                until(lambda: not simulator.runs(), f'an end with {value!r}')  # noqa: B023
                said = simulator.wait_for_output(r'\[FATAL\].*/turtlesim/image_rate.*').group()
                self.assertIn(repr(value), said)
                self.assertIn('0.1 to 62.5', said)
                self.assertNotIn('Traceback', simulator.output())
                self.assertEqual(2, simulator.process.returncode)

    @nightly
    def test_turtlesim_many_turtles(self):
        """More turtles than the usual limit of open files allows at three a turtle: the simulator raises the limit."""
        limited = Process('bash', '-c', f'ulimit -Sn {FEW_FILES}; exec "$0"', SIMULATOR)
        self.addCleanup(limited.stop)
        self.wait_for_turtle1()
        for _ in range(FEW_FILES // 2):
            last = self.call('spawn', 2.0, 3.0, 1.0, '').name
        self.assert_pose(self.pose(last), 2.0, 3.0, 1.0)
        self.assertTrue(self.snapshot())
        self.assertNotIn('Too many open files', limited.output())

    def test_turtlesim_window_false(self):
        """With a display, but told to do without a window: no word of it, and no process beside the simulator's."""
        simulator = self.start('_window:=false', DISPLAY=NO_DISPLAY)
        self.poses().more(30)
        self.assertNotIn('isplay', simulator.output())
        self.assertEqual('', children(simulator.process.pid))

    @nightly
    def test_turtlesim_display_fails(self):
        """A display that cannot be used costs the window and a warning, not the simulator."""
        simulator = self.start(DISPLAY=NO_DISPLAY)
        simulator.wait_for_output(f'WARN.*{NO_DISPLAY}')
        self.poses().more(30)
        self.assertTrue(simulator.runs())
        self.assertNotIn('Traceback', simulator.output())
        self.assertTrue(self.snapshot())

    @nightly
    def test_turtlesim_ends_while_it_starts(self):
        """A signal while it registers, at moments spread over the start: it ends cleanly all the same."""
        for number in range(STARTS):
            simulator = own_simulator()
            self.addCleanup(simulator.stop)
            until(lambda: any(registered_names('/turtlesim')), 'a first name')
            time.sleep(STARTING * number / STARTS)
            simulator.process.send_signal((signal.SIGINT, signal.SIGTERM)[number % 2])
            self.assertEqual(0, simulator.process.wait(DEADLINE), simulator.output())
            self.assertNotIn('Traceback', simulator.output())
            self.assertFalse(any(registered_names('/turtlesim')), 'names that stay with the master')

    def test_turtlesim_same_name(self):
        """A second simulator of the same name takes over: the first ends, as ROS wants it."""
        first = self.start()
        drive = self.driver()
        poses = self.poses()
        drive(x=1.0)
        poses.next(lambda pose: pose.x > MIDDLE, 'a turtle that moves')
        second = self.start()
        until(lambda: not first.runs(), lambda: f'an end of the first simulator; it said: {first.output()}')
        until(lambda: self.pose().x == MIDDLE, 'turtle1 of the second simulator')
        drive(x=1.0)
        poses.next(lambda pose: pose.x > MIDDLE, 'a turtle that moves')
        self.assertTrue(second.runs())


def children(pid):
    """Return the ids of a process's children, separated by spaces."""
    with open(f'/proc/{pid}/task/{pid}/children') as file:
        return file.read().strip()


if __name__ == '__main__':
    run(StartupTest)
