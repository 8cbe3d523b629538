"""Models and robots in one world, in fixed steps. No ROS, no clock; not thread-safe.

World frame: x forward, y to the left, z up; metres, radians. A *model*, as in Gazebo, has a name, a pose, and
either shapes or a robot.
"""
import math
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple
from xml.etree.ElementTree import Element

import numpy as np

from gazebo_ros.core import robots
from gazebo_ros.core.vehicle import DT, Vehicle
from kinematic_core.worlds.angles import wrap_angle
from kinematic_core.worlds.floor_plan import EMPTY, Box, Cylinder, FloorPlan, Panel, Shape
from kinematic_core.worlds.models import Models, State, of_robot, of_shape
from kinematic_core.worlds.planar import ORIGIN, Pose2D, compose
from plain_support import InvalidInput, require_sane, shown
from sim_scene import sdf

FLOOR = 'ground_plane'


class Model(NamedTuple):
    """A model without a robot: its shapes in the world, and its pose."""

    pose: Pose2D
    z: float
    shapes: Tuple[Shape, ...]
    links: Tuple[Tuple[str, np.ndarray], ...]  # (name, pose (4, 4) in the model)
    start: Pose2D


class GazeboWorld(Models):
    """All models by their names. Public and read-only: ``plan``, ``vehicles``, ``steps``."""

    known = 'there are'

    def __init__(self, plan: FloorPlan = EMPTY) -> None:
        """Begin with the colours of a FloorPlan, and a model for each of its shapes."""
        self.vehicles: Dict[str, Vehicle] = {}
        self.steps = 0
        self._base = plan._replace(boxes=(), cylinders=(), panels=())
        self._links: Dict[str, Tuple[Tuple[str, np.ndarray], ...]] = {}  # of robots
        self._models: Dict[str, Model] = {FLOOR: Model(ORIGIN, 0.0, (), (('link', np.eye(4)),), ORIGIN)}
        for shape in plan.shapes():
            state = of_shape(shape)
            self._models[shape.name] = Model(state.pose, state.z, (shape,), (('link', np.eye(4)),), state.pose)
        self.plan = self._plan_of(self._models)

    @property
    def time(self) -> float:
        """Return the simulated time [s]."""
        return self.steps * DT

    def add(self, element: Element, name: str, pose: np.ndarray, namespace: str = '', folder: str = '.') -> List[str]:
        """Add the SDF <model> ``element`` under a name at a pose (4, 4); return warnings about parts that are left out.

        ``namespace`` is that of its plugins, unless they name one. Raise InvalidInput for a name that exists,
        impossible numbers, or a place that is taken.
        """
        if not name:
            raise InvalidInput('the model has no name')
        if name in self.names():
            raise InvalidInput(f'there is a model {shown(name)} already')
        yaw = math.atan2(pose[1, 0], pose[0, 0])
        flat = Pose2D(float(pose[0, 3]), float(pose[1, 3]), yaw)
        require_sane(f'the pose of {shown(name)}', x=flat.x, y=flat.y, yaw=yaw)
        links = tuple((link.get('name') or '', sdf.pose_of(name, link)) for link in element.findall('link'))
        if robots.is_robot(element):
            return self._add_robot(element, name, flat, namespace, folder, links)
        model, warnings = sdf.read_model(element, name, pose, folder)
        self._set_models({**self._models, name: Model(flat, float(pose[2, 3]), model.shapes, links, flat)})
        return warnings

    def _add_robot(self, element: Element, name: str, pose: Pose2D, namespace: str, folder: str,
                   links: Tuple[Tuple[str, np.ndarray], ...]) -> List[str]:
        robot = robots.read(element, name, namespace, folder)
        vehicle = Vehicle(name, robot, pose, self.plan, self.bodies())
        self.vehicles[name], self._links[name] = vehicle, links
        warnings = [*robot.warnings]
        if robot.drive is None:
            warnings.append('it has no plugin that drives: it stands still')
        if vehicle.moved_aside > 0.01:
            warnings.append(f'it is {vehicle.moved_aside:.2f} m beside its place, where an obstacle is')
        return warnings

    def remove(self, name: str) -> None:
        """Remove a model; raise InvalidInput if there is none."""
        self.state(name)
        if name in self.vehicles:
            del self.vehicles[name], self._links[name]
        else:
            self._set_models({key: model for key, model in self._models.items() if key != name})

    def put(self, name: str, pose: Pose2D) -> None:
        """Put a model at a pose, stopped; raise InvalidInput if there is none, or if its place is taken."""
        require_sane(f'the pose of {shown(name)}', x=pose.x, y=pose.y, yaw=pose.yaw)
        self.state(name)
        if name in self.vehicles:
            self.vehicles[name].put(pose)
            return
        model = self._models[name]
        shapes = tuple(_moved(shape, model.pose, pose) for shape in model.shapes)
        self._set_models({**self._models, name: model._replace(pose=pose, shapes=shapes)})

    def reset(self) -> None:
        """Put all models where they started."""
        models = {name: model._replace(pose=model.start, shapes=tuple(_moved(shape, model.pose, model.start)
                                                                      for shape in model.shapes))
                  for name, model in self._models.items()}
        for vehicle in self.vehicles.values():
            vehicle.reset()
        self._set_models(models)

    def step(self) -> None:
        """Advance by DT. Robots move one after the other, in the order in which they were added."""
        self.steps += 1
        for vehicle in self.vehicles.values():
            vehicle.step(self.bodies(without=vehicle))

    def bodies(self, without: Optional[Vehicle] = None) -> List[Cylinder]:
        """Return the bodies of all robots, or of all other ones."""
        return [vehicle.body for vehicle in self.vehicles.values() if vehicle is not without]

    def names(self) -> List[str]:
        """Return the names of all models, robots last."""
        return [*self._models, *self.vehicles]

    def states(self) -> List[State]:
        """Return the State of each model in the frame of the world, in the order of ``names``."""
        return [*(State(model.pose, model.z) for model in self._models.values()),
                *(of_robot(vehicle.pose, vehicle.twist) for vehicle in self.vehicles.values())]

    def links(self) -> List[Tuple[str, State]]:
        """Return (``model::link``, State) of all links, with all joints at zero."""
        found = []
        for name, state in zip(self.names(), self.states()):
            for link, pose in self._links[name] if name in self._links else self._models[name].links:
                own = Pose2D(float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]))
                found.append((f'{name}::{link}', State(compose(state.pose, own), state.z + float(pose[2, 3]),
                                                       state.twist)))
        return found

    def _candidates(self, name: str) -> Dict[str, State]:
        return dict(self.links()) if '::' in name else super()._candidates(name)

    def _set_models(self, models: Dict[str, Model]) -> None:
        """Replace the models, unless a shape is impossible or would overlap a robot."""
        plan = self._plan_of(models)
        plan.check()
        changed: List[Vehicle] = []
        try:
            for vehicle in self.vehicles.values():
                vehicle.set_plan(plan)
                changed.append(vehicle)
        except InvalidInput:
            for vehicle in changed:
                vehicle.set_plan(self.plan)
            raise
        self._models, self.plan = models, plan

    def _plan_of(self, models: Dict[str, Model]) -> FloorPlan:
        shapes = [shape for model in models.values() for shape in model.shapes]
        return self._base._replace(boxes=_of(Box, shapes), cylinders=_of(Cylinder, shapes), panels=_of(Panel, shapes))


def _of(kind: type, shapes: Sequence[Shape]) -> tuple:  # type: ignore[type-arg]  # of one kind of shape
    return tuple(shape for shape in shapes if isinstance(shape, kind))


def _moved(shape: Shape, old: Pose2D, new: Pose2D) -> Shape:
    """Return a shape of a model that moves from one pose to another."""
    turn = new.yaw - old.yaw
    cos, sin = math.cos(turn), math.sin(turn)
    dx, dy = shape.x - old.x, shape.y - old.y
    moved = shape._replace(x=new.x + cos * dx - sin * dy, y=new.y + sin * dx + cos * dy)
    return moved if isinstance(moved, Cylinder) else moved._replace(yaw=wrap_angle(moved.yaw + turn))
