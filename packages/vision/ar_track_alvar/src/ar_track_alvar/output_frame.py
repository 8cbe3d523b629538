"""Look up the pose of the camera in the output frame, by tf2, without waiting."""
import numpy as np
import rospy
import tf2_ros
import yaml

from ar_track_alvar.conversions import MARKER_FRAME, matrix_of

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
