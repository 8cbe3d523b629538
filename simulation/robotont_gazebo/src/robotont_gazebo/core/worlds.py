"""World files: a YAML format of our own, and the search for the file that a launch file names. No ROS.

A world is a mapping with lists of shapes; their keys are the fields of floor_plan's Box, Cylinder and
Panel, with the same units, frames and defaults. All keys are optional, others are refused::

    ground_colour: grey            # a name of colours.COLOURS or [red, green, blue], 0 to 255
    sky_colour: [150, 190, 230]
    may_overlap: false             # true: shapes may overlap
    boxes:
      - {name: wall, x: 1.0, y: 0.0, yaw: 0.0, length: 0.1, width: 2.0, height: 0.5, bottom: 0.0, colour: red}
    cylinders:
      - {name: post, x: 0.0, y: 2.0, radius: 0.5, height: 1.0, bottom: 0.0, colour: blue}
    panels:
      - {name: marker1, marker_id: 1, x: 3.0, y: 0.0, yaw: 0.0, size: 0.4, marker_size: 0.28, bottom: 0.05}
"""
import json
import os
from typing import Any, Dict, Iterable, List, Tuple, Type, Union

from kinematic_core.worlds.floor_plan import EMPTY, Box, Cylinder, FloorPlan, Panel, Shape
from plain_support import InvalidInput, documents, shown
from plain_support.documents import DocumentError
from robotont_gazebo.core import sdf
from robotont_gazebo.core.colours import COLOURS

Kind = Union[Type[Box], Type[Cylinder], Type[Panel]]

KINDS = {'boxes': Box, 'cylinders': Cylinder, 'panels': Panel}
COLOUR_KEYS = ('ground_colour', 'sky_colour')
KEYS = (*COLOUR_KEYS, 'may_overlap', *KINDS)
SDF_SUFFIXES = ('.world', '.sdf')
SUFFIX = '.yaml'


class WorldError(InvalidInput):
    """A world file cannot be used; the text names the file, the shape and the key."""


def load_world(world: str, folder: str) -> Tuple[FloorPlan, List[str]]:
    """Return (FloorPlan, warnings) of a world: a path, or the name of a YAML file in ``folder``.

    If there is no such file, its name is used: ``worlds/minimaze.world``, as in launch files for Gazebo, then means the
    world minimaze in ``folder``. Raise WorldError if that does not exist either, or if the world is not valid.
    """
    path = find_world(world, folder)
    if path.endswith(SDF_SUFFIXES):
        try:
            return sdf.read(path)
        except InvalidInput as error:
            raise WorldError(f'{path}: {error}') from None
    return read_yaml(path), []


def find_world(world: str, folder: str) -> str:
    """Return the path of a world that is named as in ``load_world``."""
    if os.path.isfile(world):
        if not world.endswith((SUFFIX, '.yml', *SDF_SUFFIXES)):
            raise WorldError(f'{world}: the name of a world file ends in {SUFFIX}, {" or ".join(SDF_SUFFIXES)}')
        return world
    name = os.path.splitext(os.path.basename(world))[0]
    known = os.path.join(folder, name + SUFFIX)
    if not os.path.isfile(known):
        names = sorted(os.path.splitext(file)[0] for file in os.listdir(folder) if file.endswith(SUFFIX))
        raise WorldError(f'there is no world {world!r}: it is neither a file nor one of {", ".join(names)}')
    return known


def read_yaml(path: str) -> FloorPlan:
    """Return the FloorPlan of a YAML file; raise WorldError if it is not valid."""
    try:
        return _parse_document(documents.read_yaml(path))
    except OSError as error:
        raise WorldError(f'{path}: {error.strerror or error}') from None
    except (DocumentError, InvalidInput) as error:
        raise WorldError(f'{path}: {error}') from None


def parse_yaml(text: Union[str, bytes]) -> FloorPlan:
    """Return the FloorPlan that a YAML text describes; raise InvalidInput, without a file name, if it is not valid."""
    try:
        return _parse_document(documents.parse_yaml(text))
    except DocumentError as error:
        raise InvalidInput(str(error)) from None


def _parse_document(world: Any) -> FloorPlan:
    return parse({} if world is None else world)


def parse_json(text: str) -> FloorPlan:
    """Return the FloorPlan of a text from ``to_json``, a hundred times as fast as ``parse_yaml`` reads it."""
    return parse(json.loads(text))


def parse(world: Any) -> FloorPlan:
    """Return the FloorPlan that a mapping describes; raise InvalidInput if it is not valid."""
    _check_keys('the world', world, KEYS)
    fields: Dict[str, Any] = {key: _colour(key, world[key]) for key in COLOUR_KEYS if key in world}
    fields.update({key: _shapes(key, kind, world[key]) for key, kind in KINDS.items() if key in world})
    plan = EMPTY._replace(**fields)
    plan.check()
    may_overlap = world.get('may_overlap', False)
    if not isinstance(may_overlap, bool):
        raise InvalidInput(f'may_overlap is {shown(may_overlap)}; it must be true or false')
    overlaps = [] if may_overlap else plan.overlaps()
    if overlaps:
        name, other, depth = overlaps[0]
        more = f', and {len(overlaps) - 1} more pairs' if overlaps[1:] else ''
        raise InvalidInput(f'{name} and {other} overlap by {depth:.3f} m{more}; move one of them, or set '
                           'may_overlap: true')
    return plan


def to_json(plan: FloorPlan) -> str:
    """Return a FloorPlan as JSON, which is also the YAML of a world file."""
    world: Dict[str, Any] = {key: list(getattr(plan, key)) for key in COLOUR_KEYS}
    world.update({key: [shape._asdict() for shape in getattr(plan, key)] for key in KINDS}, may_overlap=True)
    return json.dumps(world)


def _shapes(key: str, kind: Kind, entries: Any) -> Tuple[Shape, ...]:
    if not isinstance(entries, list):
        raise InvalidInput(f'{key} is {shown(entries)}; it must be a list of shapes')
    return tuple(_shape(f'{key}[{index}]', kind, entry) for index, entry in enumerate(entries))


def _shape(where: str, kind: Kind, entry: Any) -> Shape:
    _check_keys(where, entry, kind._fields)
    named = f'{where} ({entry["name"]:.80})' if isinstance(entry.get('name'), str) else where
    if 'name' in entry and named == where:
        raise InvalidInput(f'{where}: name is {shown(entry["name"])}; it must be a string')
    missing = [field for field in kind._fields if field not in entry and field not in kind._field_defaults]
    if missing:
        raise InvalidInput(f'{named}: {missing[0]} is missing')
    if isinstance(entry.get('path'), list):
        entry = dict(entry, path=tuple(tuple(waypoint) if isinstance(waypoint, list) else waypoint
                                       for waypoint in entry['path']))
    if 'colour' in entry:
        entry = dict(entry, colour=_colour(f'{named}: colour', entry['colour']))
    return kind(**entry)


def _check_keys(where: str, mapping: Any, known: Iterable[str]) -> None:
    if not isinstance(mapping, dict):
        raise InvalidInput(f'{where} is {shown(mapping)}; it must be a mapping with some of the keys: '
                           f'{", ".join(known)}')
    for key in mapping:
        if key not in known:
            raise InvalidInput(f'{where}: unknown key {shown(key)}; the keys are: {", ".join(known)}')


def _colour(where: str, value: Any) -> Any:
    """Return the colour that a value names; other values are returned as they are, and FloorPlan.check refuses them."""
    if isinstance(value, str):
        if value not in COLOURS:
            raise InvalidInput(f'{where} is {shown(value)}; it must be [red, green, blue], 0 to 255 each, or one of: '
                               f'{", ".join(COLOURS)}')
        return COLOURS[value]
    return tuple(value) if isinstance(value, list) else value
