"""Read mesh files (STL, COLLADA) that are boxes, as walls of Gazebo worlds often are. No ROS."""
import os
import re
from typing import Tuple

import numpy as np

from plain_support import InvalidInput, documents

SEARCHED = ('GAZEBO_RESOURCE_PATH', 'GAZEBO_MODEL_PATH')  # folders, separated by colons
STL_HEADER, STL_TRIANGLE = 84, np.dtype([('normal', '<3f4'), ('corners', '<9f4'), ('attribute', '<u2')])
FLAT = 1e-3  # of the diagonal: a vertex this close to a corner of the bounding box counts as that corner
IDENTITY = np.eye(4)


def find(uri: str, folder: str) -> str:
    """Return the path of a mesh that a world file in ``folder`` names; InvalidInput if there is none.

    ``file://``, ``model://`` and ``package://`` are all searched in the folder, the one above it, the folder
    ``models`` in both, and the folders of the environment variables SEARCHED.
    """
    name = re.sub(r'^\w+://', '', uri)
    own, above = os.path.abspath(folder), os.path.dirname(os.path.abspath(folder))
    folders = [own, os.path.join(own, 'models'), above, os.path.join(above, 'models')]
    folders += [entry for variable in SEARCHED for entry in os.environ.get(variable, '').split(':') if entry]
    for candidate in (os.path.join(entry, name) for entry in folders):
        if os.path.isfile(candidate):
            return candidate
    raise InvalidInput(f'there is no such file in {own} and {above}, nor in {" and ".join(SEARCHED)}')


def read_box(path: str) -> Tuple[np.ndarray, np.ndarray]:
    """Return (centre, size), each (3,) [m] in the mesh's frame, of a mesh that is a box; else raise InvalidInput."""
    reader = {'.stl': _stl, '.dae': _collada}.get(os.path.splitext(path)[1].lower())
    if reader is None:
        raise InvalidInput('only .stl and .dae are supported')
    try:
        vertices = reader(path)
    except OSError as error:
        raise InvalidInput(error.strerror or str(error)) from None
    except (ValueError, OverflowError) as error:
        raise InvalidInput(f'it cannot be read: {error}') from None
    if not len(vertices) or not np.isfinite(vertices).all():
        raise InvalidInput('it has no vertices, or not all of them are finite')
    low, high = vertices.min(0), vertices.max(0)
    upper = vertices > (low + high) / 2.0
    corners = np.where(upper, high, low)
    if len(np.unique(upper, axis=0)) < 8 or np.abs(vertices - corners).max() > FLAT * np.linalg.norm(high - low):
        raise InvalidInput('it is not a box')
    return (low + high) / 2.0, high - low


def _stl(path: str) -> np.ndarray:
    """Return the vertices (N, 3) [m] of an STL file, binary or ASCII."""
    with open(path, 'rb') as file:
        content = file.read()
    count = int.from_bytes(content[STL_HEADER - 4:STL_HEADER], 'little')
    if len(content) == STL_HEADER + count * STL_TRIANGLE.itemsize:
        return np.frombuffer(content, STL_TRIANGLE, offset=STL_HEADER)['corners'].reshape(-1, 3).astype(float)
    words = re.findall(rb'\bvertex\s+(\S+)\s+(\S+)\s+(\S+)', content)  # ASCII
    return np.array([[float(word) for word in vertex] for vertex in words]).reshape(-1, 3)


def _collada(path: str) -> np.ndarray:
    """Return the vertices (N, 3) [m] of a COLLADA file."""
    root = documents.read_xml(path)
    for element in root.iter():
        element.tag = element.tag.rpartition('}')[2]
    if root.findtext('asset/up_axis', 'Y_UP').strip() != 'Z_UP':
        raise ValueError('its up_axis is not Z_UP')
    for node in root.iterfind('.//visual_scene//node'):
        matrix = np.array((node.findtext('matrix') or '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1').split(), float)
        if node.find('.//instance_geometry') is not None and (
                any(node.find(tag) is not None for tag in ('translate', 'rotate', 'scale', 'lookat', 'skew'))
                or not np.allclose(matrix, IDENTITY.ravel())):
            raise ValueError('its parts are translated or rotated')
    unit = root.find('asset/unit')
    metres = float(unit.get('meter', '1')) if unit is not None else 1.0
    sources = {'#' + source.get('id', ''): source.findtext('float_array') or '' for source in root.iter('source')}
    numbers = [sources.get(entry.get('source', ''), '').split() for entry in root.iterfind('.//vertices/input')
               if entry.get('semantic') == 'POSITION']
    vertices: np.ndarray = metres * np.array([float(word) for words in numbers for word in words]).reshape(-1, 3)
    return vertices
