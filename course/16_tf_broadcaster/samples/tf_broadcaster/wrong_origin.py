#!/usr/bin/env python3
# expected: failed: 0 at its position
import rospy
import tf
from turtlesim.msg import Pose

broadcaster = tf.TransformBroadcaster()


def send(pose):
    turned = tf.transformations.quaternion_from_euler(0, 0, pose.theta)
    broadcaster.sendTransform((0, 0, 0), turned, rospy.Time.now(), 'turtle1', 'world')


rospy.init_node('turtle_tf_broadcaster')
rospy.Subscriber('/turtle1/pose', Pose, send)
rospy.spin()
