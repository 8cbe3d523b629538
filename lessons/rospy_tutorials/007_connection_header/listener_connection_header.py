#!/usr/bin/env python3
"""Print who has sent each text on chatter, and what that node has said when it connected."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes
from rospy_support.rospy_internals import connection_header


def show(message):
    """Print a message."""
    header = connection_header(message)
    who = header.get('callerid', 'unknown')
    if 'cookies' in header:
        print(f'{who} just offered me {header["cookies"]} cookies', flush=True)
    else:
        print(f'I just heard {message.data} from {who}', flush=True)


def main():
    """Listen until the shutdown."""
    nodes.init_node('listener_connection_header', anonymous=True)
    rospy.Subscriber('chatter', String, show)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
