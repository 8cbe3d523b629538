#!/usr/bin/env python3
"""Publish on chatter, and tell every subscriber something more when it connects."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes


def main():
    """Publish until the shutdown."""
    nodes.init_node('talker', anonymous=True)
    publisher, rate = rospy.Publisher('chatter', String, headers={'cookies': 'oreo'}, queue_size=10), rospy.Rate(10)
    while not rospy.is_shutdown():
        text = f'hello world {rospy.get_time()}'
        rospy.loginfo(text)
        publisher.publish(text)
        rate.sleep()


if __name__ == '__main__':
    nodes.run(main)
