#!/usr/bin/env python3
"""Publish colours on the topic color: by the order of their fields, and by their names."""
import rospy
from std_msgs.msg import ColorRGBA


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('color_talker', anonymous=True)
    publisher = rospy.Publisher('color', ColorRGBA, queue_size=10)
    print(f'Node running. To see messages, type in another window:\n  rostopic echo {rospy.resolve_name("color")}')
    rate = rospy.Rate(2)  # [Hz]
    while not rospy.is_shutdown():
        publisher.publish(1, 2, 3, 4)  # r, g, b, a
        rate.sleep()
        publisher.publish(a=1.0)  # r, g and b are 0
        rate.sleep()
        rospy.loginfo('I have %d subscribers', publisher.get_num_connections())


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
