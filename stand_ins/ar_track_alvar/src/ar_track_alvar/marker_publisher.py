"""What the tracker publishes of a picture: tf and cubes in the camera's frame at once, poses when tf is known.

One thread uses a Report.
"""
import time
from collections import deque
from dataclasses import dataclass

from ar_track_alvar_msgs.msg import AlvarMarkers
from std_msgs.msg import Header
from tf2_ros import TransformBroadcaster
from visualization_msgs.msg import Marker

from ar_track_alvar import conversions
from ar_track_alvar.output_frame import OutputFrame, TransformMissing
from rospy_support.topics import LatestPublisher

RETRY = 0.005  # [s] between two looks for a transform that was not there


@dataclass
class Waiting:
    """The poses of a picture whose transform is not known yet; arrival, deadline: monotonic [s]."""

    arrival: float
    deadline: float
    header: Header
    markers: list


class Report:
    """Publishes ar_pose_marker, visualization_marker and tf."""

    def __init__(self, frame, tolerance, statistics, complain):
        """frame: of ar_pose_marker; tolerance [s]: see OutputFrame; complain(kind, text): say what is wrong."""
        self.output = OutputFrame(frame, tolerance)
        self._statistics, self._complain = statistics, complain
        self._waiting = deque()
        self._poses = LatestPublisher('ar_pose_marker', AlvarMarkers)
        self._cubes = LatestPublisher('visualization_marker', Marker)
        self._broadcaster = TransformBroadcaster()

    @property
    def retry(self):
        """Seconds until flush() should be called again, None if nothing waits."""
        return RETRY if self._waiting else None

    def publish(self, arrival, header, markers):
        """Publish the MarkerPoses of a picture with this header that came at ``arrival`` (monotonic, s)."""
        header = Header(stamp=header.stamp, frame_id=header.frame_id.lstrip('/'))  # tf2 takes no leading /
        deadline = time.monotonic() + self.output.tolerance
        self._waiting.append(Waiting(arrival, deadline, header, [m for m in markers if m.reported]))
        self.flush()
        if header.frame_id:
            self._in_camera_frame(header, markers)

    def flush(self):
        """Publish what has waited for its transform, in order, and complain where there is none."""
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
        """Forget waiting poses and transforms: time started again."""
        self._waiting.clear()
        self.output.clear()

    def _publish_poses(self, waiting, markers, pose):
        header = Header(stamp=waiting.header.stamp, frame_id=self.output.frame)
        self._poses.publish(AlvarMarkers(header, [conversions.alvar_marker_of(m, header, *pose) for m in markers]))
        self._statistics.published(time.monotonic() - waiting.arrival)

    def _in_camera_frame(self, header, markers):
        reported = {}  # of several markers with one id tf gets the surest: a frame has one place
        for marker in sorted(markers, key=lambda m: m.confidence):
            if marker.reported:
                reported[marker.id] = marker
        if reported:
            self._broadcaster.sendTransform([conversions.transform_of(m, header) for m in reported.values()])
        for marker in markers:
            self._cubes.publish(conversions.rviz_marker_of(marker, header))
