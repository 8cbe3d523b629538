#!/usr/bin/env python3
"""Publish texts with a header on the topic chatter_header."""
import rospy
from rospy_tutorials.msg import HeaderString


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('talker_header')
    publisher = rospy.Publisher('chatter_header', HeaderString, queue_size=10)
    rate = rospy.Rate(10)  # [Hz]
    count = 0
    while not rospy.is_shutdown():
        message = HeaderString()
        message.header.stamp = rospy.Time.now()  # rospy fills in header.seq
        message.data = f'hello world {count}'
        print(message.data)
        publisher.publish(message)
        count += 1
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
