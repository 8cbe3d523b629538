#!/usr/bin/env python3
"""Pattern of the colour trackers: trackbars before init_node, a loop that reads them, ended by a key."""
import cv2
import numpy
import rospy
from sensor_msgs.msg import Image

from cv_bridge import CvBridge

frame = None


def got(message):
    global frame
    frame = CvBridge().imgmsg_to_cv2(message, 'bgr8')


def nothing(value):
    pass


def pick(event, x, y, flags, param):
    if event == cv2.EVENT_LBUTTONDOWN:
        print('picked', frame[y, x].tolist(), flags == cv2.EVENT_FLAG_LBUTTON, param, flush=True)


cv2.namedWindow('Track Bars')
cv2.createTrackbar('Low H', 'Track Bars', 0, 179, nothing)
cv2.createTrackbar('High H', 'Track Bars', 179, 179, lambda value: print('high', value, flush=True))
rospy.init_node('tracker', anonymous=True)
rospy.Subscriber('/camera/rgb/image_raw', Image, got)
while not rospy.is_shutdown():
    if frame is not None:
        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV)
        low, high = cv2.getTrackbarPos('Low H', 'Track Bars'), cv2.getTrackbarPos('High H', 'Track Bars')
        cv2.imshow('mask', cv2.inRange(hsv, numpy.array([low, 1, 1]), numpy.array([high, 255, 255])))
        cv2.imshow('frame', frame)
        cv2.setMouseCallback('frame', pick, 'frame')
    key = cv2.waitKey(10) & 0xFF
    if key == ord('q'):
        break
cv2.destroyAllWindows()
print('ended by q', flush=True)
