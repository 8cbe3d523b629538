"""Subscribers and drivers (see probing.py). Messages are received as bytes (AnyMsg)."""
import time

import rospy
from geometry_msgs.msg import Twist, Vector3

from probing import COME_UP, await_true, clock, repeat, say

BUFFER = 1 << 24  # [bytes] more than an image
TURN = 0.6  # [rad/s] of a camera, so that no image is like the last


def subscribed(topic):
    """Return the list to which the times [s] of arrival on a topic are appended from now on."""
    stamps = []
    rospy.Subscriber(topic, rospy.AnyMsg, lambda _: stamps.append(clock()), tcp_nodelay=True, buff_size=BUFFER)
    return stamps


def awaited(topic):
    """Return the same list once a message has come."""
    stamps = subscribed(topic)
    await_true(lambda: stamps, COME_UP, f'a message on {topic}')
    return stamps


def drive(topics, speed=1.0, turn=2.0, period=0.5):
    """Publish a velocity [m/s, rad/s] on topics every ``period`` [s], until the process ends."""
    publishers = [rospy.Publisher(topic, Twist, queue_size=1) for topic in topics]
    message = Twist(Vector3(speed, 0.0, 0.0), Vector3(0.0, 0.0, turn))
    repeat(period, lambda: [publisher.publish(message) for publisher in publishers])


def first(topic):
    """Say that the subscriber is there, then report when the first message came."""
    stamps = subscribed(topic)
    say(listens=True)
    await_true(lambda: stamps, COME_UP, f'a message on {topic}')
    say(first=stamps[0])


def listen(topic, seconds, turning=False):
    """Say that messages come, then report the stamps of this time."""
    if turning:
        drive(['cmd_vel'], 0.0, TURN, 0.1)
    stamps = awaited(topic)
    say(listens=True)
    time.sleep(seconds + 1.0)  # the bench settles for a second first
    end = clock()
    say(stamps=[stamp for stamp in stamps if stamp >= end - seconds])
