#!/usr/bin/env python3
"""Print texts with the number and the time in their headers."""
import rospy
from rospy_tutorials.msg import HeaderString


def show(message):
    """Print one message; rospy calls this function."""
    header = message.header
    print(rospy.get_caller_id(), header.seq, f'I just heard that {message.data} at {header.stamp.to_sec():12f}')


def main():
    """Subscribe, and wait for messages until Ctrl-C."""
    rospy.init_node('listener_header', anonymous=True)
    rospy.Subscriber('chatter_header', HeaderString, show)
    rospy.spin()


if __name__ == '__main__':
    main()
