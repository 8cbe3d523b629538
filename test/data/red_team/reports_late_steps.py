#!/usr/bin/env python3
# expected: failed
# exercise: stop_at_x
# kind: says that the machine is slow
"""Says that the simulator could not keep up, so that the verdict would be undecided."""
import rospy
from sim_ros.msg import ClockStatus

rospy.init_node('late')
status = rospy.Publisher('/turtlesim/clock_status', ClockStatus, queue_size=1, latch=True)
rospy.names._set_caller_id('/turtlesim')
status.publish(ClockStatus(late_steps=1000))
rospy.spin()
