#!/usr/bin/env python3
import rospy
from dynamic_reconfigure.client import Client

rospy.init_node('tune_move_base')
client = Client('/move_base/TrajectoryPlannerROS', timeout=30)
before = client.get_configuration()
# solution
values = {'acc_lim_x': 1.0, 'acc_lim_theta': 2.0, 'xy_goal_tolerance': 0.1, 'yaw_goal_tolerance': 0.1}
# end of solution
client.update_configuration(values)
for name, value in values.items():
    rospy.loginfo('%s: from %.2f to %.2f', name, before[name], value)
