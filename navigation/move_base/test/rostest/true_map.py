#!/usr/bin/env python3
"""Publish the walls of the simulated world as the map, in the place of map_server, and map -> odom, in that of amcl.

Without noise, the odometry of the simulated robot is its pose in the world.
"""
import json

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import OccupancyGrid
from std_msgs.msg import String

RESOLUTION, SIZE = 0.05, 160  # [m], cells
LOWEST = 0.15  # [m] that the laser scanner sees


def map_of(world):
    """Return the OccupancyGrid of a world's boxes, which have no yaw."""
    middles = (np.arange(SIZE) + 0.5 - SIZE / 2) * RESOLUTION
    x, y = np.meshgrid(middles, middles)
    cells = np.zeros((SIZE, SIZE), np.int8)
    for box in world['boxes']:
        if box['height'] > LOWEST:
            cells[(abs(x - box['x']) <= (box['length'] + RESOLUTION) / 2.0)
                  & (abs(y - box['y']) <= (box['width'] + RESOLUTION) / 2.0)] = 100
    grid = OccupancyGrid(data=cells.ravel().tolist())
    grid.header.frame_id = 'map'
    grid.info.resolution, grid.info.width, grid.info.height = RESOLUTION, SIZE, SIZE
    grid.info.origin.position.x = grid.info.origin.position.y = -SIZE * RESOLUTION / 2.0
    grid.info.origin.orientation = Quaternion(0.0, 0.0, 0.0, 1.0)
    return grid


if __name__ == '__main__':
    rospy.init_node('true_map')
    publisher = rospy.Publisher('map', OccupancyGrid, latch=True, queue_size=1)
    publisher.publish(map_of(json.loads(rospy.wait_for_message('/robotont_gazebo/world', String).data)))
    broadcaster = tf2_ros.StaticTransformBroadcaster()
    transform = TransformStamped(child_frame_id='odom')
    transform.header.frame_id, transform.transform.rotation.w = 'map', 1.0
    broadcaster.sendTransform(transform)
    rospy.spin()
