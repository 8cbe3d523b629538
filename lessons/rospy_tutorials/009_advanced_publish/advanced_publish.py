#!/usr/bin/env python3
"""Publish colours on color: by the order of their fields, and by their names."""
import rospy
from std_msgs.msg import ColorRGBA

from rospy_support import nodes


def main():
    """Publish until the shutdown."""
    nodes.init_node('color_talker', anonymous=True)
    publisher = rospy.Publisher('color', ColorRGBA, queue_size=10)
    print(f"Node running. To see messages, type in another window:\n  rostopic echo {rospy.resolve_name('color')}",
          flush=True)
    rate = rospy.Rate(2)
    while not rospy.is_shutdown():
        publisher.publish(1, 2, 3, 4)  # r, g, b, a
        rate.sleep()
        publisher.publish(a=1.0)  # the others are 0
        rate.sleep()
        rospy.loginfo('I have %d subscribers', publisher.get_num_connections())


if __name__ == '__main__':
    nodes.run(main)
