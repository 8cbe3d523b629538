"""The node robotont_gazebo: one Robotont in its world, stepped by a SimulatorClock.

Threading contract: the main thread steps: it answers all services that were called since the last step, moves the robot
and publishes. Messages on cmd_vel arrive in rospy's threads, which change the world under the lock of ``_shared``. The
camera is a separate node (camera_node.py), because images would delay the steps.
"""
from __future__ import annotations

import contextlib
import os
import socket
from typing import Any

import rospkg
import rospy
from geometry_msgs.msg import PoseArray, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState, LaserScan
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from kinematic_core.worlds import world_format
from kinematic_core.worlds.floor_plan import LARGEST
from kinematic_core.worlds.frames import LIDAR_X, LIDAR_Z, ahead, frames
from kinematic_core.worlds.omni import Limits
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.robot_world import DT, SCAN_NOISE, WATCHDOG, RobotWorld
from plain_support import InvalidInput
from robotont_gazebo.core.models import ROBOT, Models
from robotont_gazebo.srv import MoveMarker, MoveMarkerResponse, SetPose, SetPoseResponse
from rospy_support import parameters, reachability
from rospy_support.parameters import Number, Table, Text
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher, Publisher
from sim_ros import clock, launch_parameters, recording
from sim_ros import robotont_messages as messages
from sim_ros.clock import SimulatorClock, init_simulator, seeded_random
from sim_ros.gazebo_services import GazeboServices
from sim_ros.parent_link import ParentLink
from sim_ros.recording import RecordedWorld
from sim_ros.single_world import WORLD, require_alone
from sim_scene import worlds

NAME = 'robotont_gazebo'
MODELS = ('robotont_gazebo_nuc', 'robotont_gazebo_lidar', 'robotont_gazebo_basic')
LIDAR_MODEL = 'robotont_gazebo_lidar'
ODOMETRY_STEPS = round(1.0 / (messages.ODOMETRY_RATE * DT))  # 4
SCAN_STEPS = round(1.0 / (messages.SCAN_RATE * DT))  # 3
WARNING_PERIOD = 1.0  # [s] of wall time between two warnings about refused velocities
RECORDED = ('x', 'y', 'theta')  # columns of a recording: the robot's true pose
NEVER, NONE = 'never', 'none'
LIMITS = [Number('~max_speed', NONE, 0.01, 10.0, 'm/s', NONE),
          Number('~max_turn_speed', NONE, 0.01, 50.0, 'rad/s', NONE),
          Number('~max_wheel_speed', NONE, 0.1, 1000.0, 'rad/s', NONE),
          Number('~max_acceleration', NONE, 0.01, 1000.0, 'm/s^2', NONE),
          Number('~max_turn_acceleration', NONE, 0.01, 1000.0, 'rad/s^2', NONE),
          Number('~max_wheel_acceleration', NONE, 0.1, 10000.0, 'rad/s^2', NONE)]  # as in omni.Limits
PARAMETERS = Table(
    Text('~world', 'empty'), Text('~model', MODELS[0], MODELS), Number('~x', 0.0, -LARGEST, LARGEST, 'm'),
    Number('~y', 0.0, -LARGEST, LARGEST, 'm'), Number('~yaw', 0.0, -LARGEST, LARGEST, 'rad'),
    Text('~frame_prefix', ''), Number('~watchdog', WATCHDOG, 0.05, 3600.0, 's', NEVER), *LIMITS,
    Number('~odom_slip', 0.0, 0.0, 0.9), Number('~odom_noise', 0.0, 0.0, 1.0, 'm'),
    Number('~scan_noise', SCAN_NOISE, 0.0, 1.0, 'm'), launch_parameters.NAMES, clock.SEED, recording.RECORD,
    clock.PARAMETERS, run_only=True)


class RobotontNode:
    """robotont_gazebo's interface on a RobotWorld."""

    def __init__(self, connection: socket.socket | None = None) -> None:
        """Read the parameters and register everything. Call ``init_simulator`` first.

        ``connection``: a socket for a ParentLink.
        """
        self._parent = ParentLink(connection, carry=self._carry, move=self._move_when_free) if connection else None
        self._clock = SimulatorClock(DT, self._parent)
        self._refusals = WallThrottle(WARNING_PERIOD)
        self._stamp, self._warned_of_watchdog = rospy.Time(), False
        self._moves: list[tuple[str, Pose2D]] = []  # (name of a panel, Pose2D) that the parent wants
        model, prefix = PARAMETERS.read('~model', '~frame_prefix')
        self._frames = frames(prefix)
        numbers = seeded_random()
        self._world = _read_world(numbers.getrandbits(64))
        self._shared = RecordedWorld(self._world, RECORDED, lambda pose: [f'{value:.9g}' for value in pose],
                                     lambda refusal: rospy.logwarn('Refused a service call: %s', refusal))
        self._shared.record_if_asked()
        self._scanner = None
        if model == LIDAR_MODEL:
            from kinematic_core.worlds import rays  # numpy is loaded only where it is needed
            self._rays = rays
            noise = PARAMETERS['~scan_noise'].read()
            self._scanner = rays.LaserScanner(self._world.plan, LIDAR_Z, noise, numbers.getrandbits(64))
            self._scan = LatestPublisher('scan', LaserScan)
        self._odometry = LatestPublisher('odom', Odometry)
        self._truth = LatestPublisher('~ground_truth', Odometry)
        self._transform = LatestPublisher('/tf', TFMessage)
        self._joints = LatestPublisher('joint_states', JointState)
        self._plan = Publisher('~world', String, latch=True, queue_size=1)
        self._plan.publish(world_format.to_json(self._world.plan))
        self._moving = LatestPublisher('~moving_panels', PoseArray) if self._world.plan.moving() else None
        self._start = self._world.pose, self._world.plan
        self._models = Models(self._world)
        self._gazebo = GazeboServices(f'{WORLD}/', self._clock, self._shared, self._models, self._place, self._reset)
        self._clock.services.add('~set_pose', SetPose, self._set_pose)
        self._clock.services.add('~move_marker', MoveMarker, self._move_marker)
        rospy.Subscriber('cmd_vel', Twist, self._command, queue_size=1, tcp_nodelay=True)
        parameters.log_effective()

    def run(self) -> None:
        try:
            self._clock.run(self._step)
        finally:
            self._shared.end_recording()

    def _step(self) -> None:
        with self._shared.lock:
            world = self._world
            world.step()
            self._make_moves()
            self._shared.record_step(world.pose)
            if self._parent:
                self._parent.moved(world.steps, {ROBOT: world.pose})
            self._update_stamp()
            if world.timed_out and not self._warned_of_watchdog:
                self._warned_of_watchdog = True
                rospy.logwarn('No message on %s for %g s: the robot stops. It will do so again without a '
                              'warning. Publish continuously (10 Hz or more), or set ~watchdog.',
                              rospy.resolve_name('cmd_vel'), world.watchdog)
            self._gazebo.publish()
            every = self._parent.every if self._parent else 1
            if world.steps % max(ODOMETRY_STEPS, every) == 0:
                self._publish_motion()
            if self._scanner and world.steps % max(SCAN_STEPS, every) == 0 and self._scan.wanted():
                ranges = self._scanner.scan(*ahead(world.pose, LIDAR_X), world.pose.yaw)
                self._scan.publish(messages.laser_scan(self._stamp, self._frames.lidar, self._rays, ranges))

    def _update_stamp(self) -> None:
        """Store the stamp of this step. If time has jumped back, stop the robot, because its command is outdated."""
        now = rospy.Time.now()
        if now < self._stamp:
            rospy.logwarn('Time jumped back by %.3f s, from %.3f: the robot stops and waits for a new command.',
                          (self._stamp - now).to_sec(), self._stamp.to_sec())
            self._world.stop()
        self._stamp = now

    def _publish_motion(self) -> None:
        world, frame, stamp = self._world, self._frames, self._stamp
        odometry = world.odometry
        if self._transform.wanted():
            self._transform.publish(messages.transforms(stamp, frame, odometry.pose, world.wheel_angles))
        if self._odometry.wanted():
            variances = messages.odometry_variances(odometry.distance, odometry.noise)
            self._odometry.publish(messages.odometry(stamp, frame.odom, frame.footprint, odometry.pose,
                                                     odometry.twist, variances))
        if self._moving is not None and self._moving.wanted():
            self._moving.publish(messages.panel_poses(stamp, world.plan.at(world.time).moving()))
        if self._truth.wanted():
            self._truth.publish(messages.odometry(stamp, 'world', frame.footprint, world.pose, world.twist))
        if self._joints.wanted():
            self._joints.publish(messages.joint_states(stamp, frame.joints, world.wheel_angles, world.wheel_speeds))

    def _command(self, twist: Twist) -> None:
        try:
            with self._shared.lock:
                velocity = twist.linear.x, twist.linear.y, twist.angular.z
                self._world.command(*velocity)
                self._shared.note('cmd', *velocity, request=twist)
        except InvalidInput as refusal:
            self._refusals.warn('velocity', 'Ignored a message on %s, and the robot stops: %s',
                                rospy.resolve_name('cmd_vel'), refusal)

    def _set_pose(self, request: Any) -> SetPoseResponse:
        with self._shared.change():
            self._put(ROBOT, Pose2D(request.x, request.y, request.yaw), request)
        return SetPoseResponse()

    def _move_marker(self, request: Any) -> MoveMarkerResponse:
        with self._shared.change() as world:
            world.move_panel(request.name, request.x, request.y, request.yaw)
            self._publish_plan()
        return MoveMarkerResponse()

    def _carry(self, x: float, y: float, yaw: float) -> None:
        """Carry the robot to a pose, or beside the obstacles that are there."""
        with self._shared.lock:
            free = self._world.nearest_free(x, y)
            if free is not None:
                self._world.carry(*free, yaw)
                self._shared.note('teleport_absolute', *free, yaw, request=recording.PARENT)

    def _move_when_free(self, name: str, *pose: float) -> None:
        """Move a panel to a pose in the next step in which the robot is not there."""
        with self._shared.lock:
            self._moves.append((name, Pose2D(*pose)))

    def _make_moves(self) -> None:
        for move in list(self._moves):
            with contextlib.suppress(InvalidInput):  # the robot is there
                self._models.put(*move)
                self._moves.remove(move)
                self._publish_plan()
                if self._parent:
                    self._parent.panel_moved(self._world.steps, move[0])

    def _place(self, name: str, pose: Pose2D, frame: str, request: Any) -> None:
        with self._shared.lock:
            self._put(name, self._models.in_world(pose, frame), request)

    def _put(self, name: str, pose: Pose2D, request: Any) -> None:
        """Put a model at a Pose2D; the caller must hold the lock."""
        self._models.put(name, pose)
        if name == ROBOT:
            self._shared.note('teleport_absolute', *pose, request=request)
        else:
            self._publish_plan()

    def _reset(self, request: Any) -> None:
        """Put the robot and all panels where they started."""
        pose, plan = self._start
        with self._shared.change():
            for panel in plan.panels:
                if not panel.path:
                    self._world.move_panel(panel.name, panel.x, panel.y, panel.yaw)
            self._publish_plan()
            self._put(ROBOT, pose, request)

    def _publish_plan(self) -> None:
        """Let scanner and camera see panels where they are now."""
        if self._scanner:
            self._scanner.set_plan(self._world.plan)
        self._plan.publish(world_format.to_json(self._world.plan))


def _read_world(seed: int) -> RobotWorld:
    name, x, y, yaw, watchdog, slip, noise = PARAMETERS.read('~world', '~x', '~y', '~yaw', '~watchdog', '~odom_slip',
                                                             '~odom_noise')
    start, limits = Pose2D(x, y, yaw), Limits(*(limit.read() for limit in LIMITS))
    folder = os.path.join(rospkg.RosPack().get_path(NAME), 'worlds')
    try:
        plan, warnings = worlds.load_world(name, folder)
    except InvalidInput as error:
        raise parameters.ParameterError(f'parameter {rospy.resolve_name("~world")}: {error}') from None
    if warnings:
        rospy.logwarn('%s: %s', name, '; '.join(warnings))
    try:
        return RobotWorld(plan, start, limits, watchdog, slip, noise, seed)
    except InvalidInput as error:
        raise parameters.ParameterError(
            f'parameters {rospy.resolve_name("~x")}, ~y: {error}. Start it somewhere else; launch '
            'files put it at x = -x_pos') from None


def main(connection: socket.socket | None = None) -> None:
    """Run robotont_gazebo; ``connection``: that of a ParentLink."""
    require_alone(NAME, 'odom', WORLD)
    init_simulator(NAME, PARAMETERS)
    reachability.watch()
    launch_parameters.keep('robot_description')
    RobotontNode(connection).run()
