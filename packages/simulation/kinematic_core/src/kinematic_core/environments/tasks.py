"""The tasks of the environments: vehicle, start, goal and obstacles.

A task makes an episode from a seed; the same seed gives the same episode. Positions [m] and headings [rad] are in the
frame of the vehicle's world. This module does not use gymnasium.
"""
import math
from typing import Callable, Dict, NamedTuple, Tuple

import numpy as np

from kinematic_core.worlds import robot_world, turtle_world
from kinematic_core.worlds.floor_plan import EMPTY, Box, FloorPlan
from kinematic_core.worlds.robot_world import RobotWorld
from kinematic_core.worlds.turtle_world import ARENA_SIZE, START, START_MARGIN, TurtleWorld, random_start

State = Tuple[float, float, float, bool]  # x, y [m], heading [rad], whether the vehicle touches a wall
Drive = Callable[..., State]  # of a command: makes one step of the world

NEAREST_GOAL = 0.5  # [m] from the start
ROBOT_AREA = 2.0  # [m] largest distance of a Robotont's goal from its start in x, and in y
WALL_X = 2.0  # [m] where the two walls stand, ahead of the robot
WALL_THICKNESS = 0.2  # [m]
WALL_HEIGHT = 0.5  # [m]
GAP = 0.8  # [m] between the two walls, more than twice the robot's diameter
FARTHEST_GAP = 1.2  # [m] of its middle from the line straight ahead
ROOM = (-1.0, 5.0, 2.0)  # [m] lowest x, highest x, y to both sides: outer walls leave no other path
BEHIND = 1.5  # [m] distance of the goal behind the walls


class Episode(NamedTuple):
    """A vehicle at its start, its goal (x, y) [m], and the walls of its world."""

    drive: Drive
    start: Tuple[float, float, float]
    goal: Tuple[float, float]
    plan: FloorPlan = EMPTY


class Task(NamedTuple):
    """The properties that all episodes of a task share."""

    begin: Callable[[int], Episode]  # returns the episode of a seed, 0 or more
    dt: float  # [s] a step
    fastest: Tuple[float, ...]  # the command that an action of 1 stands for [m/s, ..., rad/s]
    reached: float  # [m] distance from the goal at which it counts as reached
    time_limit: float  # [s]
    rays: int = 0  # of the range finder, evenly all around from -pi
    ray_steps: int = 1  # between two measurements


def turtle_goal(seed: int) -> Episode:
    """Return an episode of turtle1, with the start that turtlesim_node has for that seed, and a goal in the arena."""
    start = random_start(seed) if seed else START
    world = TurtleWorld(start=start)
    turtle, command, step = world.turtles['turtle1'], world.command, world.step

    def drive(linear_x: float, angular_z: float) -> State:
        command('turtle1', linear_x, 0.0, angular_z)
        step()
        return turtle.x, ARENA_SIZE - turtle.y_down, turtle.theta, False
    low, high = START_MARGIN, ARENA_SIZE - START_MARGIN
    return Episode(drive, (turtle.x, ARENA_SIZE - turtle.y_down, turtle.theta), _goal(seed, start[:2], low, high))


def robotont_goal(seed: int) -> Episode:
    """Return an episode of a Robotont at the origin of the empty world, and a goal around it."""
    world = RobotWorld()
    return Episode(_robot_drive(world), world.pose, _goal(seed, world.pose[:2], -ROBOT_AREA, ROBOT_AREA))


def robotont_between_walls(seed: int) -> Episode:
    """Return an episode of a Robotont in front of two walls, and a goal behind the gap between them."""
    gap_y = float(np.random.default_rng(seed).uniform(-FARTHEST_GAP, FARTHEST_GAP))
    world = RobotWorld(gap_plan(gap_y))
    return Episode(_robot_drive(world), world.pose, (WALL_X + BEHIND, gap_y), world.plan)


def gap_plan(gap_y: float) -> FloorPlan:
    """Return the room with two walls at WALL_X, and between them a gap whose middle is at ``gap_y`` [m]."""
    first, last, side = ROOM
    boxes = []
    for sign, name in ((1.0, 'left'), (-1.0, 'right')):
        edge = gap_y + sign * GAP / 2.0  # [m] y of the wall at the gap
        boxes.append(Box(f'{name}_wall', WALL_X, (edge + sign * side) / 2.0, 0.0, WALL_THICKNESS,
                         abs(sign * side - edge), WALL_HEIGHT))
        boxes.append(Box(f'{name}_side', (first + last) / 2.0, sign * (side + WALL_THICKNESS / 2.0), 0.0, last - first,
                         WALL_THICKNESS, WALL_HEIGHT))
    return FloorPlan(tuple(boxes))


def _robot_drive(world: RobotWorld) -> Drive:
    command, step = world.command, world.step

    def drive(linear_x: float, linear_y: float, angular_z: float) -> State:
        command(linear_x, linear_y, angular_z)
        step()
        x, y, yaw = world.pose
        return x, y, yaw, world.touching
    return drive


def _goal(seed: int, start: Tuple[float, ...], low: float, high: float) -> Tuple[float, float]:
    """Return a random position, x and y from ``low`` to ``high`` [m], at least NEAREST_GOAL from the start."""
    numbers = np.random.default_rng(seed)
    while True:
        x, y = numbers.uniform(low, high, 2).tolist()
        if math.hypot(x - start[0], y - start[1]) >= NEAREST_GOAL:
            return x, y


TASKS: Dict[str, Task] = {
    'TurtleGoal': Task(turtle_goal, turtle_world.DT, (2.0, 2.0), 0.2, 20.0),
    'RobotontGoal': Task(robotont_goal, robot_world.DT, (0.5, 0.5, 1.0), 0.1, 20.0),
    'RobotontBetweenWalls': Task(robotont_between_walls, robot_world.DT, (0.5, 0.5, 1.0), 0.2, 30.0, 16, 3),
}
