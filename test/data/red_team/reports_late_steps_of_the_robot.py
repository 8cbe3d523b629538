#!/usr/bin/env python3
# expected: failed
# exercise: robot_circle
# kind: says that the machine is slow
"""Says again and again, to whoever listens, that the simulator of the robot could not keep up."""
import rospy
from sim_ros.msg import ClockStatus

rospy.init_node('late')
status = rospy.Publisher('/robotont_gazebo/clock_status', ClockStatus, queue_size=1)
rospy.names._set_caller_id('/robotont_gazebo')
rate = rospy.Rate(30)
while not rospy.is_shutdown():
    status.publish(ClockStatus(late_steps=1000))
    rate.sleep()
