#!/usr/bin/env python3
import rosbag
import rospy
from geometry_msgs.msg import Twist
from turtlesim.msg import Pose

received = []


def receive(pose):
    received.append((pose, rospy.Time.now()))


rospy.init_node('record_and_play')
publisher = rospy.Publisher('/turtle1/cmd_vel', Twist, queue_size=10)
subscriber = rospy.Subscriber('/turtle1/pose', Pose, receive)
rospy.loginfo('Recording for 8 s')
rospy.sleep(8)
subscriber.unregister()
# solution
with rosbag.Bag('poses.bag', 'w') as bag:
    for pose, time in received:
        bag.write('/turtle1/pose', pose, time)

last = None
with rosbag.Bag('poses.bag') as bag:
    rospy.loginfo('%d poses are in the bag', bag.get_message_count())
    for _, pose, time in bag.read_messages('/turtle1/pose'):
        if last is not None:
            rospy.sleep(time - last)
        last = time
        velocity = Twist()
        velocity.linear.x = pose.linear_velocity
        velocity.angular.z = pose.angular_velocity
        publisher.publish(velocity)
# end of solution
