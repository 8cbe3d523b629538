#!/usr/bin/env python3
"""Send each pose of a turtle to tf, as the transform from the frame world to the frame of the turtle."""
import sys

import rospy
import tf
from turtlesim.msg import Pose


def main():
    """Send poses until Ctrl-C."""
    rospy.init_node('turtle_tf_broadcaster')
    turtle = rospy.get_param('~turtle', '')
    if not turtle:
        sys.exit('Which turtle? Type: rosrun turtle_tf turtle_tf_broadcaster.py _turtle:=turtle1')
    broadcaster = tf.TransformBroadcaster()

    def send(pose):
        turned = tf.transformations.quaternion_from_euler(0.0, 0.0, pose.theta)
        broadcaster.sendTransform((pose.x, pose.y, 0.0), turned, rospy.Time.now(), turtle, 'world')

    poses = rospy.Subscriber(f'/{turtle}/pose', Pose, send)
    rospy.on_shutdown(poses.unregister)  # nothing can be sent any more then
    rospy.spin()


if __name__ == '__main__':
    main()
