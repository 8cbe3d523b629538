#!/usr/bin/env python3
"""The course's first challenge: drive, and stop at x = 10."""

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from rospy_support import nodes, parameters, reachability
from rospy_support.parameters import Number, Table
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import stop_at_x

PARAMETERS = Table(Number('~x', 10.0, 0.0, ARENA_SIZE, 'm'), node_params.speeds(speed=1.0), node_params.TURTLE)


def main():
    nodes.init_node('stop_at_x', PARAMETERS)
    driver = TurtleDriver(node_params.turtle())
    x = PARAMETERS['~x'].read()
    limits = node_params.limits(PARAMETERS)
    parameters.log_effective()
    reachability.watch()
    stop_at_x(driver, x, limits)


if __name__ == '__main__':
    run(main)
