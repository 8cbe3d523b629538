#!/usr/bin/env python3
"""The course's special challenge: draw a square, another shape or four given positions by topics alone."""
import rospy

from kinematic_core.turtle_world import ARENA_SIZE
from kinematic_ros import params, reachability
from turtle_robotont import node_params, shapes
from turtle_robotont.turtle_driver import TurtleDriver, run
from turtle_robotont.turtle_tasks import draw_shape


def main():
    rospy.init_node('drive_shape')
    driver = TurtleDriver(node_params.turtle())
    shape = params.text('~shape', 'square', choices=shapes.SHAPES)
    size = params.number('~size', shapes.DEFAULT_SIZE, minimum=shapes.SMALLEST, maximum=ARENA_SIZE, unit='m')
    corners = node_params.points('~corners', shapes.DEFAULT_CORNERS)
    limits = node_params.limits(speed=2.0)
    params.log_effective()
    reachability.watch()
    draw_shape(driver, shape, size, corners, limits)


if __name__ == '__main__':
    run(main)
