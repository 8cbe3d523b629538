#!/usr/bin/env python3
# expected: failed: required check failed: transforms
import rospy
import tf
from turtlesim.msg import Pose

broadcaster = tf.TransformBroadcaster()


def send(pose):
    turned = tf.transformations.quaternion_from_euler(0, 0, 0)
    broadcaster.sendTransform((pose.x, pose.y, 0), turned, rospy.Time.now(), 'turtle1', 'world')


rospy.init_node('turtle_tf_broadcaster')
rospy.Subscriber('/turtle1/pose', Pose, send)
rospy.spin()
