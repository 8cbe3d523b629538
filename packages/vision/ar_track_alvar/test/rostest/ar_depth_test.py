#!/usr/bin/env python3
"""individualMarkers and findMarkerBundles: poses in point clouds, and what happens where points are missing."""
import copy
import os

import numpy as np
import roslib.packages
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header

from alvar_core import bundles, rotations
from rospy_support.images import to_cloud
from rostest_support.common import nightly, run
from rostest_support.marker_scenes import Placed
from rostest_support.markers import CAMERA, FRAME, PLACED, TrackerCase, camera_info, picture, stays_away

TABLE = os.path.join(roslib.packages.get_pkg_dir('ar_track_alvar'), 'bundles', 'table_8_9_10.xml')
RAYS = np.concatenate([CAMERA.to_rays(np.stack(np.meshgrid(np.arange(640), np.arange(480)), -1).astype(float)),
                       np.ones((480, 640, 1))], -1)
BEHIND = 3.0  # [m] the wall behind the markers
PAPER = 0.7  # of the side: what belongs to a marker, from its middle


def points_of(*placed):
    """Return the points (480, 640, 3) of Placed markers and of a wall behind them."""
    z = np.full((480, 640), BEHIND)
    for marker in placed:
        normal = marker.rotation[:, 2]
        depth = (normal @ marker.position) / (RAYS @ normal)
        local = (RAYS * depth[..., None] - marker.position) @ marker.rotation
        z = np.where((np.abs(local[..., :2]).max(-1) < PAPER * marker.size) & (depth > 0), depth, z)
    return (RAYS * z[..., None]).astype(np.float32)


class DepthTest(TrackerCase):

    def show(self, points, *placed, **options):
        """Return a camera that shows markers in clouds with these points."""
        camera = self.camera(kind=PointCloud2, **options)
        colour = np.repeat(picture(*placed)[..., None], 3, 2)
        camera.info, camera.image = camera_info(), to_cloud(points, colour, 'bgr8', Header())
        return camera

    def test_ar_depth_poses(self):
        """Poses of markers at known places come from image and points."""
        poses = self.collected()
        self.show(points_of(*PLACED.values()), *PLACED.values())
        self.assert_poses(self.next_with(poses, *PLACED))
        status = self.status(lambda status: status.message.endswith('images per second'), 'a normal second')
        self.assertGreater(int(status['poses from image and points']), 0)
        self.assertEqual('0', status['poses from the image alone'])

    @nightly
    def test_ar_depth_without_points(self):
        """Without points, as in the blind zone, the poses come from the image, and a warning says so."""
        poses, log = self.collected(), self.log()
        self.show(np.full((480, 640, 3), np.nan, np.float32), *PLACED.values())
        self.assert_poses(self.next_with(poses, *PLACED))
        log.wait(Log.WARN, r'The pose of marker \d+ comes from the image alone: the cloud has too few points on it .*')

    def test_ar_depth_contradiction(self):
        """Points twice as far away as the size says: they count, and a warning names the size."""
        marker, poses, log = PLACED[100], self.collected(), self.log()
        self.show(2 * points_of(marker), marker)
        found = poses.next(lambda message: [m.id for m in message.markers] == [100], 'the marker').markers[0]
        self.assertLess(found.confidence, 51)
        self.assert_pose(found.pose.pose, marker.rotation, 2 * marker.position)
        log.wait(Log.WARN, r'The points of marker 100 contradict the image: they show it 20\.\d cm wide .* 10\.0 cm.*')

    @nightly
    def test_ar_depth_bad_clouds(self):
        """Clouds that cannot be used are refused with the reason; then all is well again."""
        camera, poses = self.show(points_of(*PLACED.values()), *PLACED.values()), self.collected()
        self.assert_poses(self.next_with(poses, *PLACED))
        log, good = self.log(), camera.image
        row, plain, short, turned = (copy.copy(good) for _ in range(4))
        row.height, row.width, row.row_step = 1, 480 * 640, len(good.data)
        plain.fields = good.fields[:3]
        short.data = good.data[:1000]
        moved = points_of(*PLACED.values())[..., [2, 0, 1]] * np.float32([1, -1, -1])  # x ahead: not an optical frame
        turned.data = to_cloud(moved, np.repeat(picture(*PLACED.values())[..., None], 3, 2), 'bgr8', Header()).data
        for message, topic, said in ((row, 'image', 'it is not organised'), (plain, 'image', 'it has no colours'),
                                     (short, 'image', 'it has 1000 bytes of data'),
                                     (turned, 'info', 'px away from the pixels that show them')):
            camera.image = message
            self.status(lambda status, said=said: said in status.message, said)
            self.assertTrue(stays_away(poses), said)
            log.wait(Log.WARN, f'/camera_{topic}: .*{said}.*')
        camera.image = good
        self.assert_poses(self.next_with(poses, *PLACED))

    def test_ar_depth_bundle(self):
        """pr2_bundle.launch: the pose of a bundle whose master is covered; its max_track_error of 0 loses no image."""
        rotation, position = rotations.facing(0.4, 0.8, 0.3), np.array([-0.02, 0.0, 0.5])
        bundle, markers = bundles.read(TABLE), []
        for number in (9, 10):
            turn, centre = bundles.marker_pose(bundle.corners[number])
            markers.append(Placed(number, bundle.sizes[number], rotation @ turn, rotation @ centre + position))
        poses = self.collected()
        self.show(points_of(*markers), *markers, topic='bundles/points', info_topic='bundles/camera_info')
        first = poses.index(lambda message: [m.id for m in message.markers] == [8], 'the bundle')
        for message in poses.some(first, 4):
            self.assertEqual([8], [m.id for m in message.markers])
            self.assertEqual(FRAME, message.header.frame_id)
            self.assert_pose(message.markers[0].pose.pose, rotation, position)


if __name__ == '__main__':
    run(DepthTest)
