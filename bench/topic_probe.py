"""A subscriber (see probing.py). Messages are received as bytes (AnyMsg)."""
import time

import rospy
from geometry_msgs.msg import Twist, Vector3

from probing import COME_UP, await_true, clock, repeat, say

BUFFER = 1 << 24  # [bytes] more than an image
COMMAND_PERIOD = 0.1  # [s]
TURN = 0.6  # [rad/s]


def _stamps(topic):
    """Return the list to which the times [s] of arrival on a topic are appended from now on."""
    stamps = []
    rospy.Subscriber(topic, rospy.AnyMsg, lambda _: stamps.append(clock()), tcp_nodelay=True, buff_size=BUFFER)
    return stamps


def first(topic):
    """Say that the subscriber is there, then report when the first message came."""
    stamps = _stamps(topic)
    say(listens=True)
    await_true(lambda: stamps, COME_UP, f'a message on {topic}')
    say(first=stamps[0])


def listen(topic, seconds, turning=False):
    """Say that messages come, then report the stamps of this time; with ``turning``, no image is like the last."""
    stamps = _stamps(topic)
    if turning:
        driver = rospy.Publisher('cmd_vel', Twist, queue_size=1)
        repeat(COMMAND_PERIOD, lambda: driver.publish(Vector3(), Vector3(0.0, 0.0, TURN)))
    await_true(lambda: stamps, COME_UP, f'a message on {topic}')
    say(listens=True)
    time.sleep(seconds + 1.0)  # the bench settles for a second first
    end = clock()
    say(stamps=[stamp for stamp in stamps if stamp >= end - seconds])
