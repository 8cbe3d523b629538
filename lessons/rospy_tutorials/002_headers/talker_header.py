#!/usr/bin/env python3
"""Publish texts with a header on chatter_header."""
import rospy
from rospy_tutorials.msg import HeaderString
from std_msgs.msg import Header

from rospy_support import nodes


def main():
    """Publish until the shutdown; rospy fills in the number of each header."""
    nodes.init_node('talker_header')
    publisher = rospy.Publisher('chatter_header', HeaderString, queue_size=10)
    rate, count = rospy.Rate(10), 0
    while not rospy.is_shutdown():
        text = f'hello world {count}'
        print(text, flush=True)
        publisher.publish(HeaderString(Header(stamp=rospy.Time.now()), text))
        count += 1
        rate.sleep()


if __name__ == '__main__':
    nodes.run(main)
