#!/usr/bin/env python3
import rospy
import tf
from turtlesim.msg import Pose


def send(pose):
    position = (pose.x, pose.y, 0)
    # solution
    rotation = tf.transformations.quaternion_from_euler(0, 0, pose.theta)
    broadcaster.sendTransform(position, rotation, rospy.Time.now(), turtle, 'world')
    # end of solution


rospy.init_node('tf_broadcaster')
turtle = rospy.get_param('~turtle', 'turtle1')
broadcaster = tf.TransformBroadcaster()
rospy.Subscriber('/' + turtle + '/pose', Pose, send)
rospy.spin()
