"""Drive a turtle or a robot with a controller of turtle_robotont.driving: poses come in, velocities go out.

Threads: rospy calls ``_on_pose`` for each message in a thread of its own. It steps the current drive and publishes its
command; ``drive`` waits in another thread until the drive has ended. A lock guards the data of both.
"""
import math
import threading
import time
from typing import Any, Callable, List, Optional, Tuple

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from turtlesim.msg import Pose

from turtle_robotont.driving.control import Drive, State
from turtle_robotont.driving.shapes import wrap_angle
from turtle_robotont.driving.vehicle import ROBOT, STOP, TURTLE, TURTLE_STEP, Twist2D, VehicleState
from turtle_robotont.msg import DriveStatus

READY_TIMEOUT = 10.0  # [s] for a vehicle to publish poses and take commands
POLL = 0.02  # [s]
STATUS_PERIOD = 0.1  # [s]
UNIT_TOLERANCE = 0.01  # by which the length of a quaternion may differ from 1


class DriveError(RuntimeError):
    """The vehicle cannot be driven, or did not arrive; the text says why and what to do."""


class Driver:
    """Drives one vehicle: the turtle with that name, or a robot with odometry if ``turtle`` is empty.

    There is one drive at a time: a newer one takes over, and the older one ends PREEMPTED. The vehicle is stopped once
    when a drive ends, and when the node ends during one.
    """

    def __init__(self, turtle: str = '') -> None:
        self.turtle = turtle
        self.vehicle, self.silence = (TURTLE, 1.0) if turtle else (ROBOT, 0.5)  # [s] without a pose: the drive fails
        prefix = f'{turtle}/' if turtle else ''
        self.pose_topic = rospy.resolve_name(f'{turtle}/pose' if turtle else 'odom')
        self._lock = threading.RLock()
        self._drive: Optional[Drive] = None  # the one that may send commands
        self._track: List[VehicleState] = []  # its poses
        self._pose: Any = None  # the newest one, a VehicleState or turtlesim/Pose
        self._count, self._stamp = 0, 0.0  # poses, [s] of the newest odometry
        self._reported: Tuple[Optional[State], float] = None, 0.0  # state and time [s] of the newest status
        self._velocity = rospy.Publisher(f'{prefix}cmd_vel', Twist, queue_size=10, tcp_nodelay=True)
        self._status = rospy.Publisher(f'{prefix}drive_status', DriveStatus, queue_size=10)
        rospy.on_shutdown(lambda: self.cancel('the node is shutting down'))
        if turtle:
            rospy.Subscriber(f'{turtle}/pose', Pose, lambda pose: self._on_pose(pose, TURTLE_STEP), tcp_nodelay=True)
        else:
            rospy.Subscriber('odom', Odometry, self._on_odometry, tcp_nodelay=True)

    def ready(self) -> VehicleState:
        """Wait until the vehicle publishes poses and takes commands; return its pose. Raise DriveError after 10 s."""
        if self._pose is None:
            rospy.loginfo('Waiting for %s...', self.pose_topic)
        self._wait(lambda: self._pose is not None, READY_TIMEOUT)
        deadline = time.monotonic() + READY_TIMEOUT
        while not self._velocity.get_num_connections():
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise DriveError(f'no subscriber on {self._velocity.resolved_name} after {READY_TIMEOUT:g} s; is the '
                                 'simulator running, and are the topics of velocity and pose remapped alike?')
            time.sleep(POLL)
        return self.pose()

    def pose(self) -> VehicleState:
        """Return the next pose. Raise DriveError if none comes, or one that is not finite."""
        count = self._count
        self._wait(lambda: self._count > count, self.silence)
        pose = self._pose
        if not all(map(math.isfinite, (pose.x, pose.y, pose.theta))):
            raise DriveError(f'the pose on {self.pose_topic} is not finite (x={pose.x}, y={pose.y}, theta={pose.theta}'
                             f'); reset the {self.vehicle.name} or the node that publishes the pose')
        return pose

    def drive(self, drive: Drive) -> Tuple[List[VehicleState], float]:
        """Follow a Drive until it ends; return the poses on the way and the time [s] that it took."""
        start = rospy.get_time()
        with self._lock:
            self.cancel('a newer goal took over')
            self._drive, self._track = drive, []
            track = self._track
        while not drive.finished:
            count = self._count
            try:
                self._wait(lambda: drive.finished or self._count > count, self.silence)  # noqa: B023
            except DriveError as error:
                self._end(drive, State.FAILED, str(error))
        self._report(drive)
        return track, rospy.get_time() - start

    def cancel(self, reason: str) -> None:
        """End the current drive, if there is one, and stop the vehicle."""
        with self._lock:
            if self._drive is not None:
                self._end(self._drive, State.PREEMPTED, f'preempted: {reason}')

    def _wait(self, happened: Callable[[], bool], timeout: float) -> None:
        """Wait until ``happened()``; raise DriveError if that takes longer than ``timeout`` [s].

        The time is counted in short waits, of which a machine that stands still uses up one, and only while ROS time
        passes: a simulator may be paused.
        """
        waited, before = 0.0, rospy.get_time()
        while not happened():
            if rospy.is_shutdown():
                raise rospy.ROSInterruptException('the node is shutting down')
            if waited > timeout:
                raise DriveError(self._silence(timeout))
            time.sleep(POLL)
            now = rospy.get_time()
            waited += POLL * (now != before)
            before = now

    def _silence(self, timeout: float) -> str:
        if self.turtle:
            return (f'no pose on {self.pose_topic} for {timeout:g} s; is the simulator running, and does the turtle '
                    f'{self.turtle} exist? (rostopic list)')
        return f'no odometry on {self.pose_topic} for {timeout:g} s; is the robot or its simulator running?'

    def _end(self, drive: Drive, state: State, reason: str) -> None:
        with self._lock:
            if self._drive is drive:
                drive.end(state, reason)
                self._send(STOP)
                self._drive = None

    def _send(self, command: Twist2D) -> None:
        velocity = Twist()
        velocity.linear.x, velocity.linear.y, velocity.angular.z = command
        self._velocity.publish(velocity)

    def _on_odometry(self, odometry: Odometry) -> None:
        stamp, before = odometry.header.stamp.to_sec(), self._stamp
        if before and stamp <= before:
            rospy.logwarn_throttle(5.0, f'{self.pose_topic}: the time {stamp:.3f} s is not after that of the last '
                                        f'message, {before:.3f} s; ignored. Do two nodes publish it? (rostopic info)')
            return
        self._stamp = stamp
        self._on_pose(pose_of(odometry), min(stamp - before, self.silence) if before else 0.0)

    def _on_pose(self, pose: VehicleState, dt: float) -> None:
        """Store a pose that comes ``dt`` [s] after the previous one, and step the current drive."""
        with self._lock:
            self._pose, self._count, drive = pose, self._count + 1, self._drive
            if drive is None:
                return
            if math.isfinite(pose.x + pose.y + pose.theta):
                self._track.append(pose)
                self._send(drive.step(pose, dt))
            if drive.finished:
                self._drive = None
        if not drive.finished:
            self._report(drive)

    def _report(self, drive: Drive) -> None:
        """Publish the status of a drive, at each change of its state and every STATUS_PERIOD."""
        state, since = self._reported
        now = time.monotonic()
        if drive.state is state and now - since < STATUS_PERIOD:
            return
        self._reported = drive.state, now
        status = DriveStatus(state=getattr(DriveStatus, drive.state.name), reason=drive.reason)
        status.header.stamp = rospy.Time.now()
        goal = drive.goal
        status.goal_x, status.goal_y, status.use_heading = goal.x, goal.y, goal.theta is not None
        status.goal_theta = 0.0 if goal.theta is None else wrap_angle(goal.theta)
        status.distance_left, status.heading_error_left = drive.distance_left, drive.heading_left
        self._status.publish(status)


def pose_of(odometry: Odometry) -> VehicleState:
    """Return the VehicleState of a nav_msgs/Odometry; its theta is NaN if the orientation is not a rotation."""
    q, twist = odometry.pose.pose.orientation, odometry.twist.twist
    is_unit = abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1.0) < UNIT_TOLERANCE
    theta = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z)) if is_unit else math.nan
    position = odometry.pose.pose.position
    return VehicleState(position.x, position.y, theta, math.hypot(twist.linear.x, twist.linear.y), twist.angular.z)
