"""The node laserscan_to_distance, of which the course knows two: one in an older package, with names of its own.

Threading contract: the thread of the subscription to the scan does everything.
"""
from __future__ import annotations

from typing import Callable

import rospy
from sensor_msgs.msg import LaserScan

from rospy_support import nodes
from rospy_support.topics import Publisher

NAME = 'laserscan_to_distance'


def run(kind: type, convert: Callable[[LaserScan], object], scan_topic: str, distance_topic: str) -> None:
    """Publish ``convert(scan)``, a message of the class ``kind``, for each scan."""
    nodes.init_node(NAME, anonymous=True)
    publisher = Publisher(distance_topic, kind, queue_size=1)
    rospy.Subscriber(scan_topic, LaserScan, lambda scan: publisher.publish(convert(scan)), queue_size=1,
                     tcp_nodelay=True)
    rospy.spin()
