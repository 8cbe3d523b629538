#!/usr/bin/env python3
"""Namespaces, remaps, several simulators at once, and one that roslaunch starts anew."""
import os
import signal

import rospy
from std_srvs.srv import Empty
from turtlesim.msg import Pose

from rostest_support.common import (
    DEADLINE,
    MIDDLE,
    Collected,
    SimulatorCase,
    node_api,
    proxy,
    registered_names,
    run,
    until,
)

TURTLE = {'turtle1/set_pen', 'turtle1/teleport_absolute', 'turtle1/teleport_relative'}
OWN = {'get_loggers', 'set_logger_level', 'snapshot', 'get_drawing', 'pause', 'resume', 'step', 'set_rate'}
OWN_TOPICS = {'clock_status', 'drawing', 'image_raw', 'image_raw/compressed'}


def names(space, relative):
    return {f'{space}{name}' for name in relative}


class NamespaceTest(SimulatorCase):
    simulator = '/lab/turtlesim'
    space = '/lab/'

    def test_turtlesim_namespace(self):
        self.pose()
        self.snapshot()
        published, subscribed, services = registered_names('/lab/turtlesim')
        self.assertEqual({'/rosout', *names('/lab/', ('turtle1/pose', 'turtle1/color_sensor')),
                          *names('/lab/turtlesim/', OWN_TOPICS)}, published)
        self.assertEqual({'/lab/turtle1/cmd_vel'}, subscribed)
        self.assertEqual(names('/lab/', {'clear', 'reset', 'spawn', 'kill', *TURTLE}) | names('/lab/turtlesim/', OWN),
                         services)
        self.assertEqual('anna', self.call('spawn', 2.0, 3.0, 0.0, 'anna').name)
        poses = self.poses('anna')
        self.driver('anna/cmd_vel')(x=1.0)
        poses.next(lambda pose: pose.x > 2.5, 'the turtle driving')

    def test_turtlesim_namespace_background(self):
        """The private parameters are those of the node in its namespace."""
        rospy.set_param('/turtlesim/background_r', 1)
        self.set_parameter('background_r', 2)
        self.call('clear')
        self.assertEqual(2, self.color()[0])


class RemapTest(SimulatorCase):
    simulator = '/sim2'

    def setUp(self):
        """turtle1's teleport_relative is remapped, so wait for another service."""
        rospy.wait_for_service('/turtle1/teleport_absolute', DEADLINE)
        rospy.wait_for_service('/hop', DEADLINE)

    def test_turtlesim_remap(self):
        """A renamed simulator with a remapped command, pose and two services."""
        self.snapshot()
        poses = Collected('/where', Pose)
        poses.next()
        drive = self.driver('steer')
        drive(x=1.0)
        poses.next(lambda pose: pose.x > MIDDLE, 'a turtle that obeys /steer')
        published, subscribed, services = registered_names('/sim2')
        self.assertEqual({'/rosout', '/where', '/turtle1/color_sensor', *names('/sim2/', OWN_TOPICS)}, published)
        self.assertEqual({'/steer'}, subscribed)
        self.assertEqual({'/wipe', '/hop', '/reset', '/spawn', '/kill', '/turtle1/set_pen',
                          '/turtle1/teleport_absolute', *names('/sim2/', OWN)}, services)
        self.set_parameter('background_r', 3)
        self.call('turtle1/set_pen', 0, 0, 0, 0, 1)
        proxy('/wipe', Empty)()
        self.assertEqual(3, self.color()[0])


class First(SimulatorCase):
    simulator, space = '/turtlesim1/sim', '/turtlesim1/'


class Second(SimulatorCase):
    simulator, space = '/turtlesim2/sim', '/turtlesim2/'


class TwoSimulatorsTest(SimulatorCase):
    simulator = None

    def test_turtlesim_multisim(self):
        """The two of multisim.launch have nothing in common: turtles, parameters, pictures."""
        first, second = First(), Second()
        self.addCleanup(first.doCleanups)
        self.addCleanup(second.doCleanups)
        for simulator in (first, second):
            simulator.wait_for_turtle1()
        before = second.state()
        poses = first.poses()
        first.driver()(x=1.0)
        poses.next(lambda pose: pose.x > MIDDLE + 0.5, 'the first simulator\'s turtle driving')
        self.assertEqual('turtle2', first.call('spawn', 1.0, 1.0, 0.0, '').name)
        first.set_parameter('background_r', 0)
        first.call('clear')
        second.assert_unchanged(before)
        self.assertEqual('turtle2', second.call('spawn', 1.0, 1.0, 0.0, '').name)

    def test_turtlesim_two_in_a_namespace(self):
        """Two nodes beside each other share their turtles' names: one command moves both."""
        poses = Collected('/turtle1/pose', Pose)

        def of(simulator, fits):
            return [pose for pose in list(poses.messages)
                    if pose._connection_header['callerid'] == simulator and fits(pose)]
        simulators = ('/sim_a', '/sim_b')
        until(lambda: all(of(simulator, bool) for simulator in simulators), 'poses of both simulators')
        self.driver(subscribers=2)(x=1.0)
        until(lambda: all(of(simulator, lambda pose: pose.x > MIDDLE + 0.5) for simulator in simulators),
              'both turtles driving')


class RespawnTest(SimulatorCase):

    def test_turtlesim_respawn(self):
        """Killed, it is started anew by roslaunch and begins from the beginning."""
        self.jump(1.0, 1.0)
        pid = node_api('/turtlesim').getPid('/test')[2]
        os.kill(pid, signal.SIGKILL)
        until(lambda: self.has_new_process(pid), 'a new process of the simulator', deadline=2.0 * DEADLINE)
        until(lambda: self.pose().x == MIDDLE, 'turtle1 in the middle again')
        self.jump(2.0, 2.0)
        self.assert_pose(self.pose(), 2.0, 2.0, 0.0)

    def has_new_process(self, pid):
        try:
            return node_api('/turtlesim').getPid('/test')[2] != pid
        except OSError:
            return False


if __name__ == '__main__':
    run(NamespaceTest, RemapTest, TwoSimulatorsTest, RespawnTest)
