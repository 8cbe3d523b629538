"""The models of a world, as Gazebo has them: names, poses, velocities, in the frame of the world or of another model.

A shape's pose has its position in the middle of its body; only a panel's is in the middle of its face.
"""
import math
from typing import Dict, List, NamedTuple

from kinematic_core.worlds.floor_plan import Panel, Shape
from kinematic_core.worlds.planar import STILL, Pose2D, Twist2D, compose, relative
from plain_support import InvalidInput, shown

WORLD_FRAMES = ('', 'world', 'map')


class State(NamedTuple):
    """Pose in the plane, height ``z`` [m], and velocity along the axes of the frame that the pose is in."""

    pose: Pose2D
    z: float = 0.0
    twist: Twist2D = STILL


def of_shape(shape: Shape) -> State:
    """Return the State of a shape that stands still, in the world."""
    height = shape.size if isinstance(shape, Panel) else shape.height
    return State(Pose2D(shape.x, shape.y, getattr(shape, 'yaw', 0.0)), shape.bottom + height / 2.0)


def of_robot(pose: Pose2D, twist: Twist2D) -> State:
    """Return the State of a robot in the world; ``twist`` is in its own frame."""
    return State(pose, 0.0, _turned(twist, pose.yaw))


class Models:
    """Subclasses have the names and states of their models, in the same order."""

    known = 'the models are'  # before the names in an error

    def names(self) -> List[str]:
        """Return the names of all models, robots last."""
        raise NotImplementedError

    def states(self) -> List[State]:
        """Return the State of each model in the frame of the world."""
        raise NotImplementedError

    def state(self, name: str, frame: str = '') -> State:
        """Return the State of a model in a frame; raise InvalidInput for unknown names."""
        found = self._find(name, 'model')
        if frame in WORLD_FRAMES:
            return found
        reference = self._find(frame, 'frame')
        return State(relative(found.pose, reference.pose), found.z - reference.z,
                     _turned(found.twist, -reference.pose.yaw))

    def in_world(self, pose: Pose2D, frame: str = '') -> Pose2D:
        """Return a pose, given in a frame, in that of the world; raise InvalidInput if the frame is unknown."""
        return pose if frame in WORLD_FRAMES else compose(self._find(frame, 'frame').pose, pose)

    def _find(self, name: str, what: str) -> State:
        found = self._candidates(name)
        if name not in found:
            raise InvalidInput(f'there is no {what} {shown(name)}; {self.known}: {", ".join(found)}')
        return found[name]

    def _candidates(self, name: str) -> Dict[str, State]:
        return dict(zip(self.names(), self.states()))


def _turned(twist: Twist2D, angle: float) -> Twist2D:
    cos, sin = math.cos(angle), math.sin(angle)
    return Twist2D(cos * twist.linear_x - sin * twist.linear_y, sin * twist.linear_x + cos * twist.linear_y,
                   twist.angular_z)
