#!/usr/bin/env python3
"""The course's first service: turtle1/gotoPose, with drive_to and draw_shape, which answer how it went."""
import rospy

from rospy_support import nodes, parameters, reachability
from turtle_robotont.driving import shapes
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.drive_services import MODES, DriveServices
from turtle_robotont.nodes.turtle_driver import TurtleDriver


def main():
    nodes.init_node('goto_pose_server')
    driver = TurtleDriver(node_params.turtle())
    mode = parameters.text('~mode', 'drive', choices=MODES)
    limits = node_params.limits(speed=2.0)
    corners = node_params.points('~corners', shapes.DEFAULT_CORNERS)
    parameters.log_effective()
    reachability.watch()
    DriveServices(driver, mode, limits, corners)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
