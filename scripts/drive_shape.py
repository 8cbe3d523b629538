#!/usr/bin/env python3
"""The course's special challenge: draw a square, another shape or four given positions by topics alone.

A turtle does it, or the robot of the last part.
"""

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from rospy_support import nodes, parameters, reachability
from turtle_robotont.driving import shapes
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.robot_driver import RobotDriver
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import draw_shape


def main():
    nodes.init_node('drive_shape')
    robot = parameters.boolean('~robot', False)
    driver = RobotDriver() if robot else TurtleDriver(node_params.turtle())
    shape = parameters.text('~shape', 'square', choices=shapes.SHAPES)
    size = parameters.number('~size', shapes.ROBOT_SIZE if robot else shapes.DEFAULT_SIZE,
                         minimum=shapes.SMALLEST, maximum=ARENA_SIZE, unit='m')
    corners = node_params.points('~corners', shapes.ROBOT_CORNERS if robot else shapes.DEFAULT_CORNERS,
                                 bounded=not robot)
    strafe = parameters.boolean('~strafe', False)
    limits = node_params.limits(driver.vehicle.limits.speed, driver.vehicle.limits.turn_speed)
    parameters.log_effective()
    reachability.watch()
    draw_shape(driver, shape, size, corners, limits, strafe)


if __name__ == '__main__':
    run(main)
