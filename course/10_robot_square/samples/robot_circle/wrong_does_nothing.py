#!/usr/bin/env python3
# expected: failed: it did not move
import rospy

rospy.init_node('circle')
