"""Find and read models and worlds of Gazebo: files, model://NAME, URDF and SDF. No ROS."""
import os
from typing import List, NamedTuple, Sequence, Tuple
from xml.etree.ElementTree import Element

import numpy as np

from gazebo_ros.core import urdf
from kinematic_core.worlds.floor_plan import EMPTY, FloorPlan
from plain_support import InvalidInput, documents
from plain_support.documents import DocumentError
from sim_scene import sdf, worlds

FOUND_BY = 'GAZEBO_MODEL_PATH'  # the variable in which sim_scene looks for models
ONLY_GAZEBO_HAS = ('elevator', 'mud', 'range', 'rubble', 'willowgarage')  # worlds whose shapes are meshes of Gazebo's


class Found(NamedTuple):
    """A model of a world: name, <model>, pose (4, 4), the folder where its meshes are searched."""

    name: str
    element: Element
    pose: np.ndarray
    folder: str


def use_folders(folders: Sequence[str]) -> None:
    """Also search for models in these folders from now on."""
    known = [folder for folder in os.environ.get(FOUND_BY, '').split(':') if folder]
    os.environ[FOUND_BY] = ':'.join(known + [folder for folder in folders if folder not in known])


def parse(text: str) -> Element:
    """Return the SDF <model> of a URDF or SDF text; raise InvalidInput if it is neither."""
    try:
        root = documents.parse_xml(text)
    except DocumentError as error:
        raise InvalidInput(f'the model is {error}') from None
    if root.tag == 'robot':
        return urdf.to_sdf(root)
    model = root if root.tag == 'model' else root.find('.//model') if root.tag in ('sdf', 'gazebo') else None
    if model is not None:
        return model
    uri = root.findtext('.//include/uri')
    if uri is None:
        raise InvalidInput(f'the model is neither URDF nor SDF: it begins with <{root.tag:.80}>; it must be <robot>, '
                           'or <sdf> with a <model>')
    return sdf.included(uri.strip(), os.getcwd())[0]


def load_world(world: str, folders: Sequence[str]) -> Tuple[FloorPlan, List[Found], List[str]]:
    """Return (plan, models, warnings) of a world: a file, or a name, which is searched in ``folders``.

    A YAML world is a plan without models; an SDF world has models, and a plan with its colours and moving panels.
    """
    path = next((path for path in (os.path.join(folder, name) for folder in ('', *folders)
                                   for name in (world, os.path.basename(world))) if os.path.isfile(path)), None)
    name = os.path.splitext(os.path.basename(world))[0]
    if path is None and name in ONLY_GAZEBO_HAS:
        return EMPTY, [], [f'The world {name} consists of meshes that only Gazebo has: here it is an empty floor.']
    if path is None or not path.endswith(worlds.SDF_SUFFIXES):
        known = next((folder for folder in folders if os.path.isfile(os.path.join(folder, f'{name}{worlds.SUFFIX}'))),
                     folders[-1])
        plan, warnings = worlds.load_world(path or world, known)
        return plan, [], warnings
    read = sdf.read_world(path)
    return (read.colours._replace(panels=read.panels),
            [Found(model.name, model.element, model.pose, model.folder) for model in read.models], read.warnings)
