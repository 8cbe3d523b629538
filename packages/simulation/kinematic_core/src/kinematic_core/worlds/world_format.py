"""Worlds as mappings, the content of world files and of the topic ``world``.

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
from typing import Any, Dict, Iterable, Tuple, Type, Union

from kinematic_core.worlds.colours import COLOURS
from kinematic_core.worlds.floor_plan import EMPTY, Box, Cylinder, FloorPlan, Panel, Shape
from plain_support import InvalidInput, shown

Kind = Union[Type[Box], Type[Cylinder], Type[Panel]]

KINDS = {'boxes': Box, 'cylinders': Cylinder, 'panels': Panel}
COLOUR_KEYS = ('ground_colour', 'sky_colour')
KEYS = (*COLOUR_KEYS, 'may_overlap', *KINDS)


def parse_json(text: str) -> FloorPlan:
    """Return the FloorPlan of a text from ``to_json``, a hundred times as fast as YAML is read."""
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
