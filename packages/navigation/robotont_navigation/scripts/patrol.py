#!/usr/bin/env python3
import math

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

POSES = [(-2.0, 2.0, 0.0), (0.0, 2.0, -90.0), (0.0, -2.0, 180.0), (-2.0, -2.0, 90.0)]  # x, y [m], heading [degrees]

rospy.init_node('patrol')
client = actionlib.SimpleActionClient('move_base', MoveBaseAction)
client.wait_for_server()
for x, y, degrees in POSES:
    goal = MoveBaseGoal()
    goal.target_pose.header.frame_id = 'map'
    goal.target_pose.pose.position.x = x
    goal.target_pose.pose.position.y = y
    goal.target_pose.pose.orientation.z = math.sin(math.radians(degrees) / 2)
    goal.target_pose.pose.orientation.w = math.cos(math.radians(degrees) / 2)
    client.send_goal(goal)
    client.wait_for_result()
    if client.get_state() != GoalStatus.SUCCEEDED:
        rospy.logerr('%s', client.get_goal_status_text())
        break
    rospy.loginfo('Reached x = %.1f, y = %.1f', x, y)
    rospy.sleep(5.0)
