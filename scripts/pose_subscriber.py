#!/usr/bin/env python3
"""The course's first subscriber: prints the poses on turtle1/pose."""
import rospy

from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Number, Table
from turtle_robotont.nodes.course_nodes import PosePrinter

PARAMETERS = Table(Number('~rate', 0.0, 0.0, 1000.0, 'Hz'))


def main():
    nodes.init_node('pose_subscriber', PARAMETERS, anonymous=True)
    nodes.end_when_unread()
    PosePrinter('turtle1/pose', *PARAMETERS.read('~rate'))
    parameters.log_effective()
    reachability.watch()
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
