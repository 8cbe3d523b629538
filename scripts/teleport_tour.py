#!/usr/bin/env python3
"""The course's last challenge: four positions by teleport_absolute, the path in black by set_pen."""

from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Integer, Number, Numbers, Table
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import teleport_tour

PARAMETERS = Table(Numbers('~positions', [[2.0, 2.0], [9.0, 2.0], [9.0, 9.0], [2.0, 9.0]], unit='m'),
                   Numbers('~color', [0, 0, 0], length=3), Integer('~width', 3, 0, 255, 'px'),
                   Number('~pause', 0.5, 0.0, 60.0, 's'), node_params.TURTLE)


def main():
    nodes.init_node('teleport_tour', PARAMETERS)
    driver = TurtleDriver(node_params.turtle())
    positions = node_params.points(PARAMETERS['~positions'])
    colour = node_params.colour(PARAMETERS['~color'])
    width, pause = PARAMETERS.read('~width', '~pause')
    parameters.log_effective()
    reachability.watch()
    teleport_tour(driver, positions, colour, width, pause)


if __name__ == '__main__':
    run(main)
