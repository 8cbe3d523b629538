"""tf2_web_republisher: the node.

Threading contract: each request has a rospy.Timer that looks up its transforms; the table of goals has a lock.
"""
import itertools
import threading
import time
from typing import Any, Dict, List, Optional, Sequence

import actionlib
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped

from rospy_support import nodes, threads
from rospy_support.parameters import Table
from rospy_support.throttle import WallThrottle
from tf2_web_republisher.core.changes import InvalidRequest, Thresholds, Transform, check
from tf2_web_republisher.msg import TFArray, TFSubscriptionAction, TFSubscriptionFeedback
from tf2_web_republisher.srv import RepublishTFs, RepublishTFsResponse

PARAMETERS = Table()
REMINDER = 10.0  # [s] between two warnings that a transform is unknown
SHORTEST_TIMEOUT = 1.0  # [s] in which a client can subscribe to its topic


class Watched:
    """The transforms that one client has requested."""

    def __init__(self, buffer: tf2_ros.Buffer, throttle: WallThrottle, frames: Sequence[str], target: str,
                 thresholds: Thresholds) -> None:
        """``throttle``: of the warnings."""
        self._buffer, self._throttle, self._thresholds = buffer, throttle, thresholds
        self._target = target.strip('/')
        self._sent: Dict[str, Optional[Transform]] = {frame.strip('/'): None for frame in frames}

    def changed(self) -> List[TransformStamped]:
        """Return the transforms that have passed the thresholds since they were last returned."""
        changed = []
        for frame, sent in self._sent.items():
            try:
                stamped = self._buffer.lookup_transform(self._target, frame, rospy.Time())
            except tf2_ros.TransformException as error:
                self._throttle.warn(frame, 'No transform from %s to %s yet: %s', frame, self._target, error)
                continue
            now = _transform(stamped.transform)
            if self._thresholds.passed(sent, now):
                self._sent[frame] = now
                changed.append(self._stamped(frame, stamped.transform))
        return changed

    def _stamped(self, frame: str, transform: Any) -> TransformStamped:
        stamped = TransformStamped(child_frame_id=frame, transform=transform)
        stamped.header.stamp, stamped.header.frame_id = rospy.Time.now(), self._target
        return stamped


class Republisher:
    """The action and the service."""

    def __init__(self) -> None:
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._throttle = WallThrottle(REMINDER)
        self._numbers = itertools.count()
        self._timers: Dict[str, rospy.Timer] = {}  # {id of a goal: its timer}
        self._lock = threading.Lock()
        rospy.Service('republish_tfs', RepublishTFs, self._requested)
        self._server = actionlib.ActionServer(rospy.get_name(), TFSubscriptionAction, self._goal, self._cancel, False)
        self._server.start()

    def _watched(self, request: Any) -> Watched:
        """Return the Watched of a goal or a request; raise InvalidRequest."""
        thresholds = Thresholds(request.trans_thres, request.angular_thres)
        check(request.source_frames, request.target_frame, thresholds, request.rate)
        return Watched(self._buffer, self._throttle, request.source_frames, request.target_frame, thresholds)

    def _goal(self, handle: Any) -> None:
        goal = handle.get_goal()
        try:
            watched = self._watched(goal)
        except InvalidRequest as error:
            rospy.logwarn('A goal is refused: %s', error)
            handle.set_rejected(text=str(error))
            return
        handle.set_accepted()

        def poll(_: object) -> None:
            transforms = watched.changed()
            if transforms:
                handle.publish_feedback(TFSubscriptionFeedback(transforms))
        with self._lock:
            self._timers[handle.get_goal_id().id] = threads.call_every(1.0 / goal.rate, poll)

    def _cancel(self, handle: Any) -> None:
        with self._lock:
            timer = self._timers.pop(handle.get_goal_id().id, None)
        if timer is not None:
            timer.shutdown()
            handle.set_canceled()

    def _requested(self, request: Any) -> RepublishTFsResponse:
        try:
            watched = self._watched(request)
        except InvalidRequest as error:
            raise rospy.ServiceException(str(error)) from None
        publisher = rospy.Publisher(f'~tf_repub_{next(self._numbers)}', TFArray, latch=True, queue_size=10)
        patience = max(SHORTEST_TIMEOUT, request.timeout.to_sec())
        subscribed = time.monotonic()  # last time with a subscriber

        def poll(_: object) -> None:
            nonlocal subscribed
            if publisher.get_num_connections():
                subscribed = time.monotonic()
            elif time.monotonic() > subscribed + patience:
                timer.shutdown()
                publisher.unregister()
                rospy.loginfo('%s ends: it had no subscribers for %g s', publisher.resolved_name, patience)
                return
            transforms = watched.changed()
            if transforms:
                publisher.publish(transforms)
        timer = threads.call_every(1.0 / request.rate, poll)
        return RepublishTFsResponse(publisher.resolved_name)


def _transform(transform: Any) -> Transform:
    translation, rotation = transform.translation, transform.rotation
    return Transform((translation.x, translation.y, translation.z), (rotation.x, rotation.y, rotation.z, rotation.w))


def main() -> None:
    nodes.init_node('tf2_web_republisher', PARAMETERS)
    Republisher()
    rospy.spin()
