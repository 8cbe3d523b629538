#!/usr/bin/env python3
"""Print who has sent each text on the topic chatter, and the header that this node sent when it connected."""
import rospy
from std_msgs.msg import String


def show(message):
    """Print one message; rospy calls this function."""
    header = message._connection_header  # a dictionary
    who = header['callerid']
    if 'cookies' in header:
        print(f'{who} just offered me {header["cookies"]} cookies')
    else:
        print(f'I just heard {message.data} from {who}')


def main():
    """Subscribe, and wait for messages until Ctrl-C."""
    rospy.init_node('listener_connection_header', anonymous=True)
    rospy.Subscriber('chatter', String, show)
    rospy.spin()


if __name__ == '__main__':
    main()
