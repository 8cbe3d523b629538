#!/usr/bin/env python3
"""One function for several subscriptions: what is given to a Subscriber is handed on to its function."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes


def show(message, given):
    """Print a message and what was given to its Subscriber."""
    if given in (1, 2):
        print(f'#{given}: I heard [{message.data}]', flush=True)
    else:
        print(f'I heard [{message.data}] with userdata [{given}]', flush=True)


def main():
    """Listen until the shutdown."""
    nodes.init_node('listener_with_user_data', anonymous=True)
    for topic, given in (('chatter', 1), ('chatter', 2), ('chatter', ('chatter1', 4)),
                         ('chatter2', 'This is from chatter2')):
        rospy.Subscriber(topic, String, show, given)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
