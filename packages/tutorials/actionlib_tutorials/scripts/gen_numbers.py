#!/usr/bin/env python3
"""Publish random numbers on the topic random_number, 20 per second."""
import random

import rospy
from std_msgs.msg import Float32


def main():
    """Publish until Ctrl-C."""
    rospy.init_node('random_number_generator')
    publisher = rospy.Publisher('random_number', Float32, queue_size=10)
    rate = rospy.Rate(20)  # [Hz]
    rospy.loginfo('Generating random numbers')
    while not rospy.is_shutdown():
        publisher.publish(random.normalvariate(5.0, 1.0))  # mean, standard deviation
        rate.sleep()


if __name__ == '__main__':
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C
