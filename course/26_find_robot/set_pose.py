#!/usr/bin/env python3
import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped, Twist

rospy.init_node('set_pose')
pose_publisher = rospy.Publisher('/initialpose', PoseWithCovarianceStamped, queue_size=1)
velocity_publisher = rospy.Publisher('/cmd_vel', Twist, queue_size=1)
rate = rospy.Rate(10)
# solution
while pose_publisher.get_num_connections() == 0 and not rospy.is_shutdown():
    rate.sleep()
guess = PoseWithCovarianceStamped()
guess.header.frame_id = 'map'
guess.pose.pose.position.x = -2.0
guess.pose.pose.position.y = -2.0
guess.pose.pose.orientation.z = 0.7071  # 90 degrees
guess.pose.pose.orientation.w = 0.7071
guess.pose.covariance[0] = guess.pose.covariance[7] = guess.pose.covariance[35] = 0.04
pose_publisher.publish(guess)
# end of solution
velocity = Twist()
velocity.angular.z = 0.8
while not rospy.is_shutdown():
    velocity_publisher.publish(velocity)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        break
