#!/usr/bin/env python3
"""A master that goes away and comes back. These tests have a master of their own, on a port of their own."""

import rospy
from turtlesim.msg import Pose

from rostest_support.common import (
    SERVICES,
    Collected,
    SimulatorCase,
    own_simulator,
    registered_names,
    run,
    until,
)
from rostest_support.masters import restart_master, start_master

RED = 7
RETURN_DEADLINE = 10.0  # [s] within which everything is registered again; 1 s on an idle machine


class MasterTest(SimulatorCase):
    master = None  # a Process

    def setUp(self):
        """Start a simulator with the master of this test, in a state that is not the first."""
        self.addCleanup(own_simulator(f'_background_r:={RED}', '_clock:=true').stop)
        self.wait_for_turtle1()
        self.jump(2.0, 3.0, 1.0)
        self.call('spawn', 7.0, 8.0, 0.5, 'anna')

    def restart_master(self):
        """End the master and start it anew on its port; it knows nothing of anybody then."""
        self.master.stop()
        MasterTest.master = restart_master()

    def test_turtlesim_master_returns(self):
        """The simulator registers everything again; its turtles stay as they were, the old subscribers connected."""
        poses = self.poses()
        before = registered_names(self.simulator)
        for _ in range(2):
            self.master.stop()
            poses.more(30)
            self.restart_master()
            until(lambda: all(a <= b for a, b in zip(before, registered_names(self.simulator))),
                  f'all of {before} registered again', RETURN_DEADLINE)
            self.assert_pose(self.pose(), 2.0, 3.0, 1.0)
            self.assert_pose(self.pose('anna'), 7.0, 8.0, 0.5)
            poses.more(30)
            until(lambda: rospy.get_param(f'{self.simulator}/background_r', None) == RED,
                  'the background as it was', RETURN_DEADLINE)
            until(lambda: rospy.get_param('/use_sim_time', False), 'nodes told to follow /clock', RETURN_DEADLINE)
        late = Collected('/anna/pose', Pose)
        late.next()
        self.driver('anna/cmd_vel')(x=1.0)
        late.next(lambda pose: pose.x > 7.5, 'anna driving')
        self.call('kill', 'anna')
        self.assertEqual('turtle2', self.call('spawn', 1.0, 1.0, 0.0, '').name)

    def test_turtlesim_master_away(self):
        """Without a master no turtle can be registered: spawn fails with the reason; everything else continues."""
        poses, drive = self.poses(), self.driver()
        # a connection that needs no master to be found
        spawn = self.persistent('spawn')
        jump = self.persistent('turtle1/teleport_absolute')
        clear = rospy.ServiceProxy('/clear', SERVICES['clear'], persistent=True)
        self.addCleanup(clear.close)
        clear()
        self.master.stop()
        with self.assertRaises(rospy.ServiceException) as failure:
            spawn(1.0, 1.0, 0.0, 'berta')
        self.assertIn('roscore', str(failure.exception))
        self.assertIn('berta', str(failure.exception))
        clear()
        jump(4.0, 5.0, 0.0)
        poses.next(lambda pose: pose.x == 4.0, 'the turtle where it was teleported')
        drive(x=1.0)
        poses.next(lambda pose: pose.x > 4.5, 'the turtle driving')
        self.restart_master()
        until(lambda: 'berta' not in self.turtles() and 'anna' in self.turtles(), 'the turtles of before',
              RETURN_DEADLINE)
        self.assertEqual('berta', self.call('spawn', 1.0, 1.0, 0.0, 'berta').name)
        self.assert_pose(self.pose('berta'), 1.0, 1.0, 0.0)

    def persistent(self, name):
        """Return a proxy of a service that is connected now and stays so."""
        service = rospy.ServiceProxy(f'/{name}', SERVICES[name.rsplit('/', 1)[-1]], persistent=True)
        self.addCleanup(service.close)
        with self.assertRaises(rospy.ServiceException):  # connects with a call that changes nothing
            service(float('nan'), 0.0, 0.0, *['x'] * (name == 'spawn'))
        return service


if __name__ == '__main__':
    MasterTest.master = start_master()
    try:
        run(MasterTest)
    finally:
        MasterTest.master.stop()
