#!/usr/bin/env python3
"""Distributed ROS as the course teaches it: robot and laptop as two network namespaces with a cable between them."""
import os
import re
import subprocess
import sys
import unittest

from kinematic_core.timing.stall_free_timer import ActiveTimer
from rostest_support.common import Process, run, skip, until
from rostest_support.node_pages import REPOSITORY

ROBOT, LAPTOP, ELSEWHERE = '10.77.0.1', '10.77.0.2', '10.88.0.9'
MASTER = f'http://{ROBOT}:11311'
PAGE = REPOSITORY / 'course' / '34_two_machines' / 'README.md'
MARGIN = 1.0  # [s] of a loaded machine, for a stop to be seen


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


def connect(one, other):
    """Put a cable between two machines."""
    subprocess.run(['ip', 'link', 'add', 'cable', 'netns', str(one.pid), 'type', 'veth',
                    'peer', 'name', 'cable', 'netns', str(other.pid)], check=True, timeout=20)
    for machine in (one, other):
        machine.do('ip', 'link', 'set', 'lo', 'up')
        machine.do('ip', 'address', 'add', f'{machine.address}/24', 'dev', 'cable')
        machine.do('ip', 'link', 'set', 'cable', 'up')


class TwoMachinesCase(unittest.TestCase):
    """A simulator on the robot, with a cable to the laptop; a subclass says which simulator."""

    simulator = ()  # the command
    topic = position = speed = ''  # where it says how it moves, and the fields there, in the words of rostopic echo -p
    watchdog = 0.0  # [s] after the last command

    def setUp(self):
        self.robot, self.laptop = Machine(ROBOT), Machine(LAPTOP)
        self.addCleanup(self.laptop.remove)
        self.addCleanup(self.robot.remove)
        connect(self.robot, self.laptop)
        self.start_robot()
        self.seen = self.on(self.robot, 'rostopic', 'echo', '-p', self.topic)
        self.seen.wait_for_output(r'\n\d.*\n')

    def start_robot(self):
        self.on(self.robot, 'roscore').wait_for_output('started core service')
        self.simulating = self.on(self.robot, *self.simulator)

    def on(self, machine, *command, **options):
        process = machine.start(*command, **options)
        self.addCleanup(process.stop)
        return process

    def newest(self, field):
        """Return a field of the newest message, seen on the robot itself."""
        lines = self.seen.output().splitlines(keepends=True)
        complete = [line for line in lines if line.endswith('\n') and line[0].isdigit()][-1]
        names = next(line for line in lines if line.startswith('%time')).strip().split(',')
        return float(complete.split(',')[names.index(f'field.{field}')])

    def drive_and_pull_the_cable(self, *node, **options):
        start = self.newest(self.position)
        self.on(self.laptop, *node, **options)
        until(lambda: self.newest(self.position) > start + 0.2, 'a robot that moves')
        self.laptop.do('ip', 'link', 'set', 'cable', 'down')
        self.addCleanup(self.laptop.do, 'ip', 'link', 'set', 'cable', 'up')  # nodes that end look for their master
        timer = ActiveTimer()
        until(lambda: (timer.elapsed(), self.newest(self.speed))[1] == 0.0, 'a robot that stops')
        self.assertLess(timer.elapsed(), self.watchdog + MARGIN)

    def drive_with_a_wrong_ros_ip(self, *node, topic):
        """rospy says nothing: the simulator, which cannot connect to the laptop's node, does, and the robot stands."""
        start = self.newest(self.position)
        self.on(self.laptop, *node, '__name:=driver', ros_ip=ELSEWHERE)
        self.simulating.wait_for_output(rf'{topic}: /driver is known to the master, but no connection exists')
        self.assertEqual(start, self.newest(self.position))


class TurtleTest(TwoMachinesCase):
    simulator = 'rosrun', 'turtlesim', 'turtlesim_node'
    topic, position, speed = '/turtle1/pose', 'x', 'linear_velocity'
    watchdog = 1.0

    def test_the_laptop_drives_the_turtle(self):
        self.drive_and_pull_the_cable('rosrun', 'turtle_robotont', 'velocity_publisher.py', '_angular:=0')

    def test_a_wrong_ros_ip_is_explained(self):
        self.drive_with_a_wrong_ros_ip('rosrun', 'turtle_robotont', 'velocity_publisher.py',
                                       topic='/turtle1/cmd_vel')


class RobotTest(TwoMachinesCase):
    simulator = 'rosrun', 'robotont_gazebo', 'robotont_gazebo'
    topic, position, speed = '/odom', 'pose.pose.position.x', 'twist.twist.linear.x'
    watchdog = 0.5
    node = 'rosrun', 'turtle_robotont', 'ar_control_node.py', '_mode:=forward'

    def test_the_laptop_drives_the_robot(self):
        self.drive_and_pull_the_cable(*self.node, '_rate:=10')

    def test_a_wrong_ros_ip_is_explained_of_a_robot(self):
        self.drive_with_a_wrong_ros_ip(*self.node, topic='/cmd_vel')


class CoursePageTest(TwoMachinesCase):
    """What step 34 of the course tells the reader to type on the robot, and on the laptop."""

    topic, position, speed, watchdog = RobotTest.topic, RobotTest.position, RobotTest.speed, RobotTest.watchdog

    def start_robot(self):
        with open(PAGE, encoding='utf-8') as file:
            step = file.read()
        blocks = re.findall(r'^```(\w*)\n(.*?)^```$', step, re.MULTILINE | re.DOTALL)
        on_robot, self.on_laptop = (text for language, text in blocks if not language)
        self.on(self.robot, 'bash', '-c', on_robot, ros_ip=ELSEWHERE).wait_for_output('started core service')

    def test_the_step_two_machines(self):
        self.drive_and_pull_the_cable('bash', '-c', self.on_laptop, ros_ip=ELSEWHERE)


def main(run_tests):
    """Call ``run_tests`` as root of a namespace, or skip the test where namespaces cannot be had."""
    as_root = [] if os.getuid() == 0 else ['unshare', '--user', '--map-root-user']
    probe = subprocess.run([*as_root, 'unshare', '-n', 'ip', 'link', 'add', 'cable', 'type', 'veth'],
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
    if probe.returncode:  # in a container, namespaces can be allowed and network cards not
        skip(f'no network namespaces with a cable here: {probe.stderr.decode().strip()}')
    elif as_root:
        os.execvp('unshare', [*as_root, *sys.argv])
    else:
        run_tests()


if __name__ == '__main__':
    main(lambda: run(TurtleTest, RobotTest, CoursePageTest))
