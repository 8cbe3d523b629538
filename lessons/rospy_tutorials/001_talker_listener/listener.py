#!/usr/bin/env python3
"""Log every text that comes on chatter."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes


def log(message):
    """Log a message with the name of this node."""
    rospy.loginfo('%sI heard %s', rospy.get_caller_id(), message.data)


def main():
    """Listen until the shutdown."""
    nodes.init_node('listener', anonymous=True)
    rospy.Subscriber('chatter', String, log)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
