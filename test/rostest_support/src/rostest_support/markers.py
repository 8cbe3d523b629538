"""Helpers for tests of ar_track_alvar: a camera that shows rendered markers, and tolerances of poses."""
import copy
import threading
import time
import unittest

import numpy as np
import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Pose, Transform
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker

from alvar_core import rotations
from alvar_core.camera import default_camera
from ar_track_alvar.conversions import matrix_of
from rospy_support import images
from rostest_support.common import Collected, NodeLog, until
from rostest_support.marker_scenes import Placed, Scene, image_of

TRACKER = '/tracker'
FRAME = 'camera'
SIZE = 0.1  # [m] of the markers, the tracker's default
POSITION_TOLERANCE = 0.01  # share of the distance
ANGLE_TOLERANCE = np.radians(1.5)
AT_THE_CAMERA = np.eye(3), np.zeros(3)

CAMERA = default_camera()
PLACED = {number: Placed(number, SIZE, rotations.facing(0.45, 1.0 + number, 0.4 * number), np.array(place))
          for number, place in ((3, (-0.15, 0.02, 0.5)), (100, (0.02, -0.05, 0.6)), (255, (0.2, 0.05, 0.7)))}


def picture(*placed, camera=CAMERA, size=(640, 480)):
    """Return the grey picture of Placed markers."""
    scene = Scene(width=size[0], height=size[1])
    return image_of(np.random.default_rng(1), camera, [copy.copy(marker) for marker in placed], scene)


def camera_info(camera=CAMERA, size=(640, 480)):
    """Return the CameraInfo of a Camera."""
    projection = np.column_stack([camera.matrix, np.zeros(3)])
    return CameraInfo(width=size[0], height=size[1], distortion_model='plumb_bob', D=camera.distortion[:5].tolist(),
                      K=camera.matrix.ravel().tolist(), P=projection.ravel().tolist(), R=np.eye(3).ravel().tolist())


class FakeCamera:
    """Publishes the present ``image`` and ``info`` (None: nothing), with stamps of ``clock``, until stop()."""

    def __init__(self, topic='camera_image', info_topic='camera_info', frame=FRAME, rate=20.0, kind=Image):
        self.image = self.info = None
        self.clock = rospy.Time.now
        self._frame, self._period, self._compressed = frame, 1.0 / rate, kind is CompressedImage
        self.images = rospy.Publisher(topic, kind, queue_size=1, tcp_nodelay=True)
        self._infos = rospy.Publisher(info_topic, CameraInfo, queue_size=1, tcp_nodelay=True)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._publish, daemon=True)
        self._thread.start()

    def show(self, *placed, camera=CAMERA):
        """Show markers from now on, with the camera_info that belongs to them."""
        shown = picture(*placed, camera=camera)
        self.image = images.to_compressed(shown) if self._compressed else images.to_image(shown)
        self.info = camera_info(camera)
        return self

    def stop(self):
        """Stop publishing, and unregister the topics."""
        self._stopped.set()
        self._thread.join()
        self.images.unregister()
        self._infos.unregister()

    def _publish(self):
        while not self._stopped.wait(self._period):
            for publisher, message in ((self._infos, self.info), (self.images, self.image)):
                if message is not None:
                    message = copy.copy(message)
                    message.header = copy.copy(message.header)
                    message.header.stamp, message.header.frame_id = self.clock(), self._frame
                    publisher.publish(message)


class TrackerCase(unittest.TestCase):
    """A test with a tracker that has been started."""

    tracker = TRACKER

    def camera(self, **options):
        """Return a FakeCamera that ends with the test."""
        made = FakeCamera(**options)
        self.addCleanup(made.stop)
        return made

    def collected(self, topic='ar_pose_marker', kind=AlvarMarkers):
        """Return the Collected messages of a topic."""
        made = Collected(topic, kind)
        self.addCleanup(made.subscriber.unregister)
        return made

    def log(self):
        """Return the NodeLog of the tracker."""
        return NodeLog(self.tracker)

    def cubes(self):
        return self.collected('visualization_marker', Marker)

    def enabler(self):
        """Return a function (bool) that publishes on ~enable_detection."""
        publisher = rospy.Publisher(f'{self.tracker}/enable_detection', Bool, queue_size=1)
        until(publisher.get_num_connections, 'a subscriber of enable_detection')
        return publisher.publish

    def next_with(self, poses, *ids):
        """Return the next AlvarMarkers that have exactly these ids."""
        return poses.next(lambda message: sorted(m.id for m in message.markers) == sorted(ids), f'markers {ids}')

    def status(self, fits, what):
        """Return {key: value} of the first diagnostics whose DiagnosticStatus fits; '' is its message."""
        array = self.collected('/diagnostics', DiagnosticArray).next(
            lambda message: message.status[0].name == f'{self.tracker[1:]}: markers' and fits(message.status[0]), what)
        return {'': array.status[0].message, **{entry.key: entry.value for entry in array.status[0].values}}

    def assert_poses(self, message, placed=PLACED, camera_pose=AT_THE_CAMERA, frame=FRAME):
        """Assert that AlvarMarkers are those in the image; ``camera_pose``: rotation, translation in their frame."""
        self.assertEqual(sorted(placed), sorted(m.id for m in message.markers))
        self.assertEqual(frame, message.header.frame_id)
        rotation, translation = camera_pose
        for marker in message.markers:
            shown = placed[marker.id]
            for header in (marker.header, marker.pose.header):
                self.assertEqual((frame, message.header.stamp), (header.frame_id, header.stamp))
            self.assert_pose(marker.pose.pose, rotation @ shown.rotation, rotation @ shown.position + translation,
                             np.linalg.norm(shown.position), marker.id)
            self.assertTrue(51 <= marker.confidence <= 100, f'{marker.id}: {marker.confidence}')

    def assert_pose(self, message, rotation, position, distance=None, name=''):
        """Assert a geometry_msgs/Pose or Transform seen from a distance [m]; without one: seen from the origin."""
        distance = distance or np.linalg.norm(position)
        if isinstance(message, Pose):
            message = Transform(message.position, message.orientation)
        turned, moved = matrix_of(message)
        self.assertLess(np.linalg.norm(moved - position), POSITION_TOLERANCE * distance, f'{name}: {moved} {position}')
        self.assertLess(rotations.angle_between(turned, rotation), ANGLE_TOLERANCE, f'{name}:\n{turned}\n{rotation}')


def stays_away(collected, seconds=0.6):
    """Return whether no message arrives on a Collected topic for ``seconds``, several periods of the tracker."""
    before, end = len(collected.messages), time.monotonic() + seconds
    while time.monotonic() < end and len(collected.messages) == before:
        time.sleep(0.01)
    return len(collected.messages) == before

