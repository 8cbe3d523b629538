"""The node gazebo: models and robots in one world, stepped by a SimulatorClock, behind the names of Gazebo.

Threading contract: the main thread steps: it answers all services that were called since the last step, moves the
robots and publishes. Commands and messages on ``~set_model_state`` arrive in rospy's threads, which change the world
under ``_lock``, that of ``_shared``. Topics of a new robot are registered in the thread of FrameServices, so that no
step waits for them. Cameras are rendered by another process (cameras.py), which is started with the first one.
"""
from __future__ import annotations

import json
import os
import re
import socket
import subprocess
import sys
from functools import partial
from typing import Any, Callable, Generator, Iterable, Sequence
from xml.etree.ElementTree import Element

import numpy as np
import roslib.packages
import rospkg
import rospy
from gazebo_msgs.msg import LinkState, LinkStates
from gazebo_msgs.srv import (
    DeleteModel,
    DeleteModelResponse,
    GetLinkState,
    GetLinkStateResponse,
    GetModelProperties,
    GetModelPropertiesResponse,
    GetPhysicsProperties,
    GetPhysicsPropertiesResponse,
    SetPhysicsProperties,
    SetPhysicsPropertiesResponse,
    SpawnModel,
    SpawnModelResponse,
)
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from gazebo_ros import command_line
from gazebo_ros.core import model_files
from gazebo_ros.core.gazebo_world import FLOOR, GazeboWorld
from gazebo_ros.core.robots import Robot
from gazebo_ros.core.vehicle import DT
from gazebo_ros.robot_topics import RobotTopics, Schedule
from kinematic_core.worlds import world_format
from kinematic_core.worlds.planar import Pose2D
from plain_support import InvalidInput, processes
from rospy_support import parameters, reachability
from rospy_support.parameters import Table
from rospy_support.topics import LatestPublisher, Publisher
from sim_ros import clock, launch_parameters, recording
from sim_ros.clock import SimulatorClock, init_simulator, seeded_random
from sim_ros.gazebo_services import GazeboServices, flat, pose_and_twist
from sim_ros.parent_link import ParentLink
from sim_ros.recording import RecordedWorld
from sim_ros.robotont_messages import base_transform
from sim_ros.single_world import WORLD, require_alone

NAME = 'gazebo'
PARAMETERS = Table(launch_parameters.NAMES, clock.SEED, recording.RECORD, clock.PARAMETERS, run_only=True)
RECORDED = ('x', 'y', 'theta')  # columns of a recording: the true pose of the robot that was added first
CAMERA_RATE = 30.0  # [Hz] at which cameras are told where the robots are
CAMERAS = 'gazebo_cameras'
SPAWNED = 'SpawnModel: Successfully spawned entity'
NOT_OF_A_NAME = re.compile(r'\W')
PACKAGE = re.compile(r'(?:package|model)://([\w.-]+)/')


class GazeboNode:
    """Gazebo's interface on a GazeboWorld."""

    def __init__(self, world: GazeboWorld, warnings: Iterable[str], connection: socket.socket | None = None,
                 paused: bool = False) -> None:
        """Register everything. Call ``init_simulator`` first.

        ``connection``: a socket for a ParentLink; ``paused``: start paused, whatever the parameter says.
        """
        self._parent = ParentLink(connection) if connection else None
        self._clock = SimulatorClock(DT, self._parent, paused, bool(rospy.get_param(clock.USE_SIM_TIME, True)))
        self._numbers = seeded_random()
        self._world = world
        self._shared = RecordedWorld(world, RECORDED, _fields,
                                     lambda refusal: rospy.logwarn('Refused a service call: %s', refusal))
        self._shared.record_if_asked()
        self._lock = self._shared.lock
        self._topics: dict[str, RobotTopics] = {}  # model: its RobotTopics
        self._elements: dict[str, Element] = {}  # model: the Element of its SDF
        self._cameras: subprocess.Popen[bytes] | None = None  # the process
        self._camera_schedule = Schedule(CAMERA_RATE)
        self._transform = LatestPublisher('/tf', TFMessage)
        self._link_states = LatestPublisher('~link_states', LinkStates)
        self._robots = LatestPublisher('~robots', TFMessage)
        self._scene = Publisher('~scene', String, latch=True, queue_size=1)
        self._offer()
        self._gazebo = GazeboServices('~', self._clock, self._shared, world, self._place, self._reset)
        rospy.on_shutdown(self._end_cameras)
        for warning in warnings:
            rospy.logwarn('%s', warning)
        self._publish_scene()
        parameters.log_effective()

    def add_from_world(self, found: Iterable[model_files.Found]) -> None:
        """Add the models of a world file, a list of model_files.Found."""
        for name, element, pose, folder in found:
            if name == FLOOR:  # every world has one here
                continue
            try:
                warnings = self._world.add(element, name, pose, '', folder)
                self._elements[name] = element
                if name in self._world.vehicles:  # warnings about other models were logged when the world was read
                    self._report(name, warnings)
                    self._topics[name] = self._make_topics(name)
            except InvalidInput as refusal:
                rospy.logwarn('The model %s is left out: %s', name, refusal)
        self._publish_scene()

    def add_robot(self, name: str, description: str, pose: Pose2D) -> None:
        """Add a robot, a URDF, at a Pose2D, with topics in the namespace of its name; raise InvalidInput."""
        self._elements[name] = model_files.parse(description)
        self._report(name, self._world.add(self._elements[name], name, _matrix(pose, 0.0), name))
        self._topics[name] = self._make_topics(name)
        self._publish_scene()

    def run(self) -> None:
        try:
            self._clock.run(self._step)
        finally:
            self._shared.end_recording()

    def _offer(self) -> None:
        services = self._clock.services
        services.add('~spawn_urdf_model', SpawnModel, self._spawn)
        services.add('~spawn_sdf_model', SpawnModel, self._spawn)
        services.add('~delete_model', DeleteModel, self._delete)
        services.add('~get_link_state', GetLinkState, self._get_link_state)
        services.add('~get_model_properties', GetModelProperties, self._get_model_properties)
        services.add('~get_physics_properties', GetPhysicsProperties, self._get_physics)
        services.add('~set_physics_properties', SetPhysicsProperties, self._set_physics)

    def _step(self) -> None:
        now = rospy.Time.now()
        with self._lock:
            world = self._world
            world.step()
            poses = {name: vehicle.pose for name, vehicle in world.vehicles.items()}
            self._shared.record_step(next(iter(poses.values()), None))
            if self._parent:
                self._parent.moved(world.steps, poses)
            transforms: list[Any] = []
            for name, topics in self._topics.items():
                if name in world.vehicles:
                    transforms += topics.publish(world, now)
            if transforms and self._transform.wanted():
                self._transform.publish(TFMessage(transforms))
            self._gazebo.publish()
            if self._link_states.wanted():
                links = world.links()
                self._link_states.publish(LinkStates([name for name, _ in links],
                                                     *zip(*(pose_and_twist(state) for _, state in links))))
            if self._cameras and self._camera_schedule.due(world.time):
                self._robots.publish(TFMessage([base_transform(now, 'world', name, vehicle.centre)
                                                for name, vehicle in world.vehicles.items()]))
        self._watch_cameras()

    # ------------------------------------------------------------------------------------------------ services

    def _spawn(self, request: Any) -> Generator[Callable[[], Any], Any, SpawnModelResponse]:
        try:
            element = model_files.parse(_with_paths(request.model_xml))
            with self._lock:
                pose = self._world.in_world(flat(request.initial_pose), request.reference_frame)
                warnings = self._world.add(element, request.model_name, _matrix(pose, request.initial_pose.position.z),
                                           request.robot_namespace)
                self._note(request.model_name, 'spawn_model', *pose, request=request)
        except InvalidInput as refusal:
            rospy.logwarn('Could not spawn %s: %s', request.model_name or 'a model', refusal)
            return SpawnModelResponse(False, str(refusal))
        name = request.model_name
        self._elements[name] = element
        if name in self._world.vehicles:
            topics = yield partial(self._make_topics, name)
            with self._lock:
                self._topics[name] = topics
        self._report(name, warnings)
        self._publish_scene()
        return SpawnModelResponse(True, SPAWNED)

    def _delete(self, request: Any) -> Generator[Callable[[], Any], Any, DeleteModelResponse]:
        try:
            with self._lock:
                self._world.remove(request.model_name)
                topics = self._topics.pop(request.model_name, None)
                self._note(request.model_name, 'delete_model', request=request)
        except InvalidInput as refusal:
            return DeleteModelResponse(False, str(refusal))
        self._elements.pop(request.model_name, None)
        if topics:
            yield topics.close
        self._publish_scene()
        return DeleteModelResponse(True, 'DeleteModel: successfully deleted model')

    def _get_link_state(self, request: Any) -> GetLinkStateResponse:
        try:
            with self._lock:
                state = self._world.state(request.link_name, request.reference_frame)
        except InvalidInput as refusal:
            return GetLinkStateResponse(LinkState(), False, str(refusal))
        return GetLinkStateResponse(LinkState(request.link_name, *pose_and_twist(state), request.reference_frame),
                                    True, '')

    def _place(self, name: str, pose: Pose2D, frame: str, request: Any) -> None:
        with self._lock:
            there = self._world.in_world(pose, frame)
            self._world.put(name, there)
            self._note(name, 'teleport_absolute', *there, request=request)
            moved = name not in self._world.vehicles
        if moved:
            self._publish_scene()

    def _get_model_properties(self, request: Any) -> GetModelPropertiesResponse:
        with self._lock:
            if request.model_name not in self._world.names():
                return GetModelPropertiesResponse(success=False,
                                                  status_message=f'there is no model {request.model_name!r}')
            prefix = f'{request.model_name}::'
            bodies = [name[len(prefix):] for name, _ in self._world.links() if name.startswith(prefix)]
            joints = [] if request.model_name not in self._elements else [
                joint.get('name') or '' for joint in self._elements[request.model_name].findall('joint')]
            return GetModelPropertiesResponse(
                canonical_body_name=bodies[0] if bodies else '', body_names=bodies, joint_names=joints,
                is_static=request.model_name not in self._world.vehicles, success=True)

    def _get_physics(self, _: Any) -> GetPhysicsPropertiesResponse:
        response = GetPhysicsPropertiesResponse(time_step=DT, pause=self._clock.paused, max_update_rate=1.0 / DT,
                                                success=True)
        response.gravity.z = -9.8
        return response

    @staticmethod
    def _set_physics(_: Any) -> SetPhysicsPropertiesResponse:
        return SetPhysicsPropertiesResponse(False, f'nothing is changed: a step is {DT:g} s, and nothing falls here')

    def _reset(self, request: Any) -> None:
        with self._lock:
            self._world.reset()
            self._shared.note('reset', request=request)
        self._publish_scene()

    # ------------------------------------------------------------------------------------------------ robots

    def _make_topics(self, name: str) -> RobotTopics:
        return RobotTopics(self._world.vehicles[name], self._lock, self._numbers.getrandbits(64), self._note)

    def _note(self, name: str, event: str, *values: float, request: Any) -> None:
        """Record an event of a model; the caller must hold the lock. A name may be any text."""
        self._shared.note(f'{NOT_OF_A_NAME.sub("?", name)}/{event}', *values, request=request)

    def _report(self, name: str, warnings: Iterable[str]) -> None:
        """Log which parts of a model are simulated, and which are not."""
        vehicle = self._world.vehicles.get(name)
        if vehicle:
            rospy.loginfo('%s: %s', name, _summary(vehicle.robot))
        for warning in warnings:
            rospy.logwarn('%s: %s', name, warning)

    def _publish_scene(self) -> None:
        """Send the current scene to cameras and laser scanners; start the cameras with the first one."""
        with self._lock:
            plan, vehicles = self._world.plan, dict(self._world.vehicles)
            for topics in self._topics.values():
                topics.set_plan(plan)
        cameras = [(name, camera, self._topics[name].prefix[camera.namespace] if name in self._topics else '')
                   for name, vehicle in vehicles.items() for camera in vehicle.robot.cameras]
        bodies = {name: (vehicle.robot.radius, vehicle.robot.height, vehicle.robot.colour)
                  for name, vehicle in vehicles.items()}
        self._scene.publish(json.dumps({'plan': json.loads(world_format.to_json(plan)), 'cameras': cameras,
                                        'bodies': bodies}))
        if cameras and not self._cameras:
            self._start_cameras()

    def _start_cameras(self) -> None:
        found = roslib.packages.find_node('gazebo_ros', CAMERAS)
        environment = dict(os.environ, ROS_NAMESPACE=rospy.get_namespace())
        self._cameras = subprocess.Popen([sys.executable, found[0], f'_server:={rospy.get_name()}'], env=environment,
                                         preexec_fn=partial(processes.end_with_parent, parent=os.getpid()))

    def _watch_cameras(self) -> None:
        if self._cameras and self._cameras.poll() is not None and not rospy.is_shutdown():
            rospy.logerr('The cameras ended with exit code %d; the robots go on without them.',
                         self._cameras.returncode)
            self._cameras = None

    def _end_cameras(self) -> None:
        if self._cameras:
            self._cameras.terminate()


def _fields(pose: Pose2D | None) -> list[str]:
    """Return a Pose2D as fields of a recording, empty ones for None."""
    return [f'{value:.9g}' for value in pose] if pose else [''] * len(RECORDED)


def _summary(robot: Robot) -> str:
    """Return a line about a Robot: how it drives, what it senses, and its size."""
    drive = robot.drive
    kind = 'no drive' if drive is None else 'two wheels' if drive.separation else 'drives in any direction'
    sensors = [f'{len(found)} {name}' for name, found in (('laser(s)', robot.lasers), ('camera(s)', robot.cameras))
               if found]
    return f'{kind}, {", ".join(sensors) or "no laser and no camera"}; a disc of radius {robot.radius:.2f} m'


def _with_paths(xml: str) -> str:
    """Return the text of a model with package://NAME/ written as the path of that package, if there is one."""
    packages = rospkg.RosPack()

    def path(match: re.Match[str]) -> str:
        try:
            return f'file://{packages.get_path(match.group(1))}/'
        except rospkg.ResourceNotFound:
            return match.group()
    return PACKAGE.sub(path, xml)


def _matrix(pose: Pose2D, z: float) -> np.ndarray:
    """Return the matrix (4, 4) of a Pose2D at a height ``z`` [m]."""
    cos, sin = np.cos(pose.yaw), np.sin(pose.yaw)
    return np.array([[cos, -sin, 0.0, pose.x], [sin, cos, 0.0, pose.y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])


def main(connection: socket.socket | None = None, robots: Sequence[tuple[str, str, Pose2D]] = ()) -> None:
    """Run the node gazebo; ``connection``: that of a ParentLink; ``robots``: [(name, URDF, Pose2D)], in namespaces."""
    options = command_line.read(rospy.myargv()[1:])
    require_alone(NAME, world=WORLD)
    init_simulator(NAME, PARAMETERS)
    reachability.watch()
    launch_parameters.keep()
    model_files.use_folders(command_line.model_folders())
    try:
        plan, found, warnings = model_files.load_world(options.world, command_line.world_folders())
    except InvalidInput as error:
        raise parameters.ParameterError(f'the world {options.world}: {error}') from None
    node = GazeboNode(GazeboWorld(plan), warnings, connection, options.paused)
    node.add_from_world(found)
    try:
        for robot in robots:
            node.add_robot(*robot)
    except InvalidInput as error:
        raise parameters.ParameterError(f'the robots: {error}') from None
    node.run()
