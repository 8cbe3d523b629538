#!/usr/bin/env python3
# expected: failed: 0 of 1 reached
import actionlib
import rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

rospy.init_node('try_again')
client = actionlib.SimpleActionClient('/move_base', MoveBaseAction)
client.wait_for_server()
goal = MoveBaseGoal()
goal.target_pose.header.frame_id = 'map'
goal.target_pose.pose.position.y = 2.0
goal.target_pose.pose.orientation.z = -0.7071  # -90 degrees
goal.target_pose.pose.orientation.w = 0.7071

for _ in range(3):
    client.send_goal(goal)
    client.wait_for_result()
