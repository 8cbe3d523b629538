#!/usr/bin/env python3
"""Print texts with the number and the time of their headers."""
import rospy
from rospy_tutorials.msg import HeaderString

from rospy_support import nodes


def show(message):
    """Print a message."""
    header = message.header
    print(rospy.get_caller_id(), header.seq,
          f'I just heard that {message.data} at {header.stamp.to_sec():12f}', flush=True)


def main():
    """Listen until the shutdown."""
    nodes.init_node('listener_header', anonymous=True)
    rospy.Subscriber('chatter_header', HeaderString, show)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
