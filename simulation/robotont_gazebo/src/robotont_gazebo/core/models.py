"""The robot and the shapes of its world as Gazebo's models: names, poses, velocities. No ROS.

A model's pose has its position in the middle of its body, as in Gazebo; only a panel's is in the middle of its face.
The robot's is that of base_footprint. Frames: that of the world, or that of another model.
"""
import math
from typing import List, NamedTuple, Optional

from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.floor_plan import Panel, Shape
from kinematic_core.worlds.planar import STILL, Pose2D, Twist2D
from kinematic_core.worlds.robot_world import RobotWorld
from plain_support import InvalidInput, shown

ROBOT = 'robotont'  # its model's name in the original's launch files
WORLD_FRAMES = ('', 'world', 'map')


class State(NamedTuple):
    """Pose in the plane, height ``z`` [m], and velocity in the axes of the frame that the pose is in."""

    pose: Pose2D
    z: float
    twist: Twist2D


def names(world: RobotWorld) -> List[str]:
    """Return the names of all models, the robot last."""
    return [*(shape.name for shape in world.plan.shapes()), ROBOT]


def states(world: RobotWorld) -> List[State]:
    """Return the State of each model in the frame of the world, in the order of ``names``."""
    return [*map(_state, world.plan.at(world.time).shapes()), _robot(world)]


def state(world: RobotWorld, name: str, frame: str = '') -> State:
    """Return the State of a model in a frame; raise InvalidInput for unknown names."""
    found = _find(world, name, 'model')
    if frame in WORLD_FRAMES:
        return found
    reference = _find(world, frame, 'frame')
    return State(_into(reference.pose, found.pose), found.z - reference.z, _turned(found.twist, -reference.pose.yaw))


def in_world(world: RobotWorld, pose: Pose2D, frame: str = '') -> Pose2D:
    """Return the pose in the frame of the world; ``pose`` is in ``frame``. Raise InvalidInput if that is unknown."""
    if frame in WORLD_FRAMES:
        return pose
    reference = _find(world, frame, 'frame').pose
    cos, sin = math.cos(reference.yaw), math.sin(reference.yaw)
    return Pose2D(reference.x + cos * pose.x - sin * pose.y, reference.y + sin * pose.x + cos * pose.y,
                  wrap_angle(reference.yaw + pose.yaw))


def put(world: RobotWorld, name: str, pose: Pose2D) -> None:
    """Put the robot or a panel at a pose in the world; raise InvalidInput for other models and impossible poses."""
    if name == ROBOT:
        world.place(*pose)
    elif any(panel.name == name for panel in world.plan.panels):
        world.move_panel(name, *pose)
    else:
        _find(world, name, 'model')
        raise InvalidInput(f'the model {name!r} cannot be moved; only {ROBOT} and panels can')


def _find(world: RobotWorld, name: str, what: str) -> State:
    if name == ROBOT:
        return _robot(world)
    shape: Optional[Shape] = next((shape for shape in world.plan.shapes() if shape.name == name), None)
    if shape is None:
        raise InvalidInput(f'there is no {what} {shown(name)}; the models are: {", ".join(names(world))}')
    return _state(shape.at(world.time) if isinstance(shape, Panel) else shape)


def _robot(world: RobotWorld) -> State:
    return State(world.pose, 0.0, _turned(world.twist, world.pose.yaw))


def _state(shape: Shape) -> State:
    yaw = getattr(shape, 'yaw', 0.0)
    height = shape.size if isinstance(shape, Panel) else shape.height
    return State(Pose2D(shape.x, shape.y, yaw), shape.bottom + height / 2.0, STILL)


def _into(reference: Pose2D, pose: Pose2D) -> Pose2D:
    dx, dy = pose.x - reference.x, pose.y - reference.y
    cos, sin = math.cos(reference.yaw), math.sin(reference.yaw)
    return Pose2D(cos * dx + sin * dy, cos * dy - sin * dx, wrap_angle(pose.yaw - reference.yaw))


def _turned(twist: Twist2D, angle: float) -> Twist2D:
    cos, sin = math.cos(angle), math.sin(angle)
    return Twist2D(cos * twist.linear_x - sin * twist.linear_y, sin * twist.linear_x + cos * twist.linear_y,
                   twist.angular_z)
