#!/usr/bin/env python3
# expected: failed: turtle1 to world
import rospy
import tf
from turtlesim.msg import Pose

broadcaster = tf.TransformBroadcaster()


def send(pose):
    turned = tf.transformations.quaternion_from_euler(0, 0, pose.theta)
    broadcaster.sendTransform((pose.x, pose.y, 0), turned, rospy.Time.now(), 'world', 'turtle1')


rospy.init_node('turtle_tf_broadcaster')
rospy.Subscriber('/turtle1/pose', Pose, send)
rospy.spin()
