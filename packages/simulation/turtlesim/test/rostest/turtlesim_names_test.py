#!/usr/bin/env python3
"""Two simulators at once: one in a namespace, one with remapped names."""
import rospy
from std_srvs.srv import Empty
from turtlesim.msg import Pose

from rostest_support.common import DEADLINE, MIDDLE, Collected, SimulatorCase, proxy, registered_names, run

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
    """A simulator of another name with a remapped command, pose and two services."""

    simulator = '/sim2'

    def wait_for_turtle1(self):
        """turtle1's teleport_relative is remapped, so wait for another service."""
        rospy.wait_for_service('/turtle1/teleport_absolute', DEADLINE)
        rospy.wait_for_service('/hop', DEADLINE)

    def test_turtlesim_remap(self):
        poses = Collected('/where', Pose)
        poses.next()
        self.driver('steer')(x=1.0)
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


if __name__ == '__main__':
    run(NamespaceTest, RemapTest)
