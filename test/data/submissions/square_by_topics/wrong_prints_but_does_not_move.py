#!/usr/bin/env python3
# expected: failed: it did not move
import rospy

rospy.init_node('square')
for x, y in [(2, 2), (8, 2), (8, 8), (2, 8)]:
    rospy.loginfo('The turtle is at %d, %d', x, y)
    rospy.sleep(1.0)
rospy.loginfo('The square is drawn, score: 100 of 100')
