#!/usr/bin/env python3
"""Send each pose of a turtle to tf2, as the transform from the frame world to the frame of the turtle."""
import math
import sys

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from turtlesim.msg import Pose


def main():
    """Send poses until Ctrl-C."""
    rospy.init_node('turtle_tf2_broadcaster')
    turtle = rospy.get_param('~turtle', '')
    if not turtle:
        sys.exit('Which turtle? Type: rosrun turtle_tf2 turtle_tf2_broadcaster.py _turtle:=turtle1')
    broadcaster = tf2_ros.TransformBroadcaster()

    def send(pose):
        message = TransformStamped()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = 'world'
        message.child_frame_id = turtle
        message.transform.translation.x = pose.x
        message.transform.translation.y = pose.y
        message.transform.rotation.z = math.sin(pose.theta / 2.0)  # the quaternion of a turn around the z axis
        message.transform.rotation.w = math.cos(pose.theta / 2.0)
        broadcaster.sendTransform(message)

    poses = rospy.Subscriber(f'/{turtle}/pose', Pose, send)
    rospy.on_shutdown(poses.unregister)  # nothing can be sent any more then
    rospy.spin()


if __name__ == '__main__':
    main()
