#!/usr/bin/env python3
"""slam_gmapping makes a map of the maze and knows where the robot is in it."""
import math

import numpy as np
import rospy
import tf2_ros
from nav_msgs.msg import MapMetaData, OccupancyGrid, Odometry
from nav_msgs.srv import GetMap
from std_msgs.msg import Float64

from navigation_core.ros.poses import of_transform
from rostest_support.common import DEADLINE, proxy, run, until
from rostest_support.robotont import RobotontCase, place


class GmappingTest(RobotontCase):

    def test_map_and_pose(self):
        buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(buffer)
        entropies = self.collected('slam_gmapping/entropy', Float64, wait=False)
        truth = self.collected('~ground_truth', Odometry)
        start = place(truth.messages[-1])[1]
        self.drive_until(lambda: abs(place(truth.messages[-1])[1] - start) > 0.6, 'a drive of 0.6 m', 0.05, 0.2, 0.3)
        until(lambda: entropies.messages, 'an update of the map')
        message = rospy.wait_for_message('map', OccupancyGrid, DEADLINE)
        cells = np.array(message.data).reshape(message.info.height, message.info.width)
        self.assertEqual({-1, 0, 100}, set(np.unique(cells)))
        self.assertGreater((cells == 0).sum(), 1000)  # 2.5 m2
        self.assertEqual('map', message.header.frame_id)
        self.assertEqual(message.info.width, rospy.wait_for_message('map_metadata', MapMetaData, DEADLINE).width)
        self.assertEqual(message.info.resolution, proxy('dynamic_map', GetMap)().map.info.resolution)

        def off():
            """Return the error [m] of the pose in the map, which begins as the odometry's frame."""
            stamp = truth.messages[-1].header.stamp
            try:
                found = of_transform(buffer.lookup_transform('map', 'base_footprint', stamp).transform)
            except tf2_ros.TransformException:
                return math.inf
            x, y, _ = place(truth.messages[-1])
            return math.hypot(found.x - x, found.y - y)
        until(lambda: off() < 0.1, lambda: f'the right pose: {off()} m')


run(GmappingTest)
