#!/usr/bin/env python3
"""The course's first challenge: drive, and stop at x = 10."""

from kinematic_core.turtle_world import ARENA_SIZE
from kinematic_ros import nodes, params, reachability
from turtle_robotont import node_params
from turtle_robotont.driver import run
from turtle_robotont.turtle_driver import TurtleDriver
from turtle_robotont.turtle_tasks import stop_at_x


def main():
    nodes.init_node('stop_at_x')
    driver = TurtleDriver(node_params.turtle())
    x = params.number('~x', 10.0, minimum=0.0, maximum=ARENA_SIZE, unit='m')
    limits = node_params.limits(speed=1.0)
    params.log_effective()
    reachability.watch()
    stop_at_x(driver, x, limits)


if __name__ == '__main__':
    run(main)
