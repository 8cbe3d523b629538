"""tf2_web_republisher: the node.

Threading contract: each request has a rospy.Timer that looks up its transforms; the table of goals has a lock.
"""
import itertools
import threading
import time

import actionlib
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

from rospy_support import nodes, threads
from rospy_support.parameters import Table
from rospy_support.throttle import WallThrottle
from tf2_web_republisher.core.changes import Thresholds, Transform, invalid
from tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionFeedback
from tf2_web_republisher.srv import RepublishTFs, RepublishTFsResponse

PARAMETERS = Table()
REMINDER = 10.0  # [s] between two warnings that a transform is unknown
SHORTEST_TIMEOUT = 1.0  # [s] in which a client can subscribe to its topic


class Watched:
    """The transforms that one client wants."""

    def __init__(self, buffer, throttle, frames, target, thresholds):
        """``throttle``: of the warnings; ``thresholds``: Thresholds."""
        self._buffer, self._throttle, self._thresholds = buffer, throttle, thresholds
        self._target = target.strip('/')
        self._sent = {frame.strip('/'): None for frame in frames}

    def changed(self):
        found = []
        for frame, sent in self._sent.items():
            try:
                stamped = self._buffer.lookup_transform(self._target, frame, rospy.Time())
            except tf2_ros.TransformException as error:
                self._throttle.warn(frame, 'No transform from %s to %s yet: %s', frame, self._target, error)
                continue
            now = _transform(stamped.transform)
            if self._thresholds.passed(sent, now):
                self._sent[frame] = now
                found.append(self._stamped(frame, stamped.transform))
        return found

    def _stamped(self, frame, transform):
        stamped = TransformStamped(child_frame_id=frame, transform=transform)
        stamped.header.stamp, stamped.header.frame_id = rospy.Time.now(), self._target
        return stamped


class Republisher:
    """The action and the service."""

    def __init__(self):
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._throttle = WallThrottle(REMINDER)
        self._numbers = itertools.count()
        self._timers, self._lock = {}, threading.Lock()  # {id of a goal: its timer}
        rospy.Service('republish_tfs', RepublishTFs, self._requested)
        self._server = actionlib.ActionServer(rospy.get_name(), TFSubscriptionAction, self._goal, self._cancel, False)
        self._server.start()

    def _watched(self, wanted):
        """Return (Watched, '') for a goal or a request, or (None, why not)."""
        thresholds = Thresholds(wanted.trans_thres, wanted.angular_thres)
        wrong = invalid(wanted.source_frames, wanted.target_frame, thresholds, wanted.rate)
        if wrong:
            return None, wrong
        return Watched(self._buffer, self._throttle, wanted.source_frames, wanted.target_frame, thresholds), ''

    def _goal(self, handle):
        goal = handle.get_goal()
        watched, wrong = self._watched(goal)
        if watched is None:
            rospy.logwarn('A goal is refused: %s', wrong)
            handle.set_rejected(text=wrong)
            return
        handle.set_accepted()

        def poll(_):
            transforms = watched.changed()
            if transforms:
                handle.publish_feedback(TFSubscriptionFeedback(transforms))
        with self._lock:
            self._timers[handle.get_goal_id().id] = threads.call_every(1.0 / goal.rate, poll)

    def _cancel(self, handle):
        with self._lock:
            timer = self._timers.pop(handle.get_goal_id().id, None)
        if timer is not None:
            timer.shutdown()
            handle.set_canceled()

    def _requested(self, request):
        watched, wrong = self._watched(request)
        if watched is None:
            raise rospy.ServiceException(wrong)
        publisher = rospy.Publisher(f'~tf_repub_{next(self._numbers)}', TFArray, latch=True, queue_size=10)
        patience = max(SHORTEST_TIMEOUT, request.timeout.to_sec())
        wanted = [time.monotonic()]  # last time with a subscriber

        def poll(_):
            if publisher.get_num_connections():
                wanted[0] = time.monotonic()
            elif time.monotonic() > wanted[0] + patience:
                timer.shutdown()
                publisher.unregister()
                rospy.loginfo('%s ends: it had no subscribers for %g s', publisher.resolved_name, patience)
                return
            transforms = watched.changed()
            if transforms:
                publisher.publish(transforms)
        timer = threads.call_every(1.0 / request.rate, poll)
        return RepublishTFsResponse(publisher.resolved_name)


def _transform(transform):
    moved, turned = transform.translation, transform.rotation
    return Transform((moved.x, moved.y, moved.z), (turned.x, turned.y, turned.z, turned.w))


def main():
    nodes.init_node('tf2_web_republisher', PARAMETERS)
    Republisher()
    rospy.spin()
