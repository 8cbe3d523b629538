#!/usr/bin/env python3
"""Pattern of the line followers of courses: a window in the callback of the camera, waitKey(3) there, spin."""
import cv2
import numpy
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import Image

import cv_bridge


class Follower:

    def __init__(self):
        self.bridge = cv_bridge.CvBridge()
        cv2.namedWindow('window', 1)
        self.image_sub = rospy.Subscriber('camera/rgb/image_raw', Image, self.image_callback)
        self.cmd_vel_pub = rospy.Publisher('cmd_vel', Twist, queue_size=1)

    def image_callback(self, msg):
        image = self.bridge.imgmsg_to_cv2(msg, desired_encoding='bgr8')
        hsv = cv2.cvtColor(image, cv2.COLOR_BGR2HSV)
        mask = cv2.inRange(hsv, numpy.array([10, 10, 10]), numpy.array([255, 255, 250]))
        moments = cv2.moments(mask)
        if moments['m00'] > 0:
            cx = int(moments['m10'] / moments['m00'])
            cv2.circle(image, (cx, 40), 20, (0, 0, 255), -1)
            twist = Twist()
            twist.linear.x = 0.2
            twist.angular.z = -(cx - image.shape[1] / 2) / 100
            self.cmd_vel_pub.publish(twist)
        cv2.imshow('window', image)
        cv2.waitKey(3)


rospy.init_node('follower')
follower = Follower()
rospy.spin()
