#!/usr/bin/env python3
"""Distances to a box ahead, from depth image to /scan_to_distance."""
import math

from robotont_laserscan_to_distance.msg import LaserScanSplit
from robotont_sensors.msg import LaserScanSplit as OldLaserScanSplit
from sensor_msgs.msg import LaserScan

from kinematic_core.worlds import camera
from rostest_support.common import run, until
from rostest_support.robotont import RobotontCase

BOX = 1.882  # [m] x of the box's face in bangbang
CAMERA = -0.115  # [m] of the robot
TOLERANCE = 0.01  # [m]


class DistancesTest(RobotontCase):

    def setUp(self):
        self.set_pose(1.0, 0.0, 0.0)

    def test_the_box_is_as_far_as_it_is(self):
        expected = BOX - (1.0 + CAMERA)
        new = self.collected('scan_to_distance', LaserScanSplit)
        old = self.collected('old/scan_to_distance', OldLaserScanSplit)
        until(lambda: abs(new.messages[-1].center_min - expected) < TOLERANCE, lambda: f'the box: {new.messages[-1]}')
        until(lambda: abs(old.messages[-1].centerMin - expected) < TOLERANCE, lambda: f'the box: {old.messages[-1]}')
        self.assertGreaterEqual(new.messages[-1].center_mean, new.messages[-1].center_min)

    def test_left_is_left(self):
        """Beside the box, the left sees nothing of it."""
        split = self.collected('scan_to_distance', LaserScanSplit)
        self.set_pose(1.0, 0.8, 0.0)  # the box ends at y = 0.5
        until(lambda: split.messages[-1].right_min < split.messages[-1].left_min - 0.1
              or math.isnan(split.messages[-1].left_min), lambda: f'the box on the right: {split.messages[-1]}')

    def test_the_scan_is_one_of_the_camera(self):
        scan = self.message('scan', LaserScan)
        self.assertEqual('camera_depth_frame', scan.header.frame_id)
        self.assertEqual(camera.WIDTH, len(scan.ranges))
        self.assertAlmostEqual(math.pi / 4, -scan.angle_min, delta=0.01)


if __name__ == '__main__':
    run(DistancesTest)
