#!/usr/bin/env python3
"""The course's first publisher: a constant velocity on turtle1/cmd_vel."""
import rospy

from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Number, Table
from turtle_robotont.nodes.course_nodes import VelocityPublisher

PARAMETERS = Table(Number('~linear', 0.5, unit='m/s'), Number('~angular', 0.2, unit='rad/s'),
                   Number('~rate', 10.0, 0.1, 1000.0, 'Hz'))


def main():
    nodes.init_node('velocity_publisher', PARAMETERS, anonymous=True)
    VelocityPublisher('turtle1/cmd_vel', *PARAMETERS.read('~linear', '~angular', '~rate'))
    parameters.log_effective()
    reachability.watch()
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
