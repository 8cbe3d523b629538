#!/usr/bin/env python3
"""goto_pose_server.py and a master that is started anew. The test has a master of its own, on a port of its own."""

import rospy
from turtlesim.srv import TeleportAbsolute

from rostest_support.common import own_simulator, proxy, registered_names, run, until
from rostest_support.course import CourseCase
from rostest_support.masters import restart_master, start_master

SERVICE = '/turtle1/gotoPose'


class MasterTest(CourseCase):
    master = None  # a Process

    def setUp(self):
        self.addCleanup(own_simulator().stop)
        super().setUp()

    def names(self):
        """Return the topics and services that the master knows of the server."""
        return set.union(*registered_names('/goto_pose_server')) - {'/rosout'}

    def test_goto_pose_master_returns(self):
        """The server registers everything again, and its service drives the turtle as before."""
        self.start('goto_pose_server.py')
        proxy(SERVICE, TeleportAbsolute)(6.0, 5.0, 0.0)
        before = self.names()
        self.master.stop()
        MasterTest.master = restart_master()
        until(lambda: self.names() == before, f'{before} registered again')
        rospy.wait_for_service('/turtle1/set_pen')
        proxy(SERVICE, TeleportAbsolute)(5.0, 6.0, 0.0)
        self.assert_at(self.pose(), 5.0, 6.0, 0.0)


if __name__ == '__main__':
    MasterTest.master = start_master()
    try:
        run(MasterTest)
    finally:
        MasterTest.master.stop()
