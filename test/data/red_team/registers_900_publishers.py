#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: floods with publishers
"""Registers 900 publishers that do not exist, of which the master tells the simulator each time."""
import rosgraph
import rospy

rospy.init_node('many')
for number in range(900):
    master = rosgraph.Master(f'/node_{number}')
    master.registerPublisher('/turtle1/cmd_vel', 'geometry_msgs/Twist', f'http://localhost:{100 + number}/')
rospy.spin()
