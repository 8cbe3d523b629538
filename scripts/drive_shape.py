#!/usr/bin/env python3
"""The course's special challenge: draw a square, another shape, or four given positions, using only topics.

It drives a turtle, or the robot of the last part.
"""

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Boolean, Computed, Number, Numbers, Table, Text
from turtle_robotont.driving import shapes
from turtle_robotont.driving.vehicle import ROBOT, TURTLE
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.robot_driver import RobotDriver
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import draw_shape

PARAMETERS = Table(
    Boolean('~robot', False), Text('~shape', 'square', shapes.SHAPES),
    Number('~size', Computed(f'{shapes.DEFAULT_SIZE} (robot: {shapes.ROBOT_SIZE})'), shapes.SMALLEST, ARENA_SIZE, 'm'),
    Numbers('~corners', Computed('a square of side 3 (robot: 0.5)'), unit='m'), Boolean('~strafe', False),
    node_params.speeds(*(Computed(f'{turtle} (robot: {robot})') for turtle, robot in zip(TURTLE.limits, ROBOT.limits))),
    node_params.TURTLE)


def main():
    nodes.init_node('drive_shape', PARAMETERS)
    robot, shape, strafe = PARAMETERS.read('~robot', '~shape', '~strafe')
    driver = RobotDriver() if robot else TurtleDriver(node_params.turtle())
    size = PARAMETERS['~size'].read(shapes.ROBOT_SIZE if robot else shapes.DEFAULT_SIZE)
    corners = node_params.points(PARAMETERS['~corners'], shapes.ROBOT_CORNERS if robot else shapes.DEFAULT_CORNERS,
                                 bounded=not robot)
    limits = node_params.limits(PARAMETERS, driver.vehicle.limits)
    parameters.log_effective()
    reachability.watch()
    draw_shape(driver, shape, size, corners, limits, strafe)


if __name__ == '__main__':
    run(main)
