"""The robot and the shapes of its world as models of Gazebo. No ROS."""
from typing import List

from kinematic_core.worlds import models
from kinematic_core.worlds.models import State
from kinematic_core.worlds.planar import Pose2D
from kinematic_core.worlds.robot_world import RobotWorld
from plain_support import InvalidInput

ROBOT = 'robotont'  # its model's name in the original's launch files; its pose is that of base_footprint


class Models(models.Models):
    """The models of a RobotWorld, the robot last."""

    def __init__(self, world: RobotWorld) -> None:
        self._world = world

    def names(self) -> List[str]:
        """Return the names of all models."""
        return [*(shape.name for shape in self._world.plan.shapes()), ROBOT]

    def states(self) -> List[State]:
        """Return the State of each model now."""
        world = self._world
        return [*map(models.of_shape, world.plan.at(world.time).shapes()), models.of_robot(world.pose, world.twist)]

    def put(self, name: str, pose: Pose2D) -> None:
        """Put the robot or a panel at a pose in the world; raise InvalidInput for others and impossible poses."""
        if name == ROBOT:
            self._world.place(*pose)
        elif any(panel.name == name for panel in self._world.plan.panels):
            self._world.move_panel(name, *pose)
        else:
            self.state(name)
            raise InvalidInput(f'the model {name!r} cannot be moved; only {ROBOT} and panels can')
