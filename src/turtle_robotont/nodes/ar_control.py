"""The course's nodes for AR markers: print the markers that the tracker sees, and drive a robot by them.

Threads: rospy calls ``_on_markers`` in its own thread, timers call the rest; a lock guards shared data. A timer
publishes the velocity, and at the end so does rospy's shutdown hook, once, in any thread.
"""
import threading
import time

import rospy
from ar_track_alvar_msgs.msg import AlvarMarkers
from geometry_msgs.msg import Twist

from kinematic_core.validation import InvalidInput
from rospy_support import threads
from rospy_support.throttle import WallThrottle
from rospy_support.topic_diagnosis import waiting_text
from rospy_support.topics import LatestPublisher
from rospy_support.velocities import to_twist
from turtle_robotont.driving.vehicle import STOP
from turtle_robotont.markers.sightings import sighting

TOPIC = 'ar_pose_marker'
SILENT_AFTER = 5.0  # [s] of wall time without a message before a warning
LATEST_STEP = 3.0  # periods: a later step of a driver counts as one of that time
REMIND = 10.0  # [s] between two warnings of the same kind


class MarkerListener:
    """Receives the markers on ``ar_pose_marker``: prints them, drops impossible ones, passes the Sightings on."""

    def __init__(self, axes, log_rate, on_sightings=lambda sightings: None):
        """``axes``: one of sightings.AXES; ``log_rate`` [Hz]: print at most this many messages, 0: all."""
        self._axes, self._on_sightings = axes, on_sightings
        self._throttle = WallThrottle(1.0 / log_rate if log_rate > 0.0 else 0.0)
        self._warnings = WallThrottle(REMIND)
        self._heard = time.monotonic()
        self._topic = rospy.resolve_name(TOPIC)
        rospy.loginfo('Subscribing to %s', self._topic)
        self._subscriber = rospy.Subscriber(TOPIC, AlvarMarkers, self._on_markers, tcp_nodelay=True)
        threads.keep_running('watch', self._watch)

    def _on_markers(self, message):
        self._heard = time.monotonic()
        self._warnings.forget('silent')
        places = [self._where(marker, message.header.frame_id) for marker in message.markers]
        if self._throttle.due():
            print_markers([marker for marker, place in zip(message.markers, places) if place is not None])
        self._on_sightings([place for place in places if place is not None])

    def _where(self, marker, frame_id):
        """Return the Sighting of an AlvarMarker; warn and return None if its position is impossible."""
        position = marker.pose.pose.position
        try:
            return sighting(marker.id, (position.x, position.y, position.z), marker.header.frame_id or frame_id,
                            self._axes)
        except InvalidInput as error:
            self._warnings.warn('position', '%s: %s; ignored. Does the tracker know the transform to its '
                                'output_frame?', self._topic, error)
            return None

    def _watch(self):
        """Advise the user while no message arrives; in wall time, because simulated time may be paused."""
        while not rospy.is_shutdown():
            if time.monotonic() - self._heard > SILENT_AFTER and self._warnings.due('silent'):
                rospy.logwarn('No markers on %s (to start camera and tracker: roslaunch turtle_robotont '
                              'camera_ar_track.launch)', waiting_text(self._subscriber, TOPIC))
            time.sleep(0.5)


def print_markers(markers):
    """Print AlvarMarkers as the course does, with their positions in the tracker's output frame."""
    for marker in markers:
        p = marker.pose.pose.position
        rospy.loginfo('Detected marker with ID %d at x: %.3f y: %.3f z: %.3f m, distance: %.3f m', marker.id,
                      p.x, p.y, p.z, (p.x ** 2 + p.y ** 2 + p.z ** 2) ** 0.5)
    if not markers:
        rospy.loginfo('No AR markers detected.')


class Forward:
    """A constant velocity, independent of the markers."""

    status = 'publishing a constant velocity'

    def __init__(self, command):
        self._command = command

    def see(self, sightings):
        """Ignore Sightings."""

    def step(self, dt):
        """Return the command, and print it as the course does."""
        rospy.loginfo('Publish velocity command[%0.2f m/s, %0.2f rad/s]', self._command.linear_x,
                      self._command.angular_z)
        return self._command


class MarkerDriver:
    """Lets a behaviour drive a robot by ``cmd_vel``: it ``see``s Sightings, and ``step(dt)`` returns commands or None.

    Its ``status`` is printed when it changes. The robot is stopped once when the node ends.
    """

    def __init__(self, behaviour, rate, on_step=lambda: None):
        """``rate`` [Hz]: commands per second; ``on_step()`` is called after each."""
        self._behaviour, self._on_step = behaviour, on_step
        self._lock = threading.Lock()
        self._status, self._ended = '', False
        self._longest_step = LATEST_STEP / rate  # [s]
        self._publisher = LatestPublisher('cmd_vel', Twist)
        rospy.on_shutdown(self.stop)
        threads.call_every(1.0 / rate, self._step)

    def see(self, sightings):
        """Pass the Sightings of a message to the behaviour."""
        with self._lock:
            self._behaviour.see(sightings)

    def stop(self):
        """Publish a velocity of zero, once, and nothing after it."""
        with self._lock:
            if not self._ended:
                self._ended = True
                self._publish(STOP)

    def _step(self, event):
        since = (event.current_real - (event.last_real or event.current_real)).to_sec()
        with self._lock:
            if self._ended:
                return
            command = self._behaviour.step(min(max(0.0, since), self._longest_step))  # the clock may have been set
            if command is not None:
                self._publish(command)
            status, before = self._behaviour.status, self._status
            self._status = status
        if status != before:
            rospy.loginfo('%s', status[0].upper() + status[1:])
        self._on_step()

    def _publish(self, command):
        self._publisher.publish(to_twist(command))
