"""The topics of one robot: its commands, odometry, frames, scans, and the other topics of its plugins.

Threading contract: commands arrive in rospy's threads, which take the lock of the world; ``publish`` is called with
that lock held, in the thread that steps. The constructor and ``close`` call the master, and take no lock.
"""
from __future__ import annotations

import threading
from typing import Any, Callable, Sequence

import numpy as np
import rosgraph.names
import rospy
from gazebo_msgs.msg import ContactsState, ContactState
from geometry_msgs.msg import TransformStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu, JointState, LaserScan, Range

from gazebo_ros.core.gazebo_world import GazeboWorld
from gazebo_ros.core.robots import Contact, Drive, Laser, Motion
from gazebo_ros.core.vehicle import Vehicle, angles
from kinematic_core.worlds.floor_plan import Cylinder, FloorPlan
from kinematic_core.worlds.rays import RayCaster
from plain_support import InvalidInput
from rospy_support.rotations import to_quaternion
from rospy_support.throttle import WallThrottle
from rospy_support.topics import LatestPublisher
from sim_ros import robotont_messages as messages

WARNING_PERIOD = 1.0  # [s] of wall time between two warnings about refused velocities
GRAVITY = 9.8  # [m/s^2]
VARIANCES = messages.POSE_VARIANCE, messages.YAW_VARIANCE
EPSILON = 1e-6  # [s]


class Schedule:
    """The schedule of an event with a rate [Hz] of simulated time; a rate of 0 means every step."""

    def __init__(self, rate: float) -> None:
        self._period = 1.0 / rate if rate > 0.0 else 0.0
        self._next = 0.0

    def due(self, time: float) -> bool:
        """Return whether the event is due at ``time`` [s]; if so, the next one is due one period later."""
        if time < self._next - EPSILON:
            return False
        self._next = max(self._next + self._period, time)
        return True


class RobotTopics:
    """Publishers and subscriber of a vehicle.Vehicle."""

    def __init__(self, vehicle: Vehicle, lock: threading.Lock, seed: int, note: Callable[..., object]) -> None:
        """Register everything; ``lock`` guards the vehicle, ``seed`` is that of the noise.

        ``note(name, event, *values, request=message)`` records a command, with the lock held.
        """
        self._vehicle, self._lock, self._note = vehicle, lock, note
        self._random = np.random.default_rng(seed)
        self._refusals = WallThrottle(WARNING_PERIOD)
        self._casters: list[RayCaster] = []
        self._plan: FloorPlan | None = None
        robot, drive = vehicle.robot, vehicle.robot.drive
        parts: list[Any] = [*([drive] if drive else []), *robot.lasers, *robot.cameras, *robot.motions, *robot.contacts]
        self.prefix = {space: _prefix(space) for space in {part.namespace for part in parts}}
        self._registered: list[Any] = []
        if drive:
            self._drive_schedule = Schedule(drive.rate)
            self._command_topic = _topic(drive.namespace, drive.command)
            self._odometry = self._publisher(drive.namespace, drive.odometry, Odometry)
            self._wheel_states = self._publisher(drive.namespace, 'joint_states', JointState) \
                if drive.publishes_wheels else None
        self._lasers = [(laser, Schedule(laser.rate), self._publisher(
            laser.namespace, laser.topic, Range if laser.field else LaserScan)) for laser in robot.lasers]
        self._motions = [(motion, Schedule(motion.rate), self._publisher(
            motion.namespace, motion.topic, Odometry if motion.is_pose else Imu)) for motion in robot.motions]
        self._joints = [(joints, Schedule(joints.rate), self._publisher(joints.namespace, 'joint_states', JointState))
                        for joints in robot.joints]
        self._contacts = [(contact, Schedule(contact.rate), self._publisher(
            contact.namespace, contact.topic, ContactsState)) for contact in robot.contacts]
        if drive:
            self._registered.append(rospy.Subscriber(self._command_topic, Twist, self._command, queue_size=1,
                                                     tcp_nodelay=True))

    def close(self) -> None:
        for each in self._registered:
            each.unregister()

    def set_plan(self, plan: FloorPlan) -> None:
        self._plan, self._casters = plan, []

    def publish(self, world: GazeboWorld, now: rospy.Time) -> list[TransformStamped]:
        """Publish all due messages; return the due transforms. ``world`` is a GazeboWorld, ``now`` the stamp."""
        vehicle = self._vehicle
        transforms: list[TransformStamped] = []
        drive = vehicle.robot.drive
        if drive and self._drive_schedule.due(world.time):
            transforms = self._publish_drive(drive, now)
        others = None
        for number, (laser, schedule, publisher) in enumerate(self._lasers):
            if schedule.due(world.time) and publisher.wanted():
                others = world.bodies(without=vehicle) if others is None else others
                self._publish_laser(laser, number, publisher, others, now)
        for motion, schedule, publisher in self._motions:
            if schedule.due(world.time) and publisher.wanted():
                publisher.publish(self._pose(motion, now) if motion.is_pose else self._imu(motion, now))
        for joints, schedule, publisher in self._joints:
            if schedule.due(world.time) and publisher.wanted():
                publisher.publish(self._joint_states(joints.names, now))
        for contact, schedule, publisher in self._contacts:
            if schedule.due(world.time) and publisher.wanted():
                publisher.publish(self._touches(contact, now))
        return transforms

    def _publisher(self, namespace: str, topic: str, kind: type) -> LatestPublisher:
        publisher = LatestPublisher(_topic(namespace, topic), kind)
        self._registered.append(publisher)
        return publisher

    def _frame(self, namespace: str, name: str) -> str:
        return prefixed(self.prefix[namespace], name)

    def _publish_drive(self, drive: Drive, now: rospy.Time) -> list[TransformStamped]:
        vehicle = self._vehicle
        frame, child = (self._frame(drive.namespace, name) for name in (drive.odometry_frame, drive.base_frame))
        pose = vehicle.odometry
        if drive.publishes_odometry and self._odometry.wanted():
            self._odometry.publish(messages.odometry(now, frame, child, pose, vehicle.twist, VARIANCES))
        if self._wheel_states and self._wheel_states.wanted():
            self._wheel_states.publish(self._joint_states((*drive.left, *drive.right), now))
        return [messages.base_transform(now, frame, child, pose)] if drive.publishes_transform else []

    def _publish_laser(self, laser: Laser, number: int, publisher: LatestPublisher, others: Sequence[Cylinder],
                       now: rospy.Time) -> None:
        if not self._casters and self._plan is not None:
            self._casters = [RayCaster(self._plan, each.mount.z, angles(each)) for each, _, _ in self._lasers]
        ranges = self._vehicle.scan(laser, self._casters[number], others)
        if laser.noise:
            ranges += self._random.normal(0.0, laser.noise, len(ranges))
        np.maximum(ranges, laser.nearest, out=ranges)
        frame = self._frame(laser.namespace, laser.frame)
        if laser.field:
            message = Range(radiation_type=Range.INFRARED if laser.radiation == 'infrared' else Range.ULTRASOUND,
                            field_of_view=laser.field, min_range=laser.nearest, max_range=laser.farthest,
                            range=min(float(ranges.min()), laser.farthest))
        else:
            ranges[ranges > laser.farthest] = np.inf
            step = (laser.last - laser.first) / max(1, laser.rays - 1)
            message = LaserScan(angle_min=laser.first, angle_max=laser.last, angle_increment=step,
                                range_min=laser.nearest, range_max=laser.farthest, ranges=ranges.tolist(),
                                intensities=[0.0] * laser.rays)
        message.header.stamp, message.header.frame_id = now, frame
        publisher.publish(message)

    def _pose(self, motion: Motion, now: rospy.Time) -> Odometry:
        vehicle = self._vehicle
        return messages.odometry(now, self._frame(motion.namespace, motion.frame), motion.base, vehicle.pose,
                                 vehicle.twist)

    def _imu(self, motion: Motion, now: rospy.Time) -> Imu:
        vehicle = self._vehicle
        message = Imu(orientation=to_quaternion(0.0, 0.0, vehicle.pose.yaw))
        message.header.stamp, message.header.frame_id = now, self._frame(motion.namespace, motion.frame)
        message.angular_velocity.z = vehicle.twist.angular_z
        message.linear_acceleration.y = vehicle.twist.angular_z * vehicle.twist.linear_x  # to the middle of a curve
        message.linear_acceleration.z = GRAVITY
        return message

    def _joint_states(self, names: Sequence[str], now: rospy.Time) -> JointState:
        """Return the JointState of joints: angles of wheels, 0 of all others."""
        vehicle, drive = self._vehicle, self._vehicle.robot.drive
        sides: dict[str, int] = {}
        if drive:
            for side, joints in enumerate((drive.left, drive.right)):
                sides.update(dict.fromkeys(joints, side))
        angle, speed = vehicle.wheel_angles, vehicle.wheel_speeds
        message = JointState(name=list(names),
                             velocity=[speed[sides[name]] if name in sides else 0.0 for name in names],
                             position=[angle[sides[name]] if name in sides else 0.0 for name in names])
        message.header.stamp = now
        return message

    def _touches(self, contact: Contact, now: rospy.Time) -> ContactsState:
        message = ContactsState()
        message.header.stamp, message.header.frame_id = now, self._frame(contact.namespace, contact.frame)
        if self._vehicle.touching:
            message.states = [ContactState(info='the robot touches an obstacle', collision1_name=self._vehicle.name)]
        return message

    def _command(self, twist: Twist) -> None:
        try:
            with self._lock:
                velocity = twist.linear.x, twist.linear.y, twist.angular.z
                self._vehicle.command(*velocity)
                self._note(self._vehicle.name, 'cmd', *velocity, request=twist)
        except InvalidInput as refusal:
            self._refusals.warn('velocity', 'Ignored a message on %s, and the robot stops: %s', self._command_topic,
                                refusal)


def _topic(namespace: str, name: str) -> str:
    """Return the full name of a topic, as a NodeHandle of a plugin makes it: relative to the root, not to this node."""
    return rosgraph.names.ns_join('/' + namespace.strip('/'), name)


def _prefix(namespace: str) -> str:
    """Return the tf_prefix that is set in a namespace or above it; '' if there is none."""
    space = '/' + namespace.strip('/')
    while True:
        prefix = rospy.get_param(rosgraph.names.ns_join(space, 'tf_prefix'), None)
        if prefix is not None:
            return str(prefix).strip('/')
        if space == '/':
            return ''
        space = space.rpartition('/')[0] or '/'


def prefixed(prefix: str, frame: str) -> str:
    """Return the name of a frame with a prefix, as tf::resolve does: a name that begins with / has none."""
    return frame[1:] if frame.startswith('/') else f'{prefix}/{frame}' if prefix else frame
