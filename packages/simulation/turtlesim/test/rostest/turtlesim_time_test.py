#!/usr/bin/env python3
"""Time that runs fast, stands still, goes step by step, and repeats. These tests start simulators themselves.

This node itself keeps wall time: it has started before a simulator set /use_sim_time.
"""
import csv
import math
import os
import re
import signal
import subprocess
import sys
import time

import rosgraph
import roslib.packages
import rospy
from geometry_msgs.msg import Twist, Vector3
from rosgraph_msgs.msg import Clock
from sim_ros.msg import ClockStatus
from sim_ros.srv import SetRate, Step
from std_srvs.srv import Trigger

from rospy_support.topics import LatestPublisher
from rostest_support.common import (
    DEADLINE,
    Collected,
    Process,
    SimulatorCase,
    median_rate,
    nightly,
    own_simulator,
    proxy,
    registered_names,
    restore_parameter,
    run,
    until,
)

TICK = 16_000_000  # [ns]
STEPS = 1250  # 20 s
CATCHING_UP = 1.25  # times the pace that late steps are made up for
RUNS = 4
DRIVE = roslib.packages.find_node('turtle_robotont', 'velocity_publisher.py')[0]
BURN = ('nice', '-n', '5', sys.executable, '-c', 'while True: pass')
THINKER = '''
import time, rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose
rospy.init_node('thinker')
publisher = rospy.Publisher('turtle1/cmd_vel', Twist, queue_size=1)
def think(pose):  # turns as it moves: each command depends on the very pose
    end = time.process_time() + {seconds}
    while time.process_time() < end:
        pass
    twist = Twist()
    twist.linear.x, twist.angular.z = 1.0, pose.x - pose.y
    publisher.publish(twist)
rospy.Subscriber('turtle1/pose', Pose, think, queue_size=1)
rospy.spin()
'''
POLLER = '''
import rospy
from turtlesim.msg import Pose
rospy.init_node('poller')
while not rospy.is_shutdown():
    rospy.wait_for_message('turtle1/pose', Pose)
'''


class TimeTest(SimulatorCase):
    simulator = None

    def start(self, *arguments):
        """Start a simulator; return its Process."""
        process = own_simulator('_window:=false', *arguments)
        self.addCleanup(process.stop)
        until(lambda: '/turtlesim/snapshot' in registered_names('/turtlesim')[2], 'the last of the services')
        return process

    def run_node(self, *command):
        """Start a program that ends with the test."""
        process = Process(*command)
        self.addCleanup(process.stop)
        return process

    def clock(self):
        """Return the Collected messages of /clock, of which there is one."""
        collected = Collected('/clock', Clock)
        until(lambda: collected.messages, 'a /clock')
        return collected

    def status(self, fits=lambda status: True):
        """Return the next ClockStatus that fits."""
        return Collected('/turtlesim/clock_status', ClockStatus).next(fits, 'a status', 3.0 * DEADLINE)

    def times(self, clock):
        return [message.clock.to_nsec() for message in list(clock.messages)]

    def test_turtlesim_rate(self):
        """At rate 10 ten seconds take one, and a node's timer follows; use_sim_time is set, and taken back later."""
        simulator = self.start('_rate:=10')
        self.assertTrue(rospy.get_param('/use_sim_time'))
        clock, node = self.clock(), self.run_node(DRIVE, '_rate:=1')
        node.wait_for_output('Publish turtle velocity')
        until(lambda: len(clock.times) > STEPS and clock.times[-1] - clock.times[-STEPS] < 10.0,
              'twenty simulated seconds that took two, or on a busy machine at least less than ten')
        passed = (self.times(clock)[-1] - self.times(clock)[0]) / 1e9
        self.assertLess(passed, 10.0 * CATCHING_UP * (time.monotonic() - clock.times[0]))

        def stamps():
            return [float(stamp) for stamp in re.findall(r', (\d+\.\d+)\]: Publish', node.output())]
        until(lambda: len(stamps()) > 10, 'more than ten commands of the node')
        self.assertAlmostEqual(1.0, median_rate(stamps(), span=3), delta=0.05)  # in simulated time
        times = self.times(clock)
        self.assertEqual([], [after - before for before, after in zip(times, times[1:]) if (after - before) % TICK])
        self.assertEqual(sorted(times), times)
        simulator.stop()
        self.assertFalse(rospy.has_param('/use_sim_time'))

    def test_turtlesim_pause(self):
        """A pause stops time and turtle, steps are made one by one, and both continue afterwards."""
        self.start('_clock:=true')
        clock, poses = self.clock(), self.poses()
        self.driver()(x=1.0)
        poses.next(lambda pose: pose.linear_velocity == 1.0)
        self.assertTrue(proxy('/turtlesim/pause', Trigger)().success)
        self.status(lambda status: status.paused)
        pose, steps = poses.messages[-1], proxy('/turtlesim/step', Step)(0).steps
        clock.more(3)  # still published, for late subscribers
        self.assertEqual(1, len(set(self.times(clock)[-3:])))
        answer = proxy('/turtlesim/step', Step)(10)
        self.assertEqual(steps + 10, answer.steps)
        self.assertAlmostEqual(1.0 + 0.016 * answer.steps, answer.time)
        until(lambda: math.isclose(poses.messages[-1].x, pose.x + 0.16, abs_tol=1e-5), '10 steps of 16 mm')
        self.assertTrue(proxy('/turtlesim/resume', Trigger)().success)
        poses.next(lambda later: later.x > pose.x + 0.3)
        self.assertEqual('', proxy('/turtlesim/set_rate', SetRate)(5.0).warning)
        self.assertEqual(5.0, self.status(lambda status: status.rate != 1.0).rate)
        for rate in (0.0, -1.0, math.nan, math.inf, 1001.0):
            with self.assertRaisesRegex(rospy.ServiceException, 'it must be 0.01 to 1000'):
                proxy('/turtlesim/set_rate', SetRate)(rate)

    @nightly
    def test_turtlesim_repeats(self):
        """The same seed, the same commands at the same ticks: recordings are the same bytes, on a busy machine."""
        for _ in range(2):
            burner = subprocess.Popen(BURN)
            self.addCleanup(burner.wait)
            self.addCleanup(burner.send_signal, signal.SIGKILL)
        recordings = {self.record(run) for run in range(RUNS)}
        self.assertEqual(1, len(recordings), 'recordings differ')
        (recording,) = recordings
        self.assertEqual(91, recording.count(b'\n'))
        self.assertIn(b'start ', recording)

    def record(self, number):
        """Return the bytes of a recording of a fixed run."""
        path = os.path.join(self.temporary_directory(), f'{number}.csv')
        # in lockstep a step waits for commands that have been sent, but not yet taken
        simulator = self.start('_paused:=true', '_clock:=true', '_lockstep:=true', '_seed:=7', f'_record:={path}')
        velocity, step = LatestPublisher('turtle1/cmd_vel', Twist), proxy('/turtlesim/step', Step)
        until(velocity.wanted, 'a connection with the simulator')
        self.call('turtle1/set_pen', 255, 0, 0, 5, 0)
        for speed in (1.0, 2.0, -1.0):
            velocity.publish(Vector3(speed, 0.1, 0.0), Vector3(0.0, 0.0, speed))
            step(30)
        velocity.unregister()
        simulator.stop()
        with open(path, 'rb') as file:
            return file.read()

    def think(self, seconds):
        """Let a node steer that takes so long [s] for each pose; return a status and the rows from its command on."""
        path = os.path.join(self.temporary_directory(), 'run.csv')
        # paused, as time at the rate max would be over before the node has started on a loaded machine
        simulator = self.start('_rate:=max', '_paused:=true', '_lockstep_wait:=60', f'_record:={path}')
        thinker = self.run_node(sys.executable, '-c', THINKER.format(seconds=seconds))
        master = rosgraph.Master(rospy.get_name())
        until(lambda: ['/turtle1/pose', ['/thinker']] in master.getSystemState()[1], 'the node subscribes')
        self.assertTrue(proxy('/turtlesim/resume', Trigger)().success)
        status = self.status(lambda status: status.time > 3.0)
        proxy('/turtlesim/pause', Trigger)()
        simulator.stop()
        thinker.stop()  # it would steer in the next simulator, until it is replaced there
        with open(path, newline='', encoding='utf-8') as file:
            rows = [list(row.values())[1:-1] for row in csv.DictReader(file)]
        return status, rows[next((number for number, row in enumerate(rows) if row[0]), 0):]

    @nightly
    def test_turtlesim_lockstep(self):
        """In lockstep a slow node drives as a fast one does, to the bit."""
        (_, fast), (status, slow) = self.think(0.0), self.think(0.005)
        common = min(len(fast), len(slow))
        self.assertEqual(0, status.late_steps)
        self.assertGreater(common, 50)
        self.assertEqual(fast[:common], slow[:common])

    @nightly
    def test_turtlesim_lockstep_poller(self):
        """A node that polls in wall time, as rospy.wait_for_message does, is waited for no longer than any other."""
        simulator = self.start('_rate:=max', '_lockstep_wait:=60')
        self.run_node(sys.executable, '-c', POLLER)
        begin = self.status(lambda status: status.steps > 1)
        status = self.status(lambda status: status.time > begin.time + 0.15)
        self.assertEqual((0, True), (status.late_steps, status.lockstep))
        self.assertNotIn('Lockstep', simulator.output())

    @nightly
    def test_turtlesim_node_behind(self):
        """Without lockstep a node that gets no processor time is named and counted."""
        simulator = self.start('_rate:=10')
        commands = Collected('turtle1/cmd_vel', Twist)
        self.addCleanup(commands.subscriber.unregister)
        node = self.run_node(DRIVE)
        commands.more(3)  # between them it sleeps by /clock, and so follows it
        node.process.send_signal(signal.SIGSTOP)
        status = self.status(lambda status: '/velocity_publisher' in status.busy)
        node.process.send_signal(signal.SIGCONT)
        self.assertGreater(status.late_steps, 0)
        self.assertFalse(status.lockstep)
        simulator.wait_for_output(r'/velocity_publisher\S* is falling behind: '
                                  r'\d+\.\d s of simulated time behind /clock')

    @nightly
    def test_turtlesim_use_sim_time_false(self):
        """Where nodes shall keep wall time, a simulator that publishes /clock says once what to type."""
        rospy.set_param('/use_sim_time', False)
        simulator = self.start('_rate:=2')
        simulator.wait_for_output('rosparam set /use_sim_time true')
        simulator.stop()
        self.assertIs(False, rospy.get_param('/use_sim_time'))

    @nightly
    def test_turtlesim_use_sim_time_without_clock(self):
        """If nodes wait for a /clock that no node publishes, the simulator says so, and continues itself."""
        rospy.set_param('/use_sim_time', True)
        simulator = self.start()
        simulator.wait_for_output('no node publishes /clock')
        self.poses().more(30)

    @nightly
    def test_turtlesim_bad_time(self):
        """Parameters that cannot be are refused."""
        for argument, text in (('_rate:=0', 'max'), ('_rate:=fast', 'from 0.01 to 1000'), ('_seed:=-1', 'seed'),
                               ('_start:=[1, 2]', '3 numbers'), ('_start:=[1, 12, 0]', '11.0889'),
                               ('_record:=/no/such/folder/a.csv', 'No such file'), ('_lockstep:=true', 'clock')):
            with own_simulator(argument) as simulator:
                simulator.wait_for_output(text)
                self.assertEqual(2, simulator.process.wait(DEADLINE), argument)
            restore_parameter('/turtlesim', None)


if __name__ == '__main__':
    run(TimeTest)
