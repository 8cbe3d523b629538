#!/usr/bin/env python3
"""Publish a text on the topic chatter ten times a second, in a loop."""
import rospy
from std_msgs.msg import String


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, queue_size=10)
    rate = rospy.Rate(10)  # [Hz]
    while not rospy.is_shutdown():
        text = f'hello world {rospy.get_time()}'
        rospy.loginfo(text)
        publisher.publish(text)
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
