"""World files: YAML as in kinematic_core's world_format, or SDF, and the search for the file that a launch file names.

No ROS.
"""
import os
from typing import List, Tuple

from kinematic_core.worlds import world_format
from kinematic_core.worlds.floor_plan import FloorPlan
from plain_support import InvalidInput, documents
from plain_support.documents import DocumentError
from sim_scene import sdf

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
        world = documents.read_yaml(path)
        return world_format.parse({} if world is None else world)
    except OSError as error:
        raise WorldError(f'{path}: {error.strerror or error}') from None
    except (DocumentError, InvalidInput) as error:
        raise WorldError(f'{path}: {error}') from None
