"""Read a Gazebo world (SDF 1.4 to 1.7) as a floor plan. No ROS.

It reads upright boxes and cylinders of links, static or not (nothing falls here), with nested poses (those in <state>
take precedence over those of the models), colours of materials, the colour of the sky, horizontal planes at floor
level, spheres as stacks of cylinders, meshes that are boxes and the walls of other meshes, the AR panels of
robotont_gazebo's models (meshes called Marker<id>.dae), and such panels as actors that move along waypoints. An
<include> is read where its model is found (``meshes.find_model``) or known (``common_models``). Other obstacles and
visible things are skipped, and a warning names each of them.
"""
import math
import os
import re
from typing import Any, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple
from xml.etree.ElementTree import Element

import numpy as np

from kinematic_core.worlds.colours import COLOURS
from kinematic_core.worlds.floor_plan import EMPTY, GREY, Box, Colour, Cylinder, FloorPlan, Panel, Shape, Waypoint
from plain_support import InvalidInput, documents, shown
from plain_support.documents import DocumentError
from plain_support.rotations import matrix_from_rpy
from sim_scene import common_models, meshes

UPRIGHT = 0.02  # [rad] a shape that is tilted less counts as upright, because saved worlds have settled
FLOOR = 0.05  # [m] by which a shape may reach into the floor without a warning
DEEPEST = 10  # includes in each other
SILENT = {'sun', 'ground_plane'}  # included models that have no effect here
MARKER = re.compile(r'Marker(\d+)\.dae$', re.IGNORECASE)
SLICES = 10  # cylinders that a sphere becomes
MARKER_MESH = (0.5, 0.35)  # [m] size of such a mesh's board and of its marker at scale 1


class Model(NamedTuple):
    """A <model> of a world: its name, its pose (4, 4) in the world, the folder where its meshes are searched, and its
    shapes in the world.
    """

    name: str
    element: Element
    pose: np.ndarray
    folder: str
    shapes: Tuple[Shape, ...]


class World(NamedTuple):
    """The models of a world file, its panels that move, and its colours as an empty FloorPlan."""

    models: Tuple[Model, ...]
    panels: Tuple[Panel, ...]
    colours: FloorPlan
    warnings: List[str]


def read(path: str) -> Tuple[FloorPlan, List[str]]:
    """Return (FloorPlan, warnings) of a world file; raise InvalidInput, without its name, if it is not valid."""
    reader = _read_file(path)
    plan = reader.plan()
    plan.check()
    overlaps = plan.overlaps()
    if overlaps:
        reader.warnings.append(f'{len(overlaps)} pairs of shapes overlap, among them {overlaps[0][0]} and '
                               f'{overlaps[0][1]}')
    return plan, reader.warnings


def read_world(path: str) -> World:
    """Return a world file as its models; raise InvalidInput, without its name, if it is not valid."""
    reader = _read_file(path)
    plan = reader.plan()
    plan.check()
    return World(tuple(reader.models), plan.moving(), plan._replace(boxes=(), cylinders=(), panels=()), reader.warnings)


def read_model(element: Element, name: str, pose: np.ndarray, folder: str) -> Tuple[Model, List[str]]:
    """Return a <model> as it stands at a pose (4, 4) in the world, and warnings; its own <pose> does not count."""
    reader = _Reader(folder)
    reader.read_model(element, pose, name)
    return reader.models[0], reader.warnings


def included(uri: str, folder: str) -> Tuple[Element, str]:
    """Return the <model> that a file in ``folder`` includes as ``uri``, and the folder of the model's own file.

    Raise InvalidInput if it is found nowhere, or is not valid.
    """
    try:
        path = meshes.find_model(uri, folder)
    except InvalidInput:
        known = common_models.model(os.path.basename(uri.rstrip('/')))
        if known is None:
            raise
        return known, folder
    try:
        model = documents.read_xml(path).find('model')
    except (DocumentError, OSError) as error:
        raise InvalidInput(f'{path}: {error}') from None
    if model is None:
        raise InvalidInput(f'{path} has no <model>')
    return model, os.path.dirname(path)


def _read_file(path: str) -> '_Reader':
    try:
        root = documents.read_xml(path)
    except OSError as error:
        raise InvalidInput(error.strerror or str(error)) from None
    except DocumentError as error:
        raise InvalidInput(str(error)) from None
    world = root.find('world') if root.tag == 'sdf' else None
    if world is None:
        raise InvalidInput(f'not an SDF world: the file begins with <{root.tag:.80}>; it must be <sdf> with a <world> '
                           'in it')
    reader = _Reader(os.path.dirname(os.path.abspath(path)))
    reader.read_world(world)
    return reader


class _Reader:
    """Collects the models of a <world> and their shapes."""

    def __init__(self, folder: str) -> None:
        """``folder`` is that of the file, where meshes are searched."""
        self.warnings: List[str] = []
        self.models: List[Model] = []
        self._folder = folder
        self._shapes: Dict[type, List[Any]] = {Box: [], Cylinder: [], Panel: []}
        self._names: Set[str] = set()
        self._colours: Dict[str, Colour] = {}

    def read_world(self, world: Element) -> None:
        """Read all that is in a <world>."""
        background = world.find('scene/background')
        if background is not None:
            self._colours['sky_colour'] = _rgb('scene: background', background.text)
        for tag in ('population', 'road', 'heightmap'):
            for element in world.findall(tag):
                self.warnings.append(f'<{tag}> {element.get("name") or ""} is left out')
        states = {model.get('name'): model for model in world.findall('state/model')}
        for model in world.findall('model'):
            self.read_model(model, self._pose(model.get('name') or 'model', model), model.get('name') or 'model',
                            states.get(model.get('name')))
        for include in world.findall('include'):
            found = self._included(include, '')
            if found:
                model, folder = found
                name = (include.findtext('name') or model.get('name') or 'model').strip()
                pose = self._pose(name, include if include.find('pose') is not None else model)
                own, self._folder = self._folder, folder
                self.read_model(model, pose, self._model_name(name), states.get(name))
                self._folder = own
        for actor in world.findall('actor'):
            self._read_actor(actor, actor.get('name') or 'actor')

    def plan(self) -> FloorPlan:
        """Return the FloorPlan that was read."""
        return EMPTY._replace(boxes=tuple(self._shapes[Box]), cylinders=tuple(self._shapes[Cylinder]),
                              panels=tuple(self._shapes[Panel]), **self._colours)

    def read_model(self, model: Element, pose: np.ndarray, name: str, state: Optional[Element] = None) -> None:
        """Read a <model> at a pose (4, 4), unless ``state`` has another one, and add it to ``models``."""
        if state is not None and state.find('pose') is not None:
            pose = self._pose(name, state)  # in the world
        before = {kind: len(shapes) for kind, shapes in self._shapes.items()}
        self._read_parts(model, pose, name, state)
        shapes = tuple(shape for kind, shapes in self._shapes.items() for shape in shapes[before[kind]:])
        self.models.append(Model(name, model, pose, self._folder, shapes))

    def _model_name(self, name: str) -> str:
        """Return the name for one more model, as Gazebo numbers them."""
        names = {model.name for model in self.models}
        return name if name not in names else next(f'{name}_{number}' for number in range(len(names) + 1)
                                                   if f'{name}_{number}' not in names)

    def _included(self, include: Element, owner: str) -> Optional[Tuple[Element, str]]:
        """Return the <model> of an <include> and the folder of its file; None, with a warning, if it is not found."""
        uri = (include.findtext('uri') or '').strip()
        if os.path.basename(uri) in SILENT:
            return None
        try:
            if owner.count('/') > DEEPEST:
                raise InvalidInput(f'it lies in {DEEPEST} others')
            return included(uri, self._folder)
        except InvalidInput as error:
            self.warnings.append(f'{owner}<include> of {uri or "nothing"} is left out: {error}')
            return None

    def _read_parts(self, model: Element, pose: np.ndarray, name: str, state: Optional[Element]) -> None:
        link_states: Dict[Optional[str], Element] = {}
        if state is not None:
            link_states = {link.get('name'): link for link in state.findall('link')}
            if (state.findtext('scale') or '1 1 1').split() != ['1', '1', '1']:
                self.warnings.append(f'{name}: the <scale> {state.findtext("scale")} of its <state> is left out')
        for link in model.findall('link'):
            own = f'{name}/{link.get("name")}'
            link_state = link_states.get(link.get('name'))
            placed = pose @ self._pose(own, link)
            if link_state is not None and link_state.find('pose') is not None:
                placed = self._pose(own, link_state)  # in the world
            self._read_link(link, placed, own)
        for inner in model.findall('model'):
            own = f'{name}/{inner.get("name")}'
            self._read_parts(inner, pose @ self._pose(own, inner), own, None)
        for include in model.findall('include'):
            found = self._included(include, f'{name}: ')
            if found:
                inner, folder = found
                own = f'{name}/{include.findtext("name") or inner.get("name")}'
                placed = pose @ self._pose(own, include if include.find('pose') is not None else inner)
                outer, self._folder = self._folder, folder
                self._read_parts(inner, placed, own, None)
                self._folder = outer

    def _read_actor(self, actor: Element, name: str) -> None:
        """Read an actor that is a panel; its trajectory becomes the panel's path."""
        uri = actor.findtext('link/visual/geometry/mesh/uri') or ''
        marker = MARKER.search(uri)
        waypoints = actor.findall('script/trajectory/waypoint')
        if not marker or not waypoints:
            self.warnings.append(f'<actor> {name} is left out; only panels that move along waypoints are read')
            return
        path: List[Waypoint] = []
        for waypoint in waypoints:
            time, = _numbers(f'{name}: waypoint: time', waypoint.findtext('time'), 1)
            x, y, z, _, _, yaw = _numbers(f'{name}: waypoint: pose', waypoint.findtext('pose'), 6)
            path.append((time - path[0][0] if path else time, x, y, yaw))
        scale = _numbers(f'{name}: mesh: scale', actor.findtext('link/visual/geometry/mesh/scale') or '1 1 1', 3)
        board, marker_size = (scale[2] * length for length in MARKER_MESH)
        self._add(Panel(self._name(name), int(marker.group(1)), path[0][1], path[0][2], path[0][3], board, marker_size,
                        max(0.0, z), tuple([(0.0, *path[0][1:]), *path[1:]])))

    def _read_link(self, link: Element, pose: np.ndarray, name: str) -> None:
        """Read a link's collisions; its visuals give the colour, and the shapes if there are no collisions."""
        visuals = link.findall('visual')
        colours = [colour for colour in map(colour_of, visuals) if colour is not None]
        colour = colours[0] if colours else GREY
        parts = link.findall('collision') or visuals
        for part in parts:
            own = name if len(parts) == 1 else f'{name}/{part.get("name")}'
            geometry = part.find('geometry')
            for kind in list(geometry) if geometry is not None else []:
                self._read_geometry(kind, pose @ self._pose(own, part), own, colour)

    def _read_geometry(self, geometry: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        reader = {'box': self._read_box, 'cylinder': self._read_cylinder, 'sphere': self._read_sphere,
                  'plane': self._read_plane, 'mesh': self._read_mesh}.get(geometry.tag)
        if reader:
            reader(geometry, pose, name, colour)
        elif geometry.tag != 'empty':
            self.warnings.append(f'{name}: <{geometry.tag}> is left out; only box, cylinder, sphere, plane and mesh '
                                 'are read')

    def _read_box(self, box: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        self._add_box(_numbers(f'{name}: box: size', box.findtext('size'), 3), pose, name, colour)

    def _add_box(self, size: Sequence[float], pose: np.ndarray, name: str, colour: Colour) -> None:
        up = _upright_axis(pose)
        if up is None:
            self.warnings.append(f'{name}: the box is tilted; left out')
            return
        along, across = ((1, 2), (2, 0), (0, 1))[up]  # a right-handed frame with the upright axis
        yaw = math.atan2(pose[1, along], pose[0, along])
        if pose[2, up] < 0.0:
            yaw = -math.atan2(-pose[1, along], pose[0, along])
        self._add(Box(self._name(name), pose[0, 3], pose[1, 3], yaw, size[along], size[across], size[up],
                      self._bottom(name, pose, size[up]), colour))

    def _read_cylinder(self, cylinder: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        radius, = _numbers(f'{name}: cylinder: radius', cylinder.findtext('radius'), 1)
        length, = _numbers(f'{name}: cylinder: length', cylinder.findtext('length'), 1)
        if _upright_axis(pose) != 2:
            self.warnings.append(f'{name}: the cylinder is tilted; left out')
            return
        self._add(Cylinder(self._name(name), pose[0, 3], pose[1, 3], radius, length,
                           self._bottom(name, pose, length), colour))

    def _read_sphere(self, sphere: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        radius, = _numbers(f'{name}: sphere: radius', sphere.findtext('radius'), 1)
        bottom = self._bottom(name, pose, 2.0 * radius)
        thickness = 2.0 * radius / SLICES
        for index in range(SLICES):
            above = (index + 0.5) * thickness - radius  # the middle of the slice, from that of the sphere
            self._add(Cylinder(self._name(name), pose[0, 3], pose[1, 3], math.sqrt(radius * radius - above * above),
                               thickness, bottom + index * thickness, colour))

    def _read_plane(self, plane: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        normal = pose[:3, :3] @ _numbers(f'{name}: plane: normal', plane.findtext('normal') or '0 0 1', 3)
        if normal[2] < math.cos(UPRIGHT) * np.linalg.norm(normal) or abs(pose[2, 3]) > FLOOR:
            self.warnings.append(f'{name}: the <plane> is not the floor; left out')
        elif colour != GREY:
            self._colours['ground_colour'] = colour

    def _read_mesh(self, mesh: Element, pose: np.ndarray, name: str, colour: Colour) -> None:
        uri = (mesh.findtext('uri') or '').strip()
        scale = _numbers(f'{name}: mesh: scale', mesh.findtext('scale') or '1 1 1', 3)
        marker = MARKER.search(uri)
        if marker and _upright_axis(pose) == 2:
            board, marker_size = (scale[2] * length for length in MARKER_MESH)
            self._add(Panel(self._name(name.partition('/')[0]), int(marker.group(1)), pose[0, 3], pose[1, 3],
                            math.atan2(pose[1, 0], pose[0, 0]), board, marker_size, max(0.0, pose[2, 3])))
            return
        try:
            path = meshes.find(uri, self._folder)
            box = meshes.read_box(path)
            if box is None:
                self._add_walls(meshes.triangles(path) * scale, pose, name, colour)
                return
        except InvalidInput as error:
            self.warnings.append(f'{name}: <mesh> {uri} is left out: {error}')
            return
        centre, size = box
        to_centre = np.eye(4)
        to_centre[:3, 3] = centre * scale
        self._add_box((size * np.abs(scale)).tolist(), pose @ to_centre, name, colour)

    def _add_walls(self, triangles: np.ndarray, pose: np.ndarray, name: str, colour: Colour) -> None:
        """Add the walls of a mesh, triangles (N, 3, 3) [m] in the frame of ``pose``, as thin boxes."""
        for number, wall in enumerate(meshes.walls(triangles @ pose[:3, :3].T + pose[:3, 3]), 1):
            self._add(Box(self._name(f'{name}/{number}'), wall.x, wall.y, wall.yaw, wall.length, meshes.THICKNESS,
                          wall.top - wall.bottom, wall.bottom, colour))

    def _add(self, shape: Shape) -> None:
        """Add a shape, with numpy floats converted to those of Python."""
        kind: Any = type(shape)
        self._shapes[kind].append(kind(*(float(value) if isinstance(value, np.floating) else value
                                         for value in shape)))

    def _bottom(self, name: str, pose: np.ndarray, height: float) -> float:
        bottom: float = pose[2, 3] - height / 2.0
        if bottom < -FLOOR:
            self.warnings.append(f'{name}: it reaches {-bottom:.3f} m into the floor; here it stands on the floor')
        return max(0.0, bottom)

    def _name(self, name: str) -> str:
        unique, number = name, 1
        while unique in self._names:
            number += 1
            unique = f'{name}_{number}'
        self._names.add(unique)
        return unique

    def _pose(self, name: str, element: Element) -> np.ndarray:
        """Return ``pose_of`` an element; a warning says if it is relative to something else than its parent."""
        pose = element.find('pose')
        other = pose is not None and (pose.get('relative_to') or pose.get('frame'))
        if other:
            self.warnings.append(f'{name}: its <pose> relative to {other} is used as relative to its parent')
        return pose_of(name, element)


def pose_of(name: str, element: Element) -> np.ndarray:
    """Return the matrix (4, 4) of an element's <pose>: x y z [m] roll pitch yaw [rad]."""
    pose = element.find('pose')
    matrix = np.eye(4)
    if pose is not None:
        x, y, z, roll, pitch, yaw = _numbers(f'{name}: pose', pose.text or '0 0 0 0 0 0', 6)
        matrix[:3, :3], matrix[:3, 3] = matrix_from_rpy(roll, pitch, yaw), (x, y, z)
    return matrix


def colour_of(visual: Element) -> Optional[Colour]:
    """Return the colour of a <visual>, None if it has none that is known."""
    script = (visual.findtext('material/script/name') or '').strip()
    if script:
        return COLOURS.get(script.rpartition('/')[2].lower())
    for kind in ('diffuse', 'ambient'):
        if visual.find(f'material/{kind}') is not None:
            return _rgb(f'{visual.get("name")}: material: {kind}', visual.findtext(f'material/{kind}'))
    return None


def _upright_axis(pose: np.ndarray) -> Optional[int]:
    """Return which own axis, 0 to 2, of a pose (4, 4) is vertical, or None."""
    for axis in range(3):
        if abs(pose[2, axis]) > math.cos(UPRIGHT):
            return axis
    return None


def _numbers(where: str, text: Optional[str], length: int) -> List[float]:
    try:
        numbers = [float(word) for word in (text or '').split()]
    except ValueError:
        numbers = []
    if len(numbers) != length or not all(map(math.isfinite, numbers)):
        raise InvalidInput(f'{where} is {shown((text or "").strip())}; it must be {length} finite numbers')
    return numbers


def _rgb(where: str, text: Optional[str]) -> Colour:
    """Return (r, g, b) 0..255 of three or four numbers from 0 to 1."""
    words = (text or '').split()
    red, green, blue = (round(255 * min(max(part, 0.0), 1.0)) for part in _numbers(where, ' '.join(words[:3]), 3))
    return red, green, blue
