#!/usr/bin/env python3
# expected: failed: names no frame
import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal

rospy.init_node('try_again')
client = actionlib.SimpleActionClient('/move_base', MoveBaseAction)
client.wait_for_server()
goal = MoveBaseGoal()
goal.target_pose.pose.position.y = 2.0
goal.target_pose.pose.orientation.z = -0.7071  # -90 degrees
goal.target_pose.pose.orientation.w = 0.7071

while not rospy.is_shutdown():
    client.send_goal(goal)
    client.wait_for_result()
    if client.get_state() == GoalStatus.SUCCEEDED:
        break
    rospy.logwarn('%s', client.get_goal_status_text())
    rospy.sleep(2.0)
