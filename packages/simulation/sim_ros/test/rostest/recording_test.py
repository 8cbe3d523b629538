#!/usr/bin/env python3
"""Recordings of both simulators: old files stay, truncated ones can be read, a full disk ends only the recording.

The worlds alone, without ROS, make the same ones.
"""
import csv
import os
import signal

import roslib.packages
import rospy
from sim_ros.srv import Step

from kinematic_core.timing.recorder import ACTIVE
from kinematic_core.worlds.robot_world import RobotWorld
from rostest_support.common import DEADLINE, Process, SimulatorCase, nightly, run, until
from sim_scene.worlds import load_world
from turtlesim.core import replay

LARGEST = 40  # [KB] of a file on the full disk: the log fits, the recording does not


class RecordingTest(SimulatorCase):
    simulator = None

    def start(self, package, node, *arguments, before=()):
        """Start a paused simulator; return its Process."""
        process = Process(*before, roslib.packages.find_node(package, node)[0], '_paused:=true', *arguments)
        self.addCleanup(process.stop)
        process.wait_for_output('Recording ')
        rospy.wait_for_service(f'/{package}/step', DEADLINE)
        return process

    def test_turtlesim_recordings(self):
        """Recordings are kept, whole, and end alone on a full disk."""
        self.folder = self.temporary_directory()
        path = os.path.join(self.folder, 'a.csv')
        step = rospy.ServiceProxy('/turtlesim/step', Step)
        simulator = self.start('turtlesim', 'turtlesim_node', f'_record:={path}')
        step(5)
        simulator.stop()
        first = self.rows('a.csv')
        self.assertEqual(6, len(first))
        rospy.set_param('/turtlesim/record', path)  # as a killed run or a launch file leaves it
        simulator = self.start('turtlesim', 'turtlesim_node')
        simulator.wait_for_output(rf'{path}., which already exists and is not overwritten: .*a_2\.csv\. .*'
                                  r'rosparam delete /turtlesim/record')
        step(3)
        simulator.process.send_signal(signal.SIGKILL)
        simulator.stop()
        self.assertEqual(['a.csv', 'a_2.csv.active'], sorted(os.listdir(self.folder)))
        self.assertEqual(first, self.rows('a.csv'))
        self.assertEqual(4, len(self.rows('a_2.csv.active')))
        simulator = self.start('turtlesim', 'turtlesim_node',
                               before=('bash', '-c', f'ulimit -f {LARGEST}; exec "$@"', 'bash'))
        step(8000)
        simulator.wait_for_output(r'The recording stops here, after \d+ ticks: .*File too large.*a_3\.csv')
        self.assertLess(1, step(1).steps - len(self.rows('a_3.csv')))
        self.assertTrue(simulator.runs())
        self.assertNotIn('Traceback', simulator.output())

    def rows(self, name):
        """Return the lines of a recording, all of them whole."""
        with open(os.path.join(self.folder, name), encoding='utf-8') as file:
            text = file.read()
        self.assertEqual('\n', text[-1:])
        lines = text.splitlines()
        self.assertEqual({lines[0].count(',')}, {line.count(',') for line in lines})
        return lines

    def recorded(self, package, node, cmd_vel, commands, *arguments):
        """Return the rows (dicts) of a run in which each of ``commands`` took effect, some steps after the other."""
        self.folder = self.temporary_directory()
        path = os.path.join(self.folder, 'run.csv')
        simulator = self.start(package, node, f'_record:={path}', *arguments)
        step, drive = rospy.ServiceProxy(f'/{package}/step', Step), self.driver(cmd_vel)

        def rows():
            with open(path + ACTIVE, encoding='utf-8', newline='') as file:
                return list(csv.DictReader(file))

        def took_effect(number):
            step(1)
            return sum('cmd ' in row['event'] for row in rows()) == number
        for number, command in enumerate(commands, 1):
            drive(*command)
            until(lambda number=number: took_effect(number), f'command {number} in the recording')
            step(7 + number)
        found = rows()
        simulator.stop()
        return found

    def test_turtle_world_makes_the_recording(self):
        """Also at the wall."""
        commands = [(0.1 * number, 0.0, 2.0 - 0.3 * number) for number in range(14)] + [(2.0, 0.0, 0.25)] * 40
        self.recorded('turtlesim', 'turtlesim_node', 'turtle1/cmd_vel', commands, '_seed:=7')
        result = replay.replay(os.path.join(self.folder, 'run.csv'))
        self.assertEqual((0, []), (result.different_poses, result.different_colours))

    @nightly
    def test_robot_world_makes_the_recording(self):
        """Also against a wall and along it."""
        commands = ([(0.5 - 0.05 * number, 0.04 * number, 0.1 * number - 0.6) for number in range(12)]
                    + [(0.5, 0.1, 0.0)] * 30 + [(0.3, -0.5, 0.8)] * 10)
        rows = self.recorded('robotont_gazebo', 'robotont_gazebo', 'cmd_vel', commands, '_world:=between')
        worlds = os.path.join(roslib.packages.get_pkg_dir('robotont_gazebo'), 'worlds')
        world = RobotWorld(load_world('between', worlds)[0])
        touched = False
        for row in rows:
            event = row['event'].split()
            if event[:1] == ['cmd']:
                world.command(*map(float, event[1:]))
            world.step()
            self.assertEqual([row['x'], row['y'], row['theta']], [f'{value:.9g}' for value in world.pose], row)
            touched |= world.touching
        self.assertTrue(touched)


if __name__ == '__main__':
    run(RecordingTest)
