"""The node gazebo_cameras: the images of all cameras in the world of gazebo_ros, which starts it with the first one.

It subscribes to ``~scene`` and ``~robots`` of the simulator ``~server``, and renders only topics with subscribers.

Threading contract: the thread of the subscription to ``robots`` renders. Its queue holds one message, so that a slow
machine skips images instead of falling behind. Another thread stores the scene, in one assignment.
"""
from __future__ import annotations

import json
from typing import Any, Mapping

import cv2
import rosgraph.names
import rospy
from geometry_msgs.msg import Transform, TransformStamped
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from gazebo_ros.core.robots import Camera, Mount
from gazebo_ros.robot_topics import Schedule, prefixed
from kinematic_core.worlds import camera as pinhole
from kinematic_core.worlds import world_format
from kinematic_core.worlds.floor_plan import Cylinder, FloorPlan
from kinematic_core.worlds.planar import Pose2D, compose
from rospy_support import nodes
from rospy_support.parameters import Number, Table, Text
from rospy_support.rotations import yaw_of
from rospy_support.topics import Publisher
from sim_ros.camera_topics import CameraTopics, camera_info
from sim_scene.renderer import Renderer

NAME = 'gazebo_cameras'
PARAMETERS = Table(Text('~server', '/gazebo'), Number('~gamma', pinhole.GAMMA, *pinhole.GAMMAS), run_only=True)


class CamerasNode:
    """Publishes the images of all cameras."""

    def __init__(self) -> None:
        server, self._gamma = PARAMETERS.read('~server', '~gamma')
        self._scene: tuple[FloorPlan, dict[str, Any], list[_Camera]] | None = None  # plan, bodies and _Cameras
        self._cameras: dict[tuple[str, Camera, str], _Camera] = {}  # (model, camera, prefix)
        rospy.Subscriber(f'{server}/scene', String, self._on_scene, queue_size=1)
        rospy.Subscriber(f'{server}/robots', TFMessage, self._on_robots, queue_size=1, tcp_nodelay=True)

    def _on_scene(self, message: String) -> None:
        scene = json.loads(message.data)
        plan = world_format.parse(scene['plan'])
        cameras: dict[tuple[str, Camera, str], _Camera] = {}
        for model, fields, prefix in scene['cameras']:
            camera = Camera(*fields)
            camera = camera._replace(mount=Mount(*camera.mount),
                                     depth=(camera.depth[0], camera.depth[1]) if camera.depth else None)
            key = (model, camera, prefix)
            known = key in self._cameras
            cameras[key] = self._cameras.pop(key) if known else _Camera(model, camera, prefix, self._gamma)
        for gone in self._cameras.values():
            gone.close()
        self._cameras = cameras
        self._scene = plan, scene['bodies'], list(cameras.values())

    def _on_robots(self, message: TFMessage) -> None:
        if self._scene is None:
            return
        plan, bodies, cameras = self._scene
        poses = {transform.child_frame_id: transform for transform in message.transforms}
        for camera in cameras:
            transform = poses.get(camera.model)
            if transform is not None and camera.due(transform.header.stamp):
                camera.publish(transform, _with_others(plan, bodies, poses, camera.model))


class _Camera:
    """The topics of one camera."""

    def __init__(self, model: str, camera: Camera, prefix: str, gamma: float) -> None:
        self.model, self._camera, self._gamma = model, camera, gamma
        self._schedule = Schedule(camera.rate)
        self._plan: FloorPlan | None = None
        self._renderer: Renderer | None = None
        lens = pinhole.PinholeCamera(camera.width, camera.height, camera.field)
        colour, infos = self._publisher(camera.image, Image), [camera.info]
        depths, points = [], None
        if camera.depth:
            infos.append(camera.depth_info)
            depths.append(self._publisher(camera.depth_image, Image))
            points = self._publisher(camera.points, PointCloud2)
        self._topics = CameraTopics(camera_info(prefixed(prefix, camera.frame), lens), 'rgb8', colour,
                                    [self._publisher(topic, CameraInfo) for topic in infos], depths, points)
        self.close = self._topics.close

    def due(self, stamp: rospy.Time) -> bool:
        """Return whether an image is due at a time."""
        return self._schedule.due(stamp.to_sec())

    def publish(self, transform: TransformStamped, plan: FloorPlan) -> None:
        """Publish the topics with subscribers, for a robot whose centre is at ``transform`` in a FloorPlan."""
        self._topics.publish(transform.header.stamp, lambda: (self._current_renderer(plan),
                                                              self._pose(transform.transform)))

    def _current_renderer(self, plan: FloorPlan) -> Renderer:
        if self._renderer is None or plan != self._plan:
            camera = self._camera
            self._renderer = Renderer(plan, camera.width, camera.height, camera.field,
                                      depth_range=camera.depth or (pinhole.DEPTH_NEAR, pinhole.DEPTH_FAR),
                                      gamma=self._gamma)
            self._plan = plan
        return self._renderer

    def _publisher(self, topic: str, kind: type) -> Publisher:
        namespace = '/' + self._camera.namespace.strip('/')
        return Publisher(rosgraph.names.ns_join(namespace, topic), kind, queue_size=1)

    def _pose(self, centre: Transform) -> tuple[float, float, float, float]:
        """Return (x, y, z, yaw) of the camera in the world."""
        mount, at = self._camera.mount, centre.translation
        pose = compose(Pose2D(at.x, at.y, yaw_of(centre.rotation)), Pose2D(mount.x, mount.y, mount.yaw))
        return pose.x, pose.y, mount.z, pose.yaw


def _with_others(plan: FloorPlan, bodies: Mapping[str, Any], poses: Mapping[str, TransformStamped],
                 own: str) -> FloorPlan:
    """Return the plan with the bodies of all robots but one."""
    others = tuple(Cylinder(f'robot {name}', poses[name].transform.translation.x, poses[name].transform.translation.y,
                            radius, height, 0.0, tuple(colour))
                   for name, (radius, height, colour) in bodies.items() if name != own and name in poses)
    return plan._replace(cylinders=(*plan.cylinders, *others)) if others else plan


def main() -> None:
    cv2.setNumThreads(1)  # more threads take more processor time, and hardly less wall time
    nodes.init_node(NAME, PARAMETERS)
    CamerasNode()
    rospy.spin()
