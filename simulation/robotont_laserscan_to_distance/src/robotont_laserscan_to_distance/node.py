"""The node laserscan_to_distance: the nearest obstacle to the left, ahead and to the right, for each scan.

Threading contract: the thread of the subscription to the scan does everything.
"""
import rospy
from sensor_msgs.msg import LaserScan

from robotont_laserscan_to_distance.core.sectors import split
from robotont_laserscan_to_distance.msg import LaserScanSplit
from rospy_support import nodes
from rospy_support.topics import Publisher

NAME = 'laserscan_to_distance'


def message_of(scan):
    """Return the LaserScanSplit of a LaserScan."""
    right, center, left = split(scan.ranges)
    return LaserScanSplit(header=scan.header, left_min=left.nearest, center_min=center.nearest,
                          right_min=right.nearest, left_mean=left.mean, center_mean=center.mean, right_mean=right.mean)


def run(kind, convert, scan_topic, distance_topic):
    """Publish ``convert(scan)``, a message of the class ``kind``, for each scan."""
    nodes.init_node(NAME, anonymous=True)
    publisher = Publisher(distance_topic, kind, queue_size=1)
    rospy.Subscriber(scan_topic, LaserScan, lambda scan: publisher.publish(convert(scan)), queue_size=1,
                     tcp_nodelay=True)
    rospy.spin()


def main():
    """Run laserscan_to_distance."""
    run(LaserScanSplit, message_of, 'scan', 'scan_to_distance')
