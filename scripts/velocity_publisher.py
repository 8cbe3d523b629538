#!/usr/bin/env python3
"""The course's first publisher: a constant velocity on turtle1/cmd_vel."""
import rospy

from rospy_support import nodes, parameters, reachability
from turtle_robotont.nodes.course_nodes import VelocityPublisher


def main():
    nodes.init_node('velocity_publisher', anonymous=True)
    VelocityPublisher('turtle1/cmd_vel',
                      linear=parameters.number('~linear', 0.5, unit='m/s'),
                      angular=parameters.number('~angular', 0.2, unit='rad/s'),
                      rate=parameters.number('~rate', 10.0, minimum=0.1, maximum=1000.0, unit='Hz'))
    parameters.log_effective()
    reachability.watch()
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
