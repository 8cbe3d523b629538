#!/usr/bin/env python3
# expected: failed: with the current time as their stamp
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from tf.transformations import quaternion_from_euler
from turtlesim.msg import Pose


class Broadcaster:
    def __init__(self):
        self.br = tf2_ros.TransformBroadcaster()
        self.t = TransformStamped()
        self.t.header.frame_id = 'world'
        self.t.child_frame_id = 'turtle1'
        self.t.header.stamp = rospy.Time.now()
        rospy.Subscriber('/turtle1/pose', Pose, self.cb)

    def cb(self, msg):
        self.t.transform.translation.x = msg.x
        self.t.transform.translation.y = msg.y
        q = quaternion_from_euler(0, 0, msg.theta)
        self.t.transform.rotation.x = q[0]
        self.t.transform.rotation.y = q[1]
        self.t.transform.rotation.z = q[2]
        self.t.transform.rotation.w = q[3]
        self.br.sendTransform(self.t)


rospy.init_node('tf_broadcaster')
Broadcaster()
rospy.spin()
