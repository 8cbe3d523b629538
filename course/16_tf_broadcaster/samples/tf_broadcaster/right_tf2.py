#!/usr/bin/env python3
import geometry_msgs.msg
import rospy
import tf2_ros
import tf_conversions
import turtlesim.msg


def on_pose(pose, turtle):
    broadcaster = tf2_ros.TransformBroadcaster()
    transform = geometry_msgs.msg.TransformStamped()
    transform.header.stamp = rospy.Time.now()
    transform.header.frame_id = 'world'
    transform.child_frame_id = turtle
    transform.transform.translation.x = pose.x
    transform.transform.translation.y = pose.y
    rotation = tf_conversions.transformations.quaternion_from_euler(0, 0, pose.theta)
    transform.transform.rotation = geometry_msgs.msg.Quaternion(*rotation)
    broadcaster.sendTransform(transform)


if __name__ == '__main__':
    rospy.init_node('tf2_broadcaster')
    name = rospy.get_param('~turtle', 'turtle1')
    rospy.Subscriber(f'/{name}/pose', turtlesim.msg.Pose, on_pose, name)
    rospy.spin()
