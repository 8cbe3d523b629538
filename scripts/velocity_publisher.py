#!/usr/bin/env python3
"""The course's first publisher: a constant velocity on turtle1/cmd_vel."""
import rospy

from kinematic_ros import nodes, params, reachability
from turtle_robotont.course_nodes import VelocityPublisher


def main():
    nodes.init_node('velocity_publisher', anonymous=True)
    VelocityPublisher('turtle1/cmd_vel',
                      linear=params.number('~linear', 0.5, unit='m/s'),
                      angular=params.number('~angular', 0.2, unit='rad/s'),
                      rate=params.number('~rate', 10.0, minimum=0.1, maximum=1000.0, unit='Hz'))
    params.log_effective()
    reachability.watch()
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
