#!/usr/bin/env python3
"""Publish the walls of the simulated world as the map, in the place of map_server, and map -> odom, in that of amcl.

Without noise, the odometry of the simulated robot is its pose in the world.
"""
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import String

from kinematic_core.worlds import world_format
from kinematic_core.worlds.frames import LIDAR_Z
from navigation_core.maps.scores import true_map
from navigation_core.ros import grids

RESOLUTION = 0.05  # [m] a cell

if __name__ == '__main__':
    rospy.init_node('true_map')
    plan = world_format.parse_json(rospy.wait_for_message('/robotont_gazebo/world', String).data)
    publisher = rospy.Publisher('map', grids.Grid, latch=True, queue_size=1)
    publisher.publish(grids.to_message(true_map(plan.outlines(LIDAR_Z), RESOLUTION), 'map'))
    broadcaster = tf2_ros.StaticTransformBroadcaster()
    transform = TransformStamped(child_frame_id='odom')
    transform.header.frame_id, transform.transform.rotation.w = 'map', 1.0
    broadcaster.sendTransform(transform)
    rospy.spin()
