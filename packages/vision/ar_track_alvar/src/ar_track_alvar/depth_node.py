"""individualMarkers: publish the pose of every marker in the coloured point clouds of a depth camera.

The pose is computed from the image and the points together, or without points from the image alone.
"""
import numpy as np
import rospy
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import Marker

from alvar_core.camera import CameraError
from alvar_core.detection import depth
from ar_track_alvar import conversions, settings, start
from ar_track_alvar.core import clouds, command_line
from ar_track_alvar.node import BUFFER, MarkerNode
from rospy_support.parameters import Number, Table
from rospy_support.topics import LatestPublisher

MAX_SHIFT = 4.0  # [px] between a point and its pixel; farther apart, they do not belong together
CHECKED = 8  # rows and columns in which this is checked
REASONS = {depth.NO_DEPTH: 'the cloud has too few points on it (nearer or farther than the depth camera sees, or a '
                           'shiny or very dark surface)',
           depth.NO_PLANE: 'its points do not lie on one plane (something covers it, or it is bent)',
           depth.BENT: 'its paper is bent, which the image measures better'}

DEPTH_NOISE = Number('~depth_noise', depth.NOISE, 0.0001, 0.1, 'm')
INPUT = Table(*(each for each in settings.PARAMETERS if each.name != '~image_transport'))
PARAMETERS = Table(INPUT, settings.FRAME_FROM_MESSAGE, DEPTH_NOISE)


class DepthInput:
    """Mixin that lets a MarkerNode work on clouds; put it before MarkerNode in the bases of a class."""

    noise = depth.NOISE  # [m] of a depth at 1 m
    frame_from_message = False  # poses are published in the frame of the cloud
    _cloud = _header = None  # the core.clouds.Cloud that is being searched, and its header
    planes = {}  # of the cloud: {Detection: depth.Plane}

    def __init__(self, *arguments):
        self._counts = {source: 0 for source in (depth.BOTH, depth.CLOUD, *REASONS)}
        self._points = LatestPublisher('ARmarker_points', Marker)
        super().__init__(*arguments)

    def subscribe(self, callback):
        """Return a Subscriber to the clouds."""
        return rospy.Subscriber('camera_image', PointCloud2, callback, queue_size=1, buff_size=BUFFER,
                                tcp_nodelay=True)

    def grey_of(self, message):
        """Return the grey image of a PointCloud2; raise ImageError."""
        self._cloud, self._header = clouds.Cloud(message), message.header
        if self.frame_from_message:
            self._report.output.frame = message.header.frame_id.lstrip('/')
        return self._cloud.grey()

    def bgr_of(self, _message):
        """Return the colour image of the cloud."""
        return self._cloud.bgr()

    def looks_rectified(self, info):
        """Return whether P of camera_info describes the image: drivers compute clouds from rectified images."""
        return info.P[0] > 0

    def improved(self, detections, camera):
        """Return the Detections with poses computed from image and points together."""
        if detections:
            check_registered(self._cloud, camera)
        found = [self._improve(each, camera) for each in detections]
        self.planes = {each.detection: each.plane for each in found if each.plane is not None}
        return [each.detection for each in found]

    def _improve(self, detection, camera):
        size = self.size_of(detection.id)
        plane = depth.plane_on(self._cloud, detection.corners, self._cloud.shape, self.noise)
        found = depth.measured(detection, size, camera, plane)
        self._counts[found.source] += 1
        if found.source in REASONS:
            self.complain(('depth', found.source), f'The pose of marker {detection.id} comes from the image alone: '
                          f'{REASONS[found.source]}.')
        elif found.source == depth.CLOUD:
            self.complain(('depth', found.source), f'The points of marker {detection.id} contradict the image: they '
                          f'show it {100 * found.size:.1f} cm wide and {np.linalg.norm(found.detection.position):.2f} '
                          f'm away, but its size is set to {100 * size:.1f} cm, which would be '
                          f'{np.linalg.norm(detection.position):.2f} m. Is marker_size the width of the black square? '
                          'The pose follows the points.')
        if self._points.wanted():
            self._points.publish(conversions.points_marker_of(
                detection.id, depth.points_on(self._cloud, detection.corners, self._cloud.shape), self._header))
        return found

    def report_values(self):
        """Return the numbers of poses by their source, for /diagnostics."""
        counts, self._counts = self._counts, dict.fromkeys(self._counts, 0)
        return {'poses from image and points': counts[depth.BOTH],
                'poses from the image alone': sum(counts[reason] for reason in REASONS),
                'poses from the points alone': counts[depth.CLOUD]}


def check_registered(cloud, camera):
    """Raise CameraError unless the points of a Cloud lie on the rays of their pixels."""
    height, width = cloud.shape
    rows, columns = np.arange(CHECKED) * height // CHECKED, np.arange(CHECKED) * width // CHECKED
    strips = [cloud.window(row, row + 1, 0, width)[0] for row in rows.tolist()]
    points = np.array(strips)[:, columns]
    pixels = np.stack(np.meshgrid(columns, rows), -1).astype(float)
    with np.errstate(all='ignore'):
        valid = np.isfinite(points).all(-1) & (points[..., 2] != 0)
        seen = points[..., :2] / points[..., 2:] * camera.focal + camera.centre
    if not valid.any():
        return
    away = float(np.median(np.linalg.norm(seen - camera.to_ideal(pixels), axis=-1)[valid]))
    if not away <= MAX_SHIFT or np.median(points[valid][:, 2]) < 0:
        raise CameraError(f'the points of the cloud are {away:.0f} px away from the pixels that show them: the cloud '
                          'is in another frame than the optical one of this camera, or camera_info is that of '
                          f'another camera; {clouds.REGISTERED}')


class DepthMarkerNode(DepthInput, MarkerNode):
    """Publishes single markers."""

    def __init__(self, read, noise, frame_from_message):
        self.noise, self.frame_from_message = noise, frame_from_message
        super().__init__(read)


def main():
    """Run individualMarkers."""
    start.init_node('individualMarkers', PARAMETERS, example=command_line.DEPTH_EXAMPLE)
    from_message = settings.FRAME_FROM_MESSAGE.read()
    DepthMarkerNode(settings.read(PARAMETERS, from_message), DEPTH_NOISE.read(), from_message).run()
