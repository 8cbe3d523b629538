#!/usr/bin/env python3
"""The course's first service: turtle1/gotoPose; also drive_to and draw_shape, whose answers tell the result."""
import rospy

from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Numbers, Table, Text
from turtle_robotont.driving import shapes
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.drive_services import MODES, DriveServices
from turtle_robotont.nodes.turtle_driver import TurtleDriver

PARAMETERS = Table(Text('~mode', 'drive', MODES), node_params.speeds(speed=2.0),
                   Numbers('~corners', shapes.DEFAULT_CORNERS, unit='m'), node_params.TURTLE)


def main():
    nodes.init_node('goto_pose_server', PARAMETERS)
    driver = TurtleDriver(node_params.turtle())
    mode = PARAMETERS['~mode'].read()
    limits = node_params.limits(PARAMETERS)
    corners = node_params.points(PARAMETERS['~corners'])
    parameters.log_effective()
    reachability.watch()
    DriveServices(driver, mode, limits, corners)
    rospy.spin()


if __name__ == '__main__':
    nodes.run(main)
