#!/usr/bin/env python3
"""Publish a text on chatter, ten times a second, by a timer."""
import rospy
from std_msgs.msg import String

from rospy_support import nodes


def main():
    """Publish until the shutdown."""
    nodes.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, queue_size=10)

    def publish(event):
        text = f'hello world {event.current_real.to_sec()}'
        rospy.loginfo(text)
        publisher.publish(text)
    rospy.Timer(rospy.Duration.from_sec(0.1), publish)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
