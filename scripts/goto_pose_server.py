#!/usr/bin/env python3
"""The course's first service: turtle1/gotoPose, with drive_to and draw_shape, which answer how it went."""
import rospy

from kinematic_ros import nodes, params, reachability
from turtle_robotont import node_params, shapes
from turtle_robotont.drive_services import MODES, DriveServices
from turtle_robotont.turtle_driver import TurtleDriver


def main():
    nodes.init_node('goto_pose_server')
    driver = TurtleDriver(node_params.turtle())
    mode = params.text('~mode', 'drive', choices=MODES)
    limits = node_params.limits(speed=2.0)
    corners = node_params.points('~corners', shapes.DEFAULT_CORNERS)
    params.log_effective()
    reachability.watch()
    DriveServices(driver, mode, limits, corners)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
