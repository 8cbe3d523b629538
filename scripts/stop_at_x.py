#!/usr/bin/env python3
"""The course's first challenge: drive, and stop at x = 10."""

from kinematic_core.worlds.turtle_world import ARENA_SIZE
from rospy_support import nodes, parameters, reachability
from turtle_robotont.nodes import node_params
from turtle_robotont.nodes.driver import run
from turtle_robotont.nodes.turtle_driver import TurtleDriver
from turtle_robotont.nodes.turtle_tasks import stop_at_x


def main():
    nodes.init_node('stop_at_x')
    driver = TurtleDriver(node_params.turtle())
    x = parameters.number('~x', 10.0, minimum=0.0, maximum=ARENA_SIZE, unit='m')
    limits = node_params.limits(speed=1.0)
    parameters.log_effective()
    reachability.watch()
    stop_at_x(driver, x, limits)


if __name__ == '__main__':
    run(main)
