"""Convert CameraInfo to cameras of alvar_core, and poses to ROS messages. Works without a running ROS master."""
from dataclasses import dataclass

import genpy
import numpy as np
from ar_track_alvar_msgs.msg import AlvarMarker
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker

from alvar_core import rotations
from alvar_core.camera import Camera, CameraError, FisheyeCamera
from plain_support import LARGEST_MARKER_ID

MARKER_FRAME = 'ar_marker_'  # followed by the id: the tf frame of a marker
LIFETIME = 1.0  # [s] of a cube in rviz
POINT_SIZE = 0.005  # [m] of a point in rviz
THICKNESS = 0.2  # of a cube, as a share of its width
COLOURS = ((0.0, 0.0, 1.0, 1.0), (1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.5, 0.5, 1.0),
           (0.5, 0.5, 0.0, 1.0), (0.5, 0.0, 0.5, 1.0))  # r, g, b, a of the ids 0 to 4, and of all others
MODELS = {'plumb_bob': Camera, 'rational_polynomial': Camera, 'equidistant': FisheyeCamera, 'fisheye': FisheyeCamera}


@dataclass
class MarkerPose:
    """The data published about a marker, or about a bundle.

    ``rotation`` (3, 3) and ``position`` (3,) [m] are in the camera's optical frame; ``confidence``: 0 to 100; ``size``
    [m]: width of the cube in rviz; ``reported``: publish it in ar_pose_marker and tf, not only for rviz; ``namespace``
    and ``colour`` (r, g, b, a, 0 to 1; None: the colour of the id) are for rviz.
    """

    id: int
    rotation: np.ndarray
    position: np.ndarray
    confidence: int
    size: float
    reported: bool = True
    namespace: str = 'basic_shapes'
    colour: tuple = None


def confidence(detection):
    """Return the confidence [%] of a Detection or BundlePose; at most 50 if its orientation is uncertain."""
    percent = 100.0 * min(max(detection.confidence, 0.0), 1.0)
    unsure = detection.ambiguous or getattr(detection, 'doubtful', False)  # only a Detection can be doubtful
    return int(round(percent / 2.0 if unsure else percent))


def numbered(detections):
    """Return the Detections whose ids fit into AlvarMarker.id, sorted by id, and the other ids."""
    fit = [d for d in detections if isinstance(d.id, int) and 0 <= d.id <= LARGEST_MARKER_ID]
    others = [d.id for d in detections if d not in fit]
    return sorted(fit, key=lambda d: d.id), others


def camera_key(info, width, height, rectified):
    """Return all values that camera_of() uses: equal keys mean equal cameras, and NaN is never equal."""
    roi = info.roi
    return (width, height, rectified, info.width, info.height, info.distortion_model, tuple(info.D), tuple(info.K),
            tuple(info.P), info.binning_x, info.binning_y, roi.x_offset, roi.y_offset, roi.width, roi.height)


def camera_of(info, width, height, rectified=False):
    """Return the Camera of images of ``width`` x ``height`` pixels with this CameraInfo; raise CameraError.

    ``rectified``: the images are already undistorted, and P describes them.
    """
    _check_size(info, width, height)
    if rectified:
        matrix = np.reshape(info.P, (3, 4))[:, :3]
        return Camera(_of_window(info, _checked(matrix, 'P')))
    values = np.asarray(info.D, float)
    matrix = _of_window(info, _checked(np.reshape(info.K, (3, 3)), 'K'))
    model = MODELS.get(info.distortion_model)
    if not values.any() and model is not FisheyeCamera:  # a fisheye camera distorts even if D is all zeros
        return Camera(matrix)
    if model is None:
        raise CameraError(f'distortion_model is {info.distortion_model!r}; known are: {", ".join(MODELS)}')
    if model is Camera and values.size > 8 and not values[8:].any():
        values = values[:8]  # the thin prism terms are zero
    return model(matrix, values)


def _checked(matrix, name):
    if not np.all(np.isfinite(matrix)) or matrix[0, 0] <= 0 or matrix[1, 1] <= 0:
        raise CameraError(f'{name} is {np.round(matrix, 3).tolist()}: fx and fy must be above 0 and all must be '
                          'finite; an uncalibrated camera publishes zeros: calibrate it (camera_calibration), or give '
                          'its driver the calibration file')
    return matrix


def _check_size(info, width, height):
    """Raise CameraError unless the CameraInfo is for images of this size; 0 x 0 means any."""
    roi = info.roi
    full = (roi.width, roi.height) if roi.width and roi.height else (info.width, info.height)
    expected = full[0] // max(info.binning_x, 1), full[1] // max(info.binning_y, 1)
    if all(expected) and expected != (width, height):
        raise CameraError(f'the image has {width}x{height} pixels, camera_info is for {expected[0]}x{expected[1]} '
                          f'(width x height {info.width}x{info.height}, roi {roi.width}x{roi.height}, binning '
                          f'{info.binning_x}x{info.binning_y}): they belong to different cameras or modes; calibrate '
                          'in the mode in use, or let the driver set binning and roi')


def _of_window(info, matrix):
    """Return the camera matrix for the region of interest and the binning; whole numbers are pixel centres."""
    matrix = matrix.copy()
    for axis, offset, binning in ((0, info.roi.x_offset, info.binning_x), (1, info.roi.y_offset, info.binning_y)):
        binning = max(binning, 1)
        matrix[axis] /= binning
        matrix[axis, 2] += (0.5 - offset) / binning - 0.5
    return matrix


def transform_of(marker, header):
    """Return the TransformStamped from the camera's frame (of ``header``) to ar_marker_ID."""
    message = TransformStamped(header=header, child_frame_id=f'{MARKER_FRAME}{marker.id}')
    message.transform.translation = Vector3(*marker.position)
    message.transform.rotation = Quaternion(*rotations.quaternion_from_matrix(marker.rotation))
    return message


def rviz_marker_of(marker, header):
    """Return the cube for rviz, in the camera's frame (of ``header``)."""
    message = Marker(header=header, ns=marker.namespace, id=marker.id if marker.id < 2 ** 31 else marker.id - 2 ** 32,
                     type=Marker.CUBE, action=Marker.ADD, lifetime=genpy.Duration.from_sec(LIFETIME))
    message.pose = _pose(marker.rotation, marker.position)
    message.scale = Vector3(marker.size, marker.size, THICKNESS * marker.size)
    message.color = ColorRGBA(*(marker.colour or COLOURS[min(marker.id, len(COLOURS) - 1)]))
    return message


def points_marker_of(number, points, header):
    """Return the Marker for rviz that shows points (N, 3) [m] on marker ``number``, in the frame of ``header``."""
    message = Marker(header=header, ns='3dpts', id=number if number < 2 ** 31 else number - 2 ** 32, type=Marker.POINTS,
                     action=Marker.ADD, lifetime=genpy.Duration.from_sec(LIFETIME))
    message.pose.orientation.w = 1.0
    message.scale = Vector3(POINT_SIZE, POINT_SIZE, 0.0)
    message.color = ColorRGBA(0.0, 1.0, 1.0, 1.0)
    message.points = [Point(*point) for point in points.tolist()]
    return message


def alvar_marker_of(marker, header, rotation, translation):
    """Return the AlvarMarker in the frame of ``header``.

    ``rotation`` (3, 3) and ``translation`` (3,) [m] are the pose of the camera in that frame.
    """
    message = AlvarMarker(header=header, id=marker.id, confidence=marker.confidence)
    message.pose.header = header
    message.pose.pose = _pose(rotation @ marker.rotation, rotation @ marker.position + translation)
    return message


def matrix_of(transform):
    """Return rotation (3, 3) and translation (3,) [m] of a geometry_msgs/Transform."""
    t, q = transform.translation, transform.rotation
    return rotations.matrix_from_quaternion((q.x, q.y, q.z, q.w)), np.array([t.x, t.y, t.z])


def _pose(rotation, position):
    return Pose(Point(*position), Quaternion(*rotations.quaternion_from_matrix(rotation)))
