#!/usr/bin/env python3
# expected: failed
# exercise: print_marker_ids
# kind: shows markers itself
"""Shows markers of its own, with the name of the grader's node and on its topic, and prints them."""
import rosgraph
import rospy
from ar_track_alvar_msgs.msg import AlvarMarker, AlvarMarkers

names = {node for _, nodes in rosgraph.Master('/x').getSystemState()[0] for node in nodes}
rospy.init_node('markers')
publisher = rospy.Publisher('ar_pose_marker', AlvarMarkers, queue_size=10)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    publisher.publish(AlvarMarkers(markers=[AlvarMarker(id=7)]))
    print('Detected marker with ID 7', flush=True)
    rate.sleep()
