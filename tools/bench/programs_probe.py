"""A probe of public programs: waits until what the programs publish meets the conditions of their end."""
import math
import time

import rospy
import rostopic
import tf2_ros
from rosgraph_msgs.msg import Clock

from probing import POLL, say


def position(message):
    """Return x and y of an Odometry, a PoseStamped, a Pose of geometry_msgs, or that of turtlesim."""
    for name in ('pose', 'pose', 'position'):
        message = getattr(message, name, message)
    return message.x, message.y


class Topic:
    """What has come on a topic, of any type, against what a condition asks for."""

    def __init__(self, condition):
        self.condition, self.name = condition, condition['topic']
        self._reads = {'moved', 'near', 'contains'} & set(condition)  # else messages are only counted
        self._count, self._path, self._at, self._held, self._subscriber = 0, 0.0, None, False, None

    @property
    def held(self):
        if self._subscriber is None:
            kind = rostopic.get_topic_class(self.name)[0] if self._reads else rospy.AnyMsg
            self._subscriber = kind and rospy.Subscriber(self.name, kind, self._store)
        return self._held

    def _store(self, message):
        self._count += 1
        if not self._reads:
            self._held = self._count >= self.condition.get('count', 1)
            return
        if 'contains' in self.condition:
            self._held = self._held or self.condition['contains'] in str(message)
            return
        before, self._at = self._at, position(message)
        self._path += math.dist(before or self._at, self._at)
        if 'moved' in self.condition:
            self._held = self._path >= self.condition['moved']
        else:
            self._held = math.dist(self._at, self.condition['near']) <= self.condition['tolerance']

    def __str__(self):
        at = f', the last one at ({self._at[0]:.2f}, {self._at[1]:.2f}) after {self._path:.2f} m' if self._at else ''
        return f'{self.condition}: {self._count} messages{at}'


class Transform:
    """Whether tf knows a frame in another one."""

    def __init__(self, condition, buffer):
        self.condition, self._buffer = condition, buffer

    @property
    def held(self):
        return self._buffer.can_transform(*self.condition['transform'], rospy.Time())

    def __str__(self):
        return f'{self.condition}: tf does not know it'


def watch(conditions, within, patience):
    """Say the time [s] after which all conditions hold, or after ``within`` [s] which do not.

    The time is that of /clock, if a simulator publishes it, which may stand still: at most ``patience`` [s] pass.
    """
    clock = []
    rospy.Subscriber('/clock', Clock, lambda message: clock.append(message.clock.to_sec()) or clock[1:-1].clear())
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)  # noqa: F841 - it fills the buffer while it lives
    watched = [Topic(condition) if 'topic' in condition else Transform(condition, buffer) for condition in conditions]
    begun = time.monotonic()
    while True:
        passed = clock[-1] - clock[0] if clock else time.monotonic() - begun
        missing = [str(one) for one in watched if not one.held]
        if not missing or passed > within or time.monotonic() - begun > patience:
            say(seconds=passed, missing=missing)
            return
        time.sleep(POLL)
