#!/usr/bin/env python3
"""Publish a wave as a point cloud on points2, for rviz."""
import numpy as np
import rospy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from rospy_support import nodes

SIDE, POINTS = 2.0, 100  # [m] from the middle to the edge; points along it
FIELDS = [PointField(name, 4 * index, PointField.FLOAT32, 1) for index, name in enumerate(('x', 'y', 'z', 'intensity'))]


def wave(count):
    """Return the points of the wave in a step, an array with a row [x, y, z, intensity] for each."""
    along = np.linspace(-SIDE, SIDE, POINTS)
    x, y = np.meshgrid(along, along)
    z = 0.5 * np.sin(2.0 * x - 0.1 * count) * np.sin(2.0 * y)
    return np.stack([x, y, z, z], axis=-1).reshape(-1, 4)


def main():
    """Publish ten clouds a second until the shutdown."""
    nodes.init_node('pc2_publisher')
    publisher, rate = rospy.Publisher('points2', PointCloud2, queue_size=2), rospy.Rate(10)
    count = 0
    while not rospy.is_shutdown():
        header = Header(stamp=rospy.Time.now(), frame_id='map')
        publisher.publish(point_cloud2.create_cloud(header, FIELDS, wave(count)))
        count += 1
        rate.sleep()


if __name__ == '__main__':
    nodes.run(main)
