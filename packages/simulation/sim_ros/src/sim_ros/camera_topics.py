"""The topics of a simulated camera: images, depths, points, and what the lens is."""
from __future__ import annotations

from typing import Any, Callable, Sequence

import rospy
from sensor_msgs.msg import CameraInfo

from kinematic_core.worlds import camera
from rospy_support.images import DEPTH, to_cloud, to_image


def camera_info(frame: str, lens: camera.PinholeCamera) -> CameraInfo:
    """Return the CameraInfo of a PinholeCamera."""
    info = CameraInfo(width=lens.width, height=lens.height, distortion_model='plumb_bob', D=list(camera.DISTORTION),
                      K=lens.matrix(), R=list(camera.RECTIFICATION), P=lens.projection())
    info.header.frame_id = frame
    return info


class CameraTopics:
    """The publishers of a camera; only what has subscribers is rendered."""

    def __init__(self, info: CameraInfo, encoding: str, colour: rospy.Publisher, infos: Sequence[rospy.Publisher],
                 depths: Sequence[rospy.Publisher] = (), points: rospy.Publisher = None) -> None:
        """``info``: a CameraInfo for ``infos``; ``encoding`` of the colour image: bgr8 or rgb8; others are publishers.

        Several may publish the same ``depths``; ``points``: that of a PointCloud2, or None.
        """
        self._info, self._encoding = info, encoding
        self._colour, self._infos, self._depths, self._points = colour, infos, depths, points

    def close(self) -> None:
        for publisher in filter(None, (self._colour, *self._infos, *self._depths, self._points)):
            publisher.unregister()

    def publish(self, stamp: rospy.Time, current: Callable[[], Any]) -> None:
        """Publish what the camera sees.

        ``current()`` returns (Renderer, (x, y, z, yaw) [m, rad] of the camera), or None while there is no world.
        """
        header = self._info.header
        header.stamp = stamp
        for publisher in filter(_wanted, self._infos):
            publisher.publish(self._info)
        wants_colour, wants_points = _wanted(self._colour), _wanted(self._points)
        depths = list(filter(_wanted, self._depths))
        view = current() if wants_colour or depths or wants_points else None
        if view is None:
            return
        renderer, pose = view
        colour: Any = renderer.render(pose, bgr=self._encoding == 'bgr8') if wants_colour or wants_points else None
        if wants_colour:
            self._colour.publish(to_image(colour, self._encoding, header))
        if depths or wants_points:
            depth = renderer.depth(pose)
            message = to_image(depth, DEPTH, header)
            for publisher in depths:
                publisher.publish(message)
            if wants_points:
                self._points.publish(to_cloud(renderer.points(depth), colour, self._encoding, header))


def _wanted(publisher: rospy.Publisher) -> bool:
    return publisher is not None and publisher.get_num_connections() > 0
