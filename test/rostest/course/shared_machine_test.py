#!/usr/bin/env python3
"""Two users on one machine: each in a shell of a workspace of its own, and none meets the other one's nodes."""
import contextlib
import os
import pathlib
import subprocess
import tempfile
import unittest

from rostest_support.common import Process, run, until
from rostest_support.node_pages import REPOSITORY

WRITE = '. "$0/tools/environment.bash"; ws=$1; write_shell_files'
IN_WORKSPACE = '. "$0/env.bash"; "$@"'
FOREIGN = 'ROS_MASTER_URI', 'ROS_HOSTNAME', 'PYTHONPATH', 'CMAKE_PREFIX_PATH'
LINE_DEADLINE = 60.0  # [s] for a command of ROS on a loaded machine


class User:
    """A user with a home folder and a workspace, which shares the built packages of this test."""

    def __init__(self, folder):
        self._workspace = folder / 'workspace'
        self._workspace.mkdir()
        for name in ('devel', 'venv', 'src'):
            (self._workspace / name).symlink_to(pathlib.Path(os.environ['ws']) / name)
        subprocess.run(['bash', '-euc', WRITE, REPOSITORY, self._workspace], check=True)
        self._environment = {name: value for name, value in os.environ.items() if name not in FOREIGN}
        self._environment.update(HOME=str(folder), ROS_HOME=str(folder / '.ros'), PYTHONUNBUFFERED='1')

    def types(self, *command):
        """Return a command in the shell of this user."""
        return ['env', '-i', *(f'{name}={value}' for name, value in self._environment.items()),
                'bash', '-c', IN_WORKSPACE, str(self._workspace), *command]

    def sees(self, *command):
        """Return the output of a command, as lines."""
        done = subprocess.run(self.types(*command), capture_output=True, text=True, check=False, timeout=LINE_DEADLINE)
        return done.stdout.splitlines()


class SharedMachineTest(unittest.TestCase):

    def test_two_users_do_not_meet(self):
        with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as running:
            homes = [pathlib.Path(folder) / name for name in ('anna', 'bert')]
            for home in homes:
                home.mkdir()
            users = [User(home) for home in homes]
            for user in users:
                core = running.enter_context(Process(*user.types('roscore')))
                core.wait_for_output('started core service', LINE_DEADLINE)
            simulators = [running.enter_context(Process(*user.types(
                'rosrun', 'turtlesim', 'turtlesim_node', '_window:=false'))) for user in users]
            for simulator in simulators:
                simulator.wait_for_output('Spawning turtle')
            first = running.enter_context(Process(*users[0].types('rosrun', 'turtle_robotont', 'velocity_publisher.py',
                                                                  '__name:=publisher')))
            first.wait_for_output('Publish turtle velocity')
            until(lambda: users[0].sees('rosnode', 'list') == ['/publisher', '/rosout', '/turtlesim'],
                  'the nodes of the first user', LINE_DEADLINE)
            self.assertEqual(['/rosout', '/turtlesim'], users[1].sees('rosnode', 'list'))
            self.assertIn('linear_velocity: 0.5', users[0].sees('rostopic', 'echo', '-n1', '/turtle1/pose'))
            self.assertIn('linear_velocity: 0.0', users[1].sees('rostopic', 'echo', '-n1', '/turtle1/pose'))
            self.assertTrue(all(simulator.runs() for simulator in simulators))


if __name__ == '__main__':
    run(SharedMachineTest)
