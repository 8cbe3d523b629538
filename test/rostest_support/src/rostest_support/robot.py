"""Helpers for rostests of the robot's nodes: markers as a tracker publishes them, and a robot that obeys cmd_vel."""
import math
import threading

import rospy
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers
from geometry_msgs.msg import Quaternion, Twist
from nav_msgs.msg import Odometry

from kinematic_core.timing.pacing import Pacer
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.robot_world import RobotWorld
from rostest_support.common import Collected, until
from rostest_support.course import CourseCase

FRAME = 'camera_link'
VIEW = 0.7  # [rad] that the robot's camera sees to each side
ODOMETRY_STEPS, MARKERS_STEPS = 4, 12  # of RobotWorld's 120 Hz: 30 Hz and 10 Hz


def markers_message(markers, frame=FRAME):
    """Return an AlvarMarkers of {id: (x, y, z)} [m]."""
    message = AlvarMarkers()
    message.header.stamp, message.header.frame_id = rospy.Time.now(), frame
    for marker_id, position in markers.items():
        marker = AlvarMarker(id=marker_id, header=message.header)
        marker.pose.pose.position.x, marker.pose.pose.position.y, marker.pose.pose.position.z = position
        marker.pose.pose.orientation.w = 1.0
        message.markers.append(marker)
    return message


class RobotCase(CourseCase):
    """A test with nodes of the robot part; there is no turtle."""

    simulator = None

    def tracker(self, topic='ar_pose_marker', subscribers=1):
        """Return a function ({id: (x, y, z)}) that publishes markers to that many subscribers."""
        publisher = rospy.Publisher(topic, AlvarMarkers, queue_size=100, tcp_nodelay=True)  # more than a test sends
        self.addCleanup(publisher.unregister)
        until(lambda: publisher.get_num_connections() >= subscribers, f'{subscribers} subscribers of {topic}')
        return lambda markers, frame=FRAME: publisher.publish(markers_message(markers, frame))

    def velocities(self, topic='cmd_vel'):
        """Return the Collected velocities of the robot."""
        collected = Collected(topic, Twist)
        self.addCleanup(collected.subscriber.unregister)
        return collected

    def robot(self, start=(0.0, 0.0, 0.0), places=None):
        """Return a Robot that ends with the test."""
        robot = Robot(start, places)
        self.addCleanup(robot.stop)
        return robot


class Robot(threading.Thread):
    """A Robotont without obstacles in real time: obeys ``cmd_vel``, publishes ``odom`` and the markers that it sees.

    ``places``: {id: (x, y)} [m] of markers. ``track``: the poses (x, y, theta) so far, one for each message of
    odometry. While ``silent`` it publishes nothing.
    """

    def __init__(self, start=(0.0, 0.0, 0.0), places=None):
        super().__init__(daemon=True)
        self.world, self.places, self.track = RobotWorld(start=Pose2D(*start)), places, []
        self.silent, self._ended, self._lock = False, threading.Event(), threading.Lock()
        self._pacer = Pacer(self.world.dt)
        self._odometry = rospy.Publisher('odom', Odometry, queue_size=10, tcp_nodelay=True)
        self._markers = rospy.Publisher('ar_pose_marker', AlvarMarkers, queue_size=10, tcp_nodelay=True)
        self._commands = rospy.Subscriber('cmd_vel', Twist, self._on_command, tcp_nodelay=True)
        self.start()

    def run(self):
        while not self._ended.is_set():
            if self._pacer.wait() is None:
                continue
            with self._lock:
                self.world.step()
            if self.world.steps % ODOMETRY_STEPS == 0:
                self.track.append(tuple(self.world.pose))
                if not self.silent:
                    self._odometry.publish(self._message())
            if self.places and self.world.steps % MARKERS_STEPS == 0 and not self.silent:
                self._markers.publish(markers_message(self._seen()))

    def stop(self):
        """End it."""
        self._ended.set()
        self.join()
        for topic in (self._odometry, self._markers, self._commands):
            topic.unregister()

    def stands(self):
        """Return whether it stands still."""
        return self.world.twist == (0.0, 0.0, 0.0)

    def _on_command(self, twist):
        with self._lock:
            self.world.command(twist.linear.x, twist.linear.y, twist.angular.z)

    def _message(self):
        message = Odometry()
        message.header.stamp, message.header.frame_id = rospy.Time.now(), 'odom'
        message.child_frame_id = 'base_footprint'
        pose, twist = self.world.odometry.pose, self.world.odometry.twist
        message.pose.pose.position.x, message.pose.pose.position.y = pose.x, pose.y
        message.pose.pose.orientation = Quaternion(0.0, 0.0, math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0))
        message.twist.twist.linear.x, message.twist.twist.linear.y, message.twist.twist.angular.z = twist
        return message

    def _seen(self):
        x, y, yaw = self.world.pose
        seen = {}
        for marker_id, place in self.places.items():
            dx, dy = place[0] - x, place[1] - y
            ahead, left = dx * math.cos(yaw) + dy * math.sin(yaw), dy * math.cos(yaw) - dx * math.sin(yaw)
            if abs(math.atan2(left, ahead)) < VIEW:
                seen[marker_id] = (ahead, left, 0.0)
        return seen
