#!/usr/bin/env python3
import math

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped, Twist
from tf.transformations import quaternion_from_euler
from turtlesim.msg import Pose
from turtlesim.srv import Spawn


def send(pose, turtle):
    transform = TransformStamped()
    transform.header.stamp = rospy.Time.now()
    transform.header.frame_id = 'world'
    transform.child_frame_id = turtle
    translation, rotation = transform.transform.translation, transform.transform.rotation
    translation.x, translation.y = pose.x, pose.y
    rotation.x, rotation.y, rotation.z, rotation.w = quaternion_from_euler(0, 0, pose.theta)
    broadcaster.sendTransform(transform)


rospy.init_node('tf2_follower')
broadcaster = tf2_ros.TransformBroadcaster()
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
rospy.wait_for_service('spawn')
rospy.ServiceProxy('spawn', Spawn)(4, 2, 0, 'turtle2')
for name in 'turtle1', 'turtle2':
    rospy.Subscriber(f'/{name}/pose', Pose, send, name)
publisher = rospy.Publisher('/turtle2/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    try:
        to = buffer.lookup_transform('turtle2', 'turtle1', rospy.Time()).transform.translation
    except (tf2_ros.LookupException, tf2_ros.ConnectivityException, tf2_ros.ExtrapolationException):
        rate.sleep()
        continue
    velocity = Twist()
    velocity.linear.x = 0.5 * math.hypot(to.x, to.y)
    velocity.angular.z = 4 * math.atan2(to.y, to.x)
    publisher.publish(velocity)
    rate.sleep()
