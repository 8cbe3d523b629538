#!/usr/bin/env python3
# expected: failed: off
import rosbag
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

rospy.init_node('record_and_play')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)

poses = []
subscriber = rospy.Subscriber('/turtle1/pose', Pose, lambda pose: poses.append((pose, rospy.Time.now())))
rospy.sleep(8)
subscriber.unregister()
with rosbag.Bag('poses.bag', 'w') as bag:
    for pose, time in poses:
        bag.write('/turtle1/pose', pose, time)

with rosbag.Bag('poses.bag') as bag:
    print(bag.get_message_count(), 'poses')
    before = None
    for _, pose, time in bag.read_messages('/turtle1/pose'):
        if before:
            rospy.sleep(time - before)
        before = time
        twist = Twist()
        twist.linear.x, twist.angular.z = pose.linear_velocity, -pose.angular_velocity
        publisher.publish(twist)
