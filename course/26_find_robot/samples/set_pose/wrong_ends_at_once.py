#!/usr/bin/env python3
# expected: failed: ended too early
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped

rospy.init_node('set_pose')
pose_publisher = rospy.Publisher('/initialpose', PoseWithCovarianceStamped, queue_size=1)
rate = rospy.Rate(10)
while pose_publisher.get_num_connections() == 0 and not rospy.is_shutdown():
    rate.sleep()

message = PoseWithCovarianceStamped()
message.header.stamp = rospy.Time.now()
message.header.frame_id = 'map'
message.pose.pose.position.x = message.pose.pose.position.y = -2.0
message.pose.pose.orientation.z = message.pose.pose.orientation.w = 0.7071  # 90 degrees
message.pose.covariance[0] = message.pose.covariance[7] = message.pose.covariance[35] = 0.04
pose_publisher.publish(message)
