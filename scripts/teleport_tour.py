#!/usr/bin/env python3
"""The course's last challenge: four positions by teleport_absolute, the path in black by set_pen."""

from kinematic_ros import nodes, params, reachability
from turtle_robotont import node_params
from turtle_robotont.driver import run
from turtle_robotont.turtle_driver import TurtleDriver
from turtle_robotont.turtle_tasks import teleport_tour

POSITIONS = [[2.0, 2.0], [9.0, 2.0], [9.0, 9.0], [2.0, 9.0]]  # [m]


def main():
    nodes.init_node('teleport_tour')
    driver = TurtleDriver(node_params.turtle())
    positions = node_params.points('~positions', POSITIONS)
    colour = node_params.colour('~color', [0, 0, 0])
    width = params.integer('~width', 3, minimum=0, maximum=255, unit='px')
    pause = params.number('~pause', 0.5, minimum=0.0, maximum=60.0, unit='s')
    params.log_effective()
    reachability.watch()
    teleport_tour(driver, positions, colour, width, pause)


if __name__ == '__main__':
    run(main)
