#!/usr/bin/env python3
"""Publish on the topic chatter, and send a header to every subscriber when it connects."""
import rospy
from std_msgs.msg import String


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('talker', anonymous=True)
    publisher = rospy.Publisher('chatter', String, headers={'cookies': 'oreo'}, queue_size=10)
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
