#!/usr/bin/env python3
"""Distributed ROS as the course teaches it: robot and laptop as two network namespaces with a cable between them."""
import os
import re
import subprocess
import sys
import time
import unittest

sys.path.append(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..'))
from rostest_tools import Process, run, skip, until

ROBOT, LAPTOP, ELSEWHERE = '10.77.0.1', '10.77.0.2', '10.88.0.9'
MASTER = f'http://{ROBOT}:11311'
WATCHDOG = 1.0  # [s] after the last command


class Machine:
    """A network namespace of its own, held by a process, with one end of the cable."""

    def __init__(self, address):
        self.address = address
        self._holder = subprocess.Popen(['unshare', '-n', 'sleep', 'infinity'])
        own = os.readlink('/proc/self/ns/net')
        until(lambda: os.readlink(f'/proc/{self.pid}/ns/net') != own, 'a network namespace')

    @property
    def pid(self):
        """The process that holds the namespace."""
        return self._holder.pid

    def command(self, *command):
        """Return the command line that runs a command on this machine."""
        return ('nsenter', '-t', str(self.pid), '-n', *command)

    def do(self, *command):
        """Run a command on this machine."""
        subprocess.run(self.command(*command), check=True, timeout=20)

    def start(self, *command, ros_ip=None):
        """Start a ROS program on this machine, as a Process."""
        return Process('env', '-u', 'ROS_HOSTNAME', f'ROS_IP={ros_ip or self.address}', f'ROS_MASTER_URI={MASTER}',
                       *self.command(*command))

    def remove(self):
        """End the holder, and with it the namespace."""
        self._holder.kill()
        self._holder.wait()


class TwoMachinesTest(unittest.TestCase):
    def setUp(self):
        self.robot, self.laptop = Machine(ROBOT), Machine(LAPTOP)
        self.addCleanup(self.laptop.remove)
        self.addCleanup(self.robot.remove)
        subprocess.run(['ip', 'link', 'add', 'cable', 'netns', str(self.robot.pid), 'type', 'veth',
                        'peer', 'name', 'cable', 'netns', str(self.laptop.pid)], check=True, timeout=20)
        for machine in (self.robot, self.laptop):
            machine.do('ip', 'link', 'set', 'lo', 'up')
            machine.do('ip', 'address', 'add', f'{machine.address}/24', 'dev', 'cable')
            machine.do('ip', 'link', 'set', 'cable', 'up')
        self.on(self.robot, 'roscore').wait_for_output('started core service')
        self.on(self.robot, 'rosrun', 'turtlesim', 'turtlesim_node').wait_for_output('Spawning turtle')
        self.poses = self.on(self.robot, 'rostopic', 'echo', '-p', '/turtle1/pose')
        self.poses.wait_for_output(r'\n\d.*\n')

    def on(self, machine, *command, **options):
        process = machine.start(*command, **options)
        self.addCleanup(process.stop)
        return process

    def x(self):
        """Return the newest x [m] of the turtle, seen on the robot itself."""
        return float(re.findall(r'^\d+,([\d.]+),.*$', self.poses.output(), re.MULTILINE)[-1])

    def speed(self):
        return float(re.findall(r'^\d+(?:,[^,\n]*){3},([^,\n]+),[^,\n]+$', self.poses.output(), re.MULTILINE)[-1])

    def test_the_laptop_drives_the_robot(self):
        """Then the cable is pulled, and the robot stops within its watchdog's time."""
        start = self.x()
        self.on(self.laptop, 'rosrun', 'turtle_robotont', 'velocity_publisher.py', '_angular:=0')
        until(lambda: self.x() > start + 0.2, 'a robot that moves')
        self.laptop.do('ip', 'link', 'set', 'cable', 'down')
        self.addCleanup(self.laptop.do, 'ip', 'link', 'set', 'cable', 'up')  # nodes that end look for their master
        pulled = time.monotonic()
        until(lambda: self.speed() == 0.0, 'a robot that stops')
        self.assertLess(time.monotonic() - pulled, WATCHDOG + 1.0)

    def test_a_wrong_ros_ip_is_explained(self):
        """rospy says nothing: the robot cannot connect to the laptop's node, and stands."""
        start = self.x()
        node = self.on(self.laptop, 'rosrun', 'turtle_robotont', 'velocity_publisher.py', ros_ip=ELSEWHERE)
        node.wait_for_output(rf'ROS_IP is {ELSEWHERE}, but this machine has the addresses .*{LAPTOP}'
                             rf'.*export ROS_IP={LAPTOP}')
        node.wait_for_output(r'/turtle1/cmd_vel: /turtlesim is known to the master, but there is no connection')
        self.assertEqual(start, self.x())


def main():
    """Run the test as root of a namespace, or skip it where namespaces cannot be had."""
    as_root = [] if os.getuid() == 0 else ['unshare', '--user', '--map-root-user']
    probe = subprocess.run([*as_root, 'unshare', '-n', 'ip', 'link'], stdout=subprocess.DEVNULL,
                           stderr=subprocess.PIPE, check=False)
    if probe.returncode:
        skip(f'no network namespaces here: {probe.stderr.decode().strip()}')
    elif as_root:
        os.execvp('unshare', [*as_root, *sys.argv])
    else:
        run(TwoMachinesTest)


if __name__ == '__main__':
    main()
