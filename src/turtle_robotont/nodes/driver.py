"""The node layer of driving: it receives poses, and publishes velocities and a status.

Threads: rospy calls ``_take`` in its own thread; ``drive`` runs in the thread that wants to drive (a service's or the
main one). The condition ``_changed`` guards all shared data. A drive is stepped, and its command sent, while it is
held, so that no command of an older drive is sent after a newer one has taken over.
"""
import collections
import math
import sys
import threading
import time
from typing import NamedTuple

import rospy

from kinematic_core.validation import InvalidInput
from kinematic_core.worlds.angles import wrap_angle
from rospy_support import nodes
from rospy_support.rospy_internals import steady_time
from rospy_support.velocities import to_twist
from turtle_robotont.driving.control import State
from turtle_robotont.driving.vehicle import STOP
from turtle_robotont.msg import DriveStatus

READY_TIMEOUT = 10.0  # [s] for a vehicle to publish a pose and listen to commands
POLL = 0.02  # [s] between two checks for a subscriber
SHORT_WAIT = 0.25  # [s] longer than the idle time that a simulator in lockstep needs
SAY_AFTER = 5.0  # [s] without a pose while simulated time is paused, before a warning
STANDING = 0.1  # simulated time counts as paused if less than this share of the wait passes
STATUS_PERIOD = 0.1  # [s]
POSES_KEPT = 1000  # most poses that wait for a drive on a busy machine


class DriveError(RuntimeError):
    """The vehicle cannot be driven, or did not get there; the text says why and what to do."""


class DriveResult(NamedTuple):
    """The result of a drive: the poses on the path, and the time [s] that it took."""

    track: list
    elapsed: float


class Driver:
    """Drives one vehicle; a subclass defines the topics, and calls ``_take`` with each pose.

    There is one drive at a time: a newer one takes over, and the older one ends PREEMPTED. Whenever a drive ends, and
    when the node shuts down during one, the vehicle is stopped once, so that other nodes can drive it.
    """

    pose_timeout = 1.0  # [s] without a pose after which a drive fails; see _await

    def __init__(self, vehicle, velocity, status, pose_topic):
        """``velocity`` and ``status`` publish Twist and DriveStatus; ``pose_topic`` is for texts."""
        self.vehicle, self.pose_topic = vehicle, rospy.resolve_name(pose_topic)
        self._subscriber = None  # to the poses; a subclass sets it last
        self._changed = threading.Condition()
        self._current, self._why = None, ''  # the Drive that may send commands, and why it was handed over
        self._waiting = collections.deque(maxlen=POSES_KEPT)  # (pose, dt) that the drive has not processed
        self._latest, self._count = None, 0
        self._velocity, self._status = velocity, status
        rospy.on_shutdown(lambda: self.cancel('the node is shutting down'))

    def _no_pose(self, timeout):
        """Return the error text for no pose within timeout [s], and what to do."""
        raise NotImplementedError

    def ready(self, timeout=READY_TIMEOUT):
        """Wait until the vehicle publishes a pose and listens to commands; return the pose.

        Raise DriveError after ``timeout`` [s].
        """
        deadline = time.monotonic() + timeout
        if self._latest is None:
            rospy.loginfo('Waiting for %s...', self.pose_topic)
        pose = self.pose(timeout)
        while not self._velocity.get_num_connections():
            if time.monotonic() > deadline or rospy.is_shutdown():
                raise DriveError(f'no subscriber on {self._velocity.resolved_name} after {timeout:g} s; is the '
                                 'simulator running, and are the topics of velocity and pose remapped alike?')
            time.sleep(POLL)
        return pose

    def pose(self, timeout=None):
        """Return the next pose; raise DriveError if none arrives within ``timeout`` [s]."""
        timeout = timeout or self.pose_timeout
        with self._changed:
            seen = self._count
            if not self._await(lambda: self._count > seen or rospy.is_shutdown(), timeout):
                raise DriveError(self._no_pose(timeout))
            if self._latest is None:
                raise rospy.ROSInterruptException('shut down before there was a pose')
            if not _finite(self._latest):
                raise DriveError(self._bad_pose(self._latest))
            return self._latest

    def drive(self, drive):
        """Follow a Drive until it ends; return the DriveResult. The drive's state and reason tell how it ended."""
        started, track, reporter = steady_time(), [], _Reporter(self._status)
        with self._changed:
            self._hand_over(drive, 'a newer goal took over')
            self._waiting.clear()
        while not drive.finished:
            with self._changed:
                self._await(lambda: self._waiting or self._current is not drive, self.pose_timeout)
                if self._current is drive:
                    track.extend(self._step(drive))
                else:
                    drive.end(State.PREEMPTED, f'preempted: {self._why}')
            reporter.report(drive)
        with self._changed:
            if self._current is drive:
                self._send(STOP)
                self._current = None
        return DriveResult(track, steady_time() - started)

    def cancel(self, reason):
        """End the current drive, if there is one, and stop the vehicle."""
        with self._changed:
            if self._current is not None:
                self._hand_over(None, reason)
                self._send(STOP)

    def _await(self, happened, timeout):
        """Wait until ``happened()`` is true; return whether that was before ``timeout`` [s] had passed.

        The time is the sum of short waits, so that a machine that stands still uses up only one of them. It must also
        have passed in ROS time, because a simulator may be slow or paused, unless no node publishes poses.
        """
        begin, waited, said = steady_time(), 0.0, False
        while not self._changed.wait_for(happened, SHORT_WAIT):
            waited, now = waited + SHORT_WAIT, steady_time()
            if not 0.0 < begin <= now:  # ROS time has just started, or was set back
                begin = now
            if waited >= timeout and (now - begin >= timeout or not self._subscriber.get_num_connections()):
                return False
            if waited >= SAY_AFTER and now - begin < STANDING * waited and not said:
                said = True
                rospy.logwarn('No pose on %s, and the simulated time stays at %.3f s: is the simulator paused? '
                              'Waiting.', self.pose_topic, now)
        return True

    def _hand_over(self, drive, why):
        self._current, self._why = drive, why
        self._changed.notify_all()

    def _step(self, drive):
        """Step the drive with the poses that have arrived; return them."""
        poses, elapsed = [pose for pose, _ in self._waiting], sum(dt for _, dt in self._waiting)
        self._waiting.clear()
        if not poses:
            drive.end(State.FAILED, self._no_pose(self.pose_timeout))
        elif not _finite(poses[-1]):
            drive.end(State.FAILED, self._bad_pose(poses[-1]))
        else:
            command = drive.step(poses[-1], elapsed)
            if self._current is drive:  # else a shutdown has ended it, whose signal interrupts this thread
                self._send(command)
        return poses

    def _send(self, command):
        self._velocity.publish(to_twist(command))

    def _take(self, pose, dt):
        """Store a pose that arrived ``dt`` [s] after the previous one."""
        with self._changed:
            self._latest, self._count = pose, self._count + 1
            self._waiting.append((pose, dt))
            self._changed.notify_all()

    def _bad_pose(self, pose):
        return (f'the pose on {self.pose_topic} is not finite (x={pose.x}, y={pose.y}, theta={pose.theta}); reset the '
                f'{self.vehicle.name} or the node that publishes the pose')


class _Reporter:
    """Publishes a drive's status at each change of state and every STATUS_PERIOD."""

    def __init__(self, publisher):
        self._publisher = publisher
        self._state, self._time = None, 0.0

    def report(self, drive):
        now = time.monotonic()
        if drive.state is not self._state or now - self._time >= STATUS_PERIOD:
            self._state, self._time = drive.state, now
            self._publisher.publish(status_message(drive))


def status_message(drive):
    """Return the DriveStatus of a Drive."""
    status = DriveStatus(state=getattr(DriveStatus, drive.state.name), reason=drive.reason)
    status.header.stamp = rospy.Time.now()
    goal = drive.goal
    status.goal_x, status.goal_y, status.use_heading = goal.x, goal.y, goal.theta is not None
    status.goal_theta = wrap_angle(goal.theta) if status.use_heading else 0.0
    status.distance_left, status.heading_error_left = drive.distance_left, drive.heading_left
    return status


def run(main):
    """Run the main() of a node that drives; if it fails, log the reason and exit with code 1."""
    def guarded():
        try:
            main()
        except (DriveError, InvalidInput) as error:
            rospy.logfatal('%s', error)
            sys.exit(1)
    nodes.run(guarded)


def _finite(pose):
    return math.isfinite(pose.x) and math.isfinite(pose.y) and math.isfinite(pose.theta)
