#!/usr/bin/env python3
"""amcl: 2D Pose Estimate, a robot that is carried away, updates without motion, and refused poses."""
import math

import rospy
import tf2_ros
from geometry_msgs.msg import PoseArray, PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid
from nav_msgs.srv import GetMap, SetMap
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty

from navigation_core.poses import Pose
from navigation_core.ros.poses import from_pose, of_transform, to_pose
from rostest_support.common import NodeLog, proxy, run, until
from rostest_support.robotont import RobotontCase

NEAR = 0.15  # [m]


def estimate(pose, frame='map', deviation=0.2):
    """Return the message of 2D Pose Estimate."""
    message = PoseWithCovarianceStamped()
    message.header.frame_id, message.pose.pose = frame, from_pose(pose)
    message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[35] = deviation ** 2
    return message


class AmclTest(RobotontCase):

    def setUp(self):
        self.poses = self.collected('amcl_pose', PoseWithCovarianceStamped, wait=False)
        self.publisher = rospy.Publisher('initialpose', PoseWithCovarianceStamped, queue_size=1, latch=True)
        self.addCleanup(self.publisher.unregister)

    def off(self):
        """Return the error [m] of the last pose of a robot that only turns."""
        estimated, (x, y, _) = to_pose(self.poses.messages[-1].pose.pose), self.truth()
        return math.hypot(estimated.x - x, estimated.y - y)

    def next_scans(self, number):
        """Wait until so many scans have come."""
        scans = self.collected('scan', LaserScan)
        until(lambda: len(scans.messages) >= number, f'{number} scans')

    def publish_estimate(self, pose):
        """Publish a pose as 2D Pose Estimate, and return once it has arrived."""
        start = len(self.poses.messages)
        self.publisher.publish(estimate(pose))
        self.poses.next(what='a pose after initialpose') if start else until(lambda: self.poses.messages, 'a pose')

    def test_robot_is_where_the_estimate_says(self):
        x, y, yaw = self.truth()
        self.publish_estimate(Pose(x + 0.1, y - 0.1, yaw + 0.1))
        self.drive_until(lambda: self.off() < NEAR, lambda: f'the right pose: {self.off()}', 0.0, 0.0, 0.8)
        cloud = self.message('particlecloud', PoseArray)
        self.assertEqual('map', cloud.header.frame_id)
        self.assertTrue(100 <= len(cloud.poses) <= 500, len(cloud.poses))
        buffer = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(buffer)

        def on_tf():
            try:
                found = of_transform(buffer.lookup_transform('map', 'base_footprint', rospy.Time()).transform)
            except tf2_ros.TransformException:
                return False
            return math.hypot(found.x - x, found.y - y) < NEAR
        until(on_tf, 'the transform from map to base_footprint')

    def test_robot_that_is_carried_away_is_found(self):
        self.publish_estimate(Pose(*self.truth()))
        self.set_pose(2.0, -2.0, 1.0)
        until(lambda: math.hypot(self.truth()[0] - 2.0, self.truth()[1] + 2.0) < 0.01, 'the robot elsewhere')
        proxy('global_localization', Empty)()
        self.drive_until(lambda: self.off() < NEAR, lambda: f'the right pose: {self.off()}', 0.0, 0.0, 0.8)

    def test_a_robot_that_stands_is_not_found(self):
        """As with the original: scans count once the robot has moved by update_min_d or update_min_a."""
        x, y, yaw = self.truth()
        self.publish_estimate(Pose(x + 0.3, y, yaw))
        start = len(self.poses.messages)
        proxy('global_localization', Empty)()
        until(lambda: len(self.poses.messages) > start, 'a pose after global_localization')
        self.assertGreater(self.poses.messages[-1].pose.covariance[0], 0.25)  # m^2
        self.publish_estimate(Pose(x + 0.3, y, yaw))
        start = len(self.poses.messages)
        self.next_scans(5)
        self.assertEqual(start, len(self.poses.messages))
        self.assertAlmostEqual(0.3, self.off(), delta=0.05)

    def test_a_robot_that_stands_is_updated_on_request(self):
        self.publish_estimate(Pose(*self.truth()))
        start = len(self.poses.messages)
        proxy('request_nomotion_update', Empty)()
        until(lambda: len(self.poses.messages) > start, 'an update')

    def test_nonsense_is_refused_with_a_text(self):
        log = NodeLog('/amcl')
        self.publisher.publish(estimate(Pose(), 'odom'))
        log.wait(Log.WARN, r'Ignored a pose on initialpose: its frame is odom; it must be map\..*')
        self.assertFalse(proxy('set_map', SetMap)(OccupancyGrid(), estimate(Pose())).success)
        log.wait(Log.ERROR, r'The map of a call of set_map cannot be used: it has 0 x 0 cells.*')
        grid = proxy('static_map', GetMap)().map
        self.assertTrue(proxy('set_map', SetMap)(grid, estimate(Pose(*self.truth()))).success)


run(AmclTest)
