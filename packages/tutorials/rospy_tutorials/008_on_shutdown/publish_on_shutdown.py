#!/usr/bin/env python3
"""Publish a last text when the node ends."""
import rospy
from std_msgs.msg import String


def main():
    """Wait until Ctrl-C."""
    rospy.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, queue_size=10)

    def say_goodbye():
        print("I'm dead!")
        publisher.publish("I'm dead!")

    rospy.on_shutdown(say_goodbye)
    print('Hit ctrl-C to see on_shutdown example')
    rospy.spin()


if __name__ == '__main__':
    main()
