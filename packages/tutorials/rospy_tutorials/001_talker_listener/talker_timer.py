#!/usr/bin/env python3
"""Publish a text on the topic chatter ten times a second, by a timer."""
import rospy
from std_msgs.msg import String


def main():
    """Start the timer, and wait until Ctrl-C."""
    rospy.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, queue_size=10)

    def publish(event):
        text = f'hello world {event.current_real.to_sec()}'
        rospy.loginfo(text)
        publisher.publish(text)

    rospy.Timer(rospy.Duration(0.1), publish)
    rospy.spin()


if __name__ == '__main__':
    main()
