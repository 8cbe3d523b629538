#!/usr/bin/env python3
"""One function for several subscriptions: the last argument of a Subscriber is passed to its function."""
import rospy
from std_msgs.msg import String


def show_numbered(message, number):
    """Print a message and the number of its Subscriber; rospy calls this function."""
    print(f'#{number}: I heard [{message.data}]')


def show(message, given):
    """Print a message and the last argument of its Subscriber; rospy calls this function."""
    print(f'I heard [{message.data}] with userdata [{given}]')


def main():
    """Subscribe four times, and wait for messages until Ctrl-C."""
    rospy.init_node('listener_with_user_data', anonymous=True)
    rospy.Subscriber('chatter', String, show_numbered, 1)
    rospy.Subscriber('chatter', String, show_numbered, 2)
    rospy.Subscriber('chatter', String, show, ('chatter1', 4))
    rospy.Subscriber('chatter2', String, show, 'This is from chatter2')
    rospy.spin()


if __name__ == '__main__':
    main()
