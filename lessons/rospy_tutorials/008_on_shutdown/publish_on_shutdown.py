#!/usr/bin/env python3
"""Publish a last text when the node ends."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes

LAST_WORDS = "I'm dead!"


def main():
    """Wait for the shutdown."""
    nodes.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, queue_size=10)

    def say_goodbye():
        print(LAST_WORDS, flush=True)
        publisher.publish(LAST_WORDS)
    rospy.on_shutdown(say_goodbye)
    print('Hit ctrl-C to see on_shutdown example', flush=True)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
