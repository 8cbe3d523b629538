#!/usr/bin/env python3
"""The course's last challenge: four positions by teleport_absolute, the path in black by set_pen."""

from rospy_support import nodes, parameters, reachability
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import teleport_tour

POSITIONS = [[2.0, 2.0], [9.0, 2.0], [9.0, 9.0], [2.0, 9.0]]  # [m]


def main():
    nodes.init_node('teleport_tour')
    driver = TurtleDriver(node_params.turtle())
    positions = node_params.points('~positions', POSITIONS)
    colour = node_params.colour('~color', [0, 0, 0])
    width = parameters.integer('~width', 3, minimum=0, maximum=255, unit='px')
    pause = parameters.number('~pause', 0.5, minimum=0.0, maximum=60.0, unit='s')
    parameters.log_effective()
    reachability.watch()
    teleport_tour(driver, positions, colour, width, pause)


if __name__ == '__main__':
    run(main)
