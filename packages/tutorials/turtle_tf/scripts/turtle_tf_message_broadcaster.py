#!/usr/bin/env python3
"""Spawn turtle3, drive it around a circle, and publish where it is as points in the frame world."""
import rospy
from geometry_msgs.msg import PointStamped, Twist
from turtlesim.msg import Pose
from turtlesim.srv import Spawn


def publish(pose, publisher):
    """Publish one pose as a point; rospy calls this function."""
    message = PointStamped()
    message.header.stamp = rospy.Time.now()
    message.header.frame_id = '/world'
    message.point.x = pose.x
    message.point.y = pose.y
    publisher.publish(message)


def main():
    """Drive until Ctrl-C."""
    rospy.init_node('turtle_tf_msg_broadcaster')
    rospy.wait_for_service('spawn')
    try:
        rospy.ServiceProxy('spawn', Spawn)(4.0, 2.0, 0.0, 'turtle3')
    except rospy.ServiceException as error:
        rospy.logwarn('%s: the one that is there drives', error)
    points = rospy.Publisher('turtle_point_stamped', PointStamped, queue_size=1)
    poses = rospy.Subscriber('/turtle3/pose', Pose, publish, points)
    rospy.on_shutdown(poses.unregister)  # nothing can be sent any more then
    velocities = rospy.Publisher('turtle3/cmd_vel', Twist, queue_size=1)
    rospy.on_shutdown(lambda: velocities.publish(Twist()))  # stop
    circle = Twist()
    circle.linear.x = 1.0  # [m/s]
    circle.angular.z = 1.0  # [rad/s]
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        velocities.publish(circle)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
