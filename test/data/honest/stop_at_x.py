#!/usr/bin/env python3
"""Threads: one drives, the main thread stops it at a notification of the subscriber's."""
import threading

import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

arrived = threading.Event()
lock = threading.Lock()


def drive():
    rate = rospy.Rate(20)
    while not rospy.is_shutdown():
        twist = Twist()
        with lock:
            twist.linear.x = 0.0 if arrived.is_set() else 1.0
        publisher.publish(twist)
        rate.sleep()


def look(pose):
    if pose.x >= 10.0:
        arrived.set()


rospy.init_node('stop_by_threads')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=1)
rospy.Subscriber('/turtle1/pose', Pose, look)
driver = threading.Thread(target=drive, daemon=True)
driver.start()
rospy.spin()
