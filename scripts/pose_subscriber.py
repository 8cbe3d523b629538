#!/usr/bin/env python3
"""The course's first subscriber: prints the poses on turtle1/pose."""
import rospy

from rospy_support import nodes, parameters, reachability
from turtle_robotont.nodes.course_nodes import PosePrinter


def main():
    nodes.init_node('pose_subscriber', anonymous=True)
    nodes.end_when_unread()
    PosePrinter('turtle1/pose', rate=parameters.number('~rate', 0.0, minimum=0.0, maximum=1000.0, unit='Hz'))
    parameters.log_effective()
    reachability.watch()
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
