"""The node robotont_camera: images of the camera of a simulated Robotont.

It subscribes to the simulator's ``ground_truth`` and ``world``, and renders only topics with subscribers.

Threading contract: the thread of the subscription to ``ground_truth`` does everything. Its queue holds one message, so
that a slow machine skips images instead of falling behind. Another thread stores the world, in one assignment, and
a third the poses of panels that move, under ``_arrived``.
"""
from __future__ import annotations

import threading

import cv2
import rospy
from geometry_msgs.msg import Pose, PoseArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, PointCloud2
from std_msgs.msg import String

from kinematic_core.worlds import camera, world_format
from kinematic_core.worlds.floor_plan import FloorPlan
from kinematic_core.worlds.frames import CAMERA_X, CAMERA_Z, ahead, frames
from kinematic_core.worlds.planar import Pose2D
from plain_support import InvalidInput
from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Integer, Number, Table, Text
from rospy_support.rotations import yaw_of
from rospy_support.topics import Publisher
from sim_ros.camera_topics import CameraTopics, camera_info
from sim_ros.robotont_messages import ODOMETRY_RATE
from sim_ros.single_world import require_alone
from sim_scene.renderer import Renderer

NAME = 'robotont_camera'
MOVED_WITHIN = 0.2  # [s] of wall time that a pose of the robot waits for the panels' poses of the same stamp
SIMULATOR = 'robotont_gazebo'
PARAMETERS = Table(Integer('~width', camera.WIDTH, camera.SMALLEST, camera.LARGEST, 'px'),
                   Integer('~height', camera.HEIGHT, camera.SMALLEST, camera.LARGEST, 'px'),
                   Number('~horizontal_fov', camera.HORIZONTAL_FOV, camera.NARROWEST, camera.WIDEST, 'rad'),
                   Number('~rate', ODOMETRY_RATE, 0.1, ODOMETRY_RATE, 'Hz'), Text('~frame_prefix', ''),
                   Number('~depth_near', camera.DEPTH_NEAR, camera.LOWEST_DEPTH, camera.HIGHEST_DEPTH, 'm'),
                   Number('~depth_far', camera.DEPTH_FAR, camera.LOWEST_DEPTH, camera.HIGHEST_DEPTH, 'm'),
                   Number('~gamma', camera.GAMMA, *camera.GAMMAS), run_only=True)


class CameraNode:
    """Publishes colour and depth images, points, and their camera_info."""

    def __init__(self) -> None:
        width, height, fov, rate, self._gamma = PARAMETERS.read(
            '~width', '~height', '~horizontal_fov', '~rate', '~gamma')
        self._lens = camera.PinholeCamera(width, height, fov)
        self._depth_range = _depth_range()
        self._every = max(1, round(ODOMETRY_RATE / rate))
        self._received = 0
        self._renderer: Renderer | None = None
        self._plan: FloorPlan | None = None  # until the simulator has published its world
        self._rendered_plan: FloorPlan | None = None
        frame = frames(*PARAMETERS.read('~frame_prefix')).camera
        self._topics = CameraTopics(
            camera_info(frame, self._lens), 'bgr8',
            Publisher('camera/color/image_raw', Image, queue_size=1),
            [Publisher(f'camera/{kind}/camera_info', CameraInfo, queue_size=1) for kind in ('color', 'depth')],
            [Publisher(f'camera/{name}', Image, queue_size=1) for name in (
                'depth/image_rect_raw', 'aligned_depth_to_color/image_raw')],
            Publisher('camera/depth/points', PointCloud2, queue_size=1))
        self._arrived, self._moved = threading.Condition(), PoseArray()
        rospy.Subscriber(f'{SIMULATOR}/moving_panels', PoseArray, self._on_moved_panels, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber(f'{SIMULATOR}/world', String, self._on_world, queue_size=1)
        rospy.Subscriber(f'{SIMULATOR}/ground_truth', Odometry, self._on_truth, queue_size=1, tcp_nodelay=True)
        parameters.log_effective()

    def _on_world(self, message: String) -> None:
        try:
            self._plan = world_format.parse_json(message.data)
        except (ValueError, InvalidInput) as error:
            rospy.logerr('Ignored a message on %s: %s', rospy.resolve_name(f'{SIMULATOR}/world'), error)

    def _on_truth(self, truth: Odometry) -> None:
        self._received += 1
        if (self._received - 1) % self._every == 0:
            self._topics.publish(truth.header.stamp, lambda: self._view(truth))

    def _view(self, truth: Odometry) -> tuple[Renderer, tuple[float, ...]] | None:
        """Return the Renderer of the world and the pose of the camera; None while there is no world."""
        plan = self._plan
        if plan is None:
            return None
        return self._current_renderer(plan, truth.header.stamp), camera_pose(truth.pose.pose)

    def _on_moved_panels(self, poses: PoseArray) -> None:
        with self._arrived:
            self._moved = poses
            self._arrived.notify_all()

    def _current_renderer(self, plan: FloorPlan, stamp: rospy.Time) -> Renderer:
        moving = plan.moving()
        if moving:
            with self._arrived:
                self._arrived.wait_for(lambda: self._moved.header.stamp >= stamp, MOVED_WITHIN)
                poses = self._moved.poses
            plan = plan.with_moved([(pose.position.x, pose.position.y, yaw_of(pose.orientation)) for pose in poses])
        if moving or self._renderer is None or plan is not self._rendered_plan:
            lens, self._rendered_plan = self._lens, plan
            self._renderer = Renderer(plan, lens.width, lens.height, lens.horizontal_fov,
                                      depth_range=self._depth_range, gamma=self._gamma)
        return self._renderer


def _depth_range() -> tuple[float, float]:
    """Return ~depth_near and ~depth_far [m]; raise ParameterError if they are not a range."""
    try:
        return camera.require_range(*PARAMETERS.read('~depth_near', '~depth_far'))
    except InvalidInput as error:
        raise parameters.ParameterError(f'parameters {rospy.resolve_name("~depth_near")} and '
                                        f'{rospy.resolve_name("~depth_far")}: {error}') from None


def camera_pose(pose: Pose) -> tuple[float, float, float, float]:
    """Return the camera's (x, y, z, yaw) [m, rad] of a robot's geometry_msgs/Pose."""
    yaw = yaw_of(pose.orientation)
    return (*ahead(Pose2D(pose.position.x, pose.position.y, yaw), CAMERA_X), CAMERA_Z, yaw)


def main() -> None:
    require_alone(NAME, 'camera/color/image_raw')
    cv2.setNumThreads(1)  # with more threads, an image takes more processor time, and hardly less wall time
    nodes.init_node(NAME, PARAMETERS)
    reachability.watch()
    CameraNode()
    rospy.spin()
