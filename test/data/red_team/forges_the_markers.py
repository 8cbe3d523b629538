#!/usr/bin/env python3
# expected: failed: the marker is ahead by
# exercise: keep_distance
# kind: forges what sensors say
"""Publishes a marker where it should be, on the topic and under the name of the grader, and does not drive."""
import rosgraph
import rospy
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers

rospy.init_node('keeper')
rospy.Subscriber('/ar_pose_marker', AlvarMarkers, lambda markers: None)
names = {node for kind in rosgraph.Master('/x').getSystemState() for _, nodes in kind for node in nodes}
publisher = rospy.Publisher('/ar_pose_marker', AlvarMarkers, queue_size=10)
rospy.names._set_caller_id(next(name for name in names if 'grader' in name))
marker = AlvarMarker(id=1)
marker.pose.pose.position.x = 0.6
rate = rospy.Rate(30)
while not rospy.is_shutdown():
    publisher.publish(AlvarMarkers(markers=[marker]))
    rate.sleep()
