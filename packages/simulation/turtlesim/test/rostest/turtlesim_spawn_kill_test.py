#!/usr/bin/env python3
"""spawn, kill and reset: which turtles there are, their names, topics and services."""

import rospy
import rosservice
from rosgraph_msgs.msg import Log
from turtlesim.msg import Pose

from rostest_support.common import MIDDLE, Collected, NodeLog, SimulatorCase, registered_names, run, until

SERVICES = ('set_pen', 'teleport_absolute', 'teleport_relative')
TOPICS = ('cmd_vel', 'pose', 'color_sensor')


class SpawnKillTest(SimulatorCase):

    def names_of(self, turtle):
        """Return the registrations for a turtle: a set of names, without the turtle's."""
        published, subscribed, services = registered_names('/turtlesim')
        return {name.rsplit('/', 1)[-1] for name in published | subscribed | services
                if name.startswith(f'/{turtle}/')}

    def connected(self, collected):
        """Wait until a subscriber, of a turtle to come, receives poses."""
        collected.next(what='a pose')

    def test_turtlesim_spawn(self):
        """Spawn puts a turtle of its own where it is asked to."""
        self.assertEqual('LLCROS', self.call('spawn', 3.0, 4.0, 1.57, 'LLCROS').name)
        self.assert_pose(self.pose('LLCROS'), 3.0, 4.0, 1.57)
        self.assert_pose(self.pose('turtle1'), MIDDLE, MIDDLE, 0.0)
        poses = self.poses('LLCROS')
        self.driver('LLCROS/cmd_vel')(x=1.0)
        poses.next(lambda pose: pose.y > 4.5, 'the spawned turtle driving up')
        self.assert_pose(self.pose('turtle1'), MIDDLE, MIDDLE, 0.0)

    def test_turtlesim_spawn_then_services(self):
        """The services of a turtle exist when spawn returns."""
        for _ in range(5):
            name = self.call('spawn', 1.0, 1.0, 0.0, '').name
            for service in SERVICES:
                self.assertIsNotNone(rosservice.get_service_uri(f'/{name}/{service}'), f'/{name}/{service}')
            rospy.ServiceProxy(f'/{name}/set_pen', rosservice.get_service_class_by_name(f'/{name}/set_pen'))(
                0, 0, 0, 1, 0)

    def test_turtlesim_spawn_duplicate(self):
        """A name that is taken is refused, in turtlesim's words."""
        log = NodeLog('/turtlesim')
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        before = self.state()
        self.assertIn('anna', self.refused('spawn', 5.0, 5.0, 0.0, 'anna'))
        log.wait(Log.ERROR, r'A turtled named \[anna\] already exists.*')
        self.assertIn('turtle1', self.refused('spawn', 5.0, 5.0, 0.0, 'turtle1'))
        log.wait(Log.ERROR, r'A turtled named \[turtle1\] already exists.*')
        self.assert_unchanged(before)

    def test_turtlesim_kill(self):
        """Kill takes all that the turtle had registered."""
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        self.assertEqual({*SERVICES, *TOPICS}, self.names_of('anna'))
        self.call('kill', 'anna')
        until(lambda: not self.names_of('anna'), 'a master that knows nothing of the killed turtle')
        self.assertEqual({*SERVICES, *TOPICS}, self.names_of('turtle1'))
        self.pose('turtle1')

    def test_turtlesim_kill_last(self):
        """A simulator without turtles continues, and reset brings turtle1 back."""
        self.call('kill', 'turtle1')
        until(lambda: not self.names_of('turtle1'), 'a simulator without turtles')
        self.call('reset')
        self.assert_pose(self.pose('turtle1'), MIDDLE, MIDDLE, 0.0)

    def test_turtlesim_kill_unknown(self):
        """Kill of a turtle that does not exist is refused, in turtlesim's words."""
        log = NodeLog('/turtlesim')
        before = self.state()
        self.assertLess(len(self.refused('kill', 'a' * 100000)), 1000)
        for name in ('nobody', ''):
            self.assertIn(f'[{name}]', self.refused('kill', name))
            log.wait(Log.ERROR, rf'Tried to kill turtle \[{name}\], which does not exist.*')
        self.assert_unchanged(before)

    def test_turtlesim_kill_with_subscribers(self):
        """Subscribers of a killed turtle get nothing more; of a new one of its name they hear again."""
        self.call('spawn', 2.0, 2.0, 0.0, 'anna')
        subscribers = [Collected('/anna/pose', Pose) for _ in range(3)] + [self.colors('anna')]
        drive = self.driver('anna/cmd_vel')
        self.connected(subscribers[0])
        drive(x=1.0)
        self.call('kill', 'anna')
        until(lambda: not self.names_of('anna'), 'a master that knows nothing of the killed turtle')
        drive(x=1.0)
        until(lambda: not subscribers[0].subscriber.get_num_connections(), 'an end of the subscribers\' connections')
        self.poses('turtle1').more(10)
        self.call('spawn', 7.0, 7.0, 0.0, 'anna')
        for subscriber in subscribers:
            self.connected(subscriber)
        self.assert_pose(subscribers[0].messages[-1], 7.0, 7.0, 0.0)

    def test_turtlesim_reset(self):
        """reset leaves turtle1 in the middle of an empty canvas and begins the numbering anew."""
        empty = self.snapshot()
        for name in ('', '', 'anna'):
            self.call('spawn', 2.0, 2.0, 0.0, name)
        self.call('turtle1/set_pen', 255, 0, 0, 40, 0)
        self.call('turtle1/teleport_absolute', 1.0, 1.0, 1.0)
        self.driver()(x=1.0)
        self.call('reset')
        until(lambda: self.turtles() == {'turtle1'}, 'a simulator with turtle1 alone')
        pose = self.pose()
        self.assert_pose(pose, MIDDLE, MIDDLE, 0.0)
        self.assertEqual(0.0, pose.linear_velocity)
        self.assertEqual(empty, self.snapshot())
        self.assertEqual('turtle2', self.call('spawn', 2.0, 2.0, 0.0, '').name)

    def test_turtlesim_reset_keeps_subscribers(self):
        """Who subscribes and publishes before a reset does so after it."""
        poses, drive = self.poses(), self.driver()
        self.jump(1.0, 1.0)
        for _ in range(3):
            self.call('reset')
            poses.next(lambda pose: pose.x == poses.messages[0].x, 'turtle1 back in the middle')
            drive(x=1.0)
            poses.next(lambda pose: pose.x > MIDDLE, 'turtle1 driving for the publisher of before the reset')


if __name__ == '__main__':
    run(SpawnKillTest)
