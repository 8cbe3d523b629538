"""Publish the markers in an image: tf and cubes in the camera's frame at once, poses once the transform is known.

tf goes first, so that a callback of ar_pose_marker can ask it for the markers at the stamp of the message.

Threading contract: one thread uses a Report.
"""
import time
from collections import deque
from dataclasses import dataclass

import numpy as np
import rospy
import tf2_ros
import yaml
from ar_track_alvar_msgs.msg import AlvarMarkers
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

from ar_track_alvar import conversions
from ar_track_alvar.conversions import MARKER_FRAME, matrix_of
from rospy_support.topics import LatestPublisher

RETRY = 0.005  # [s] between two lookups of a missing transform
IDENTITY = np.eye(3), np.zeros(3)


class TransformMissing(Exception):
    """There is no transform for an image; the text says why and which frames there are."""


class OutputFrame:
    """Looks up the camera's pose in a frame; subscribes to tf only if that is not the camera's own frame.

    It uses the transform at the stamp of the image. Until that arrives, it returns None, and the caller asks again. On
    the last try, it uses the newest transform, if that is at most ``tolerance`` [s] older than the image.
    """

    def __init__(self, frame, tolerance):
        self.frame, self.tolerance = frame, tolerance
        self._buffer = self._listener = None

    def camera_pose(self, camera_frame, stamp, last_try):
        """Return (rotation (3, 3), translation (3,) [m]) or None (unknown); on the last try raise TransformMissing."""
        if camera_frame == self.frame:
            return IDENTITY
        if not camera_frame:
            raise TransformMissing('the images have no frame_id; set it in the camera driver')
        if self._buffer is None:
            self._buffer = tf2_ros.Buffer(debug=False)
            self._listener = tf2_ros.TransformListener(self._buffer)
        try:
            return matrix_of(self._buffer.lookup_transform_core(self.frame, camera_frame, stamp).transform)
        except tf2_ros.TransformException as error:
            return self._newest(camera_frame, stamp, error) if last_try else None

    def clear(self):
        """Forget the transforms: time has jumped back."""
        if self._buffer is not None:
            self._buffer.clear()

    def _newest(self, camera_frame, stamp, reason):
        try:
            newest = self._buffer.lookup_transform_core(self.frame, camera_frame, rospy.Time())
            if 0.0 <= (stamp - newest.header.stamp).to_sec() <= self.tolerance:
                return matrix_of(newest.transform)
        except tf2_ros.TransformException:
            pass
        known = ', '.join(sorted(self._frames())) or 'none, as no node publishes tf'
        raise TransformMissing(f"no transform from the camera's frame {camera_frame} to {self.frame}: "
                               f'{str(reason).rstrip(" .")}. Frames that exist: {known}')

    def _frames(self):
        """Return the frames that tf knows, without those of the markers, which this node publishes."""
        frames = yaml.safe_load(self._buffer.all_frames_as_yaml())
        if not isinstance(frames, dict):  # it is a text that says that there are none
            return set()
        frames = {name: frame for name, frame in frames.items() if not name.startswith(MARKER_FRAME)}
        return set(frames) | {frame['parent'] for frame in frames.values()}


@dataclass
class Waiting:
    """The poses of an image whose transform is not known yet; ``arrival``, ``deadline`` [s, monotonic]."""

    arrival: float
    deadline: float
    header: Header
    markers: list


class Report:
    """Publishes ar_pose_marker, visualization_marker and tf."""

    def __init__(self, frame, tolerance, statistics, complain):
        """``frame``: of ar_pose_marker; ``tolerance`` [s]: see OutputFrame; ``complain(kind, text)`` reports problems.

        """
        self.output = OutputFrame(frame, tolerance)
        self._statistics, self._complain = statistics, complain
        self._waiting = deque()
        self._poses = LatestPublisher('ar_pose_marker', AlvarMarkers)
        self._cubes = LatestPublisher('visualization_marker', Marker)
        self._transforms = LatestPublisher('/tf', TFMessage)  # written before publish() returns

    @property
    def retry(self):
        """Return the time [s] until flush() should be called again; None if nothing waits."""
        return RETRY if self._waiting else None

    def publish(self, arrival, header, markers):
        """Publish the MarkerPoses of an image with this header that arrived at ``arrival`` [s, monotonic]."""
        header = Header(stamp=header.stamp, frame_id=header.frame_id.lstrip('/'))  # tf2 accepts no leading /
        deadline = time.monotonic() + self.output.tolerance
        self._waiting.append(Waiting(arrival, deadline, header, [m for m in markers if m.reported]))
        if header.frame_id and self._transforms.wanted():
            self._send_transforms(header, markers)
        self.flush()
        if header.frame_id and self._cubes.wanted():
            for marker in markers:
                self._cubes.publish(conversions.rviz_marker_of(marker, header))

    def flush(self):
        """Publish poses that have waited for their transform, in order; report missing transforms."""
        while self._waiting:
            first = self._waiting[0]
            try:
                pose = self.output.camera_pose(first.header.frame_id, first.header.stamp,
                                               last_try=time.monotonic() >= first.deadline)
                if pose is None:
                    return
                self._publish_poses(first, first.markers, pose)
            except TransformMissing as missing:
                self._complain('transform', str(missing))
                self._statistics.missing_transforms += len(first.markers)
                self._publish_poses(first, [], None)
            self._waiting.popleft()

    def clear(self):
        """Forget waiting poses and transforms, because time has jumped back."""
        self._waiting.clear()
        self.output.clear()

    def _publish_poses(self, waiting, markers, pose):
        header = Header(stamp=waiting.header.stamp, frame_id=self.output.frame)
        self._poses.publish(AlvarMarkers(header, [conversions.alvar_marker_of(m, header, *pose) for m in markers]))
        self._statistics.published(time.monotonic() - waiting.arrival)

    def _send_transforms(self, header, markers):
        reported = {}  # if several markers have one id, tf gets the one with the highest confidence
        for marker in sorted(markers, key=lambda m: m.confidence):
            if marker.reported:
                reported[marker.id] = marker
        if reported:
            self._transforms.publish(TFMessage([conversions.transform_of(m, header) for m in reported.values()]))
