#!/usr/bin/env python3
"""Log every text that arrives on the topic chatter."""
import rospy
from std_msgs.msg import String


def log(message):
    """Log one message, after the name of this node; rospy calls this function."""
    rospy.loginfo('%sI heard %s', rospy.get_caller_id(), message.data)


def main():
    """Subscribe, and wait for messages until Ctrl-C."""
    rospy.init_node('listener', anonymous=True)
    rospy.Subscriber('chatter', String, log)
    rospy.spin()


if __name__ == '__main__':
    main()
