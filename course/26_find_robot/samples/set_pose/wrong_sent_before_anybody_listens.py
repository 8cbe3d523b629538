#!/usr/bin/env python3
# expected: failed: half of the time within
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist

rospy.init_node('set_pose')
pose_publisher = rospy.Publisher('/initialpose', PoseWithCovarianceStamped, queue_size=1)
velocity_publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
message = PoseWithCovarianceStamped()
message.header.stamp = rospy.Time.now()
message.header.frame_id = 'map'
message.pose.pose.position.x = message.pose.pose.position.y = -2.0
message.pose.pose.orientation.z = message.pose.pose.orientation.w = 0.7071  # 90 degrees
message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[35] = 0.04
pose_publisher.publish(message)

twist = Twist()
twist.angular.z = 0.8
while not rospy.is_shutdown():
    velocity_publisher.publish(twist)
    rate.sleep()
