#!/usr/bin/env python3
# expected: failed: do not belong there
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose


class Logger:
    def __init__(self):
        rospy.init_node('log_levels', log_level=rospy.DEBUG)
        self.x = None
        self.pub = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
        rospy.Subscriber('/turtle1/pose', Pose, self.pose)
        rospy.Timer(rospy.Duration(0.1), self.drive)
        rospy.Timer(rospy.Duration(0.25), self.log)

    def pose(self, p):
        self.x = p.x

    def drive(self, _):
        t = Twist()
        t.linear.x = 1.0
        self.pub.publish(t)

    def log(self, _):
        if self.x is None:
            return
        text = f'x is {self.x:.2f}'
        if self.x < 6:
            rospy.logdebug(text)
        if self.x >= 6:
            rospy.loginfo(text)
        if self.x >= 8:
            rospy.logwarn(text)
        if self.x >= 10:
            rospy.logerr(text)


Logger()
rospy.spin()
