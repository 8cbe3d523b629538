#!/usr/bin/env python3
# expected: failed
# exercise: background_by_parameters
# kind: floods with names, parameters, connections
"""Sets 100,000 parameters with long names."""
import rosgraph
import rospy

rospy.init_node('many')
master = rosgraph.Master('/many')
for number in range(1000):
    master.setParam(f'/n{number}' + 'x' * 1000, {f'k{key}': 'v' * 100 for key in range(100)})
rospy.spin()
