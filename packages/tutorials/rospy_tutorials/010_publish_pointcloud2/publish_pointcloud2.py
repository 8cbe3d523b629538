#!/usr/bin/env python3
"""Publish a wave as a point cloud on the topic points2, for rviz."""
import numpy as np
import rospy
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

NAMES = 'x', 'y', 'z', 'intensity'
FIELDS = [PointField(name, 4 * index, PointField.FLOAT32, 1) for index, name in enumerate(NAMES)]  # of 4 bytes each


def wave(count):
    """Return the points of one step of the wave, an array with a row [x, y, z, intensity] for each point [m]."""
    x, y = np.meshgrid(np.linspace(-2.0, 2.0, 100), np.linspace(-2.0, 2.0, 100))
    z = 0.5 * np.sin(2.0 * x - 0.1 * count) * np.sin(2.0 * y)
    return np.stack([x, y, z, z], axis=-1).reshape(-1, 4)


def main():
    """Publish ten clouds a second until Ctrl-C."""
    rospy.init_node('pc2_publisher')
    publisher = rospy.Publisher('points2', PointCloud2, queue_size=2)
    rate = rospy.Rate(10)  # [Hz]
    count = 0
    while not rospy.is_shutdown():
        header = Header(stamp=rospy.Time.now(), frame_id='map')
        publisher.publish(point_cloud2.create_cloud(header, FIELDS, wave(count)))
        count += 1
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
