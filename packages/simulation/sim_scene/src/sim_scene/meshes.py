"""Find the models that Gazebo worlds include, and read mesh files (STL, COLLADA) as boxes. No ROS."""
import math
import os
import re
from typing import Dict, Iterator, List, NamedTuple, Optional, Tuple
from xml.etree.ElementTree import Element

import cv2
import numpy as np

from plain_support import InvalidInput, documents

SEARCHED = ('GAZEBO_RESOURCE_PATH', 'GAZEBO_MODEL_PATH')  # folders, separated by colons
STL_HEADER, STL_TRIANGLE = 84, np.dtype([('normal', '<3f4'), ('corners', '<9f4'), ('attribute', '<u2')])
FLAT = 1e-3  # of the diagonal: a vertex this close to a corner of the bounding box counts as that corner
TRANSFORMATIONS = 'matrix', 'translate', 'rotate', 'scale'
CUT = 0.15  # [m] above the floor: what stands here is in the way of robots and of their lasers
THICKNESS = 0.02  # [m] of the boxes that stand for the walls of a mesh
SHORTEST = 0.005  # [m] pieces of an outline that are shorter are left out
SAME_LINE = 0.01  # [m] between pieces that are one wall
SAME_ANGLE = math.pi / 720.0  # [rad]
MOST_WALLS = 300  # of one mesh


def find(uri: str, folder: str) -> str:
    """Return the path of a mesh that a world file in ``folder`` names; InvalidInput if there is none.

    ``file://``, ``model://`` and ``package://`` are all searched in the folder, the one above it, the folder
    ``models`` in both, and the folders of the environment variables SEARCHED.
    """
    for candidate in _candidates(uri, folder):
        if os.path.isfile(candidate):
            return candidate
    raise _not_found('file', folder)


def find_model(uri: str, folder: str) -> str:
    """Return the path of the SDF file of a model ``model://NAME``; InvalidInput if there is none.

    It is searched as by ``find``. Its folder names its file in ``model.config``; otherwise it is ``model.sdf``.
    """
    for candidate in _candidates(uri, folder):
        if os.path.isfile(candidate):
            return candidate
        names = ['model.sdf']
        try:
            names[:0] = [name for name in reversed([(element.text or '').strip() for element in documents.read_xml(
                os.path.join(candidate, 'model.config')).findall('sdf')]) if name]
        except (OSError, ValueError):
            pass
        for path in (os.path.join(candidate, name) for name in names):
            if os.path.isfile(path):
                return path
    raise _not_found('model', folder)


def _candidates(uri: str, folder: str) -> List[str]:
    name = re.sub(r'^\w+://', '', uri)
    own, above = os.path.abspath(folder), os.path.dirname(os.path.abspath(folder))
    folders = [own, os.path.join(own, 'models'), above, os.path.join(above, 'models')]
    folders += [entry for variable in SEARCHED for entry in os.environ.get(variable, '').split(':') if entry]
    return [os.path.join(entry, name) for entry in folders]


def _not_found(what: str, folder: str) -> InvalidInput:
    own = os.path.abspath(folder)
    return InvalidInput(f'there is no such {what} in {own} and {os.path.dirname(own)}, nor in {" and ".join(SEARCHED)}')


def bounds(path: str) -> Tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner (3,) [m] of a mesh in its own frame; InvalidInput if unreadable."""
    vertices = _vertices(path)
    return vertices.min(0), vertices.max(0)


def read_box(path: str) -> Optional[Tuple[np.ndarray, np.ndarray]]:
    """Return (centre, size), each (3,) [m] in the mesh's frame, of a mesh that is a box; None for another shape."""
    vertices = _vertices(path)
    low, high = vertices.min(0), vertices.max(0)
    upper = vertices > (low + high) / 2.0
    corners = np.where(upper, high, low)
    if len(np.unique(upper, axis=0)) < 8 or np.abs(vertices - corners).max() > FLAT * np.linalg.norm(high - low):
        return None
    return (low + high) / 2.0, high - low


class Wall(NamedTuple):
    """A piece of a mesh that stands upright: its middle, direction and length, and how high it is."""

    x: float
    y: float
    yaw: float
    length: float
    bottom: float
    top: float


def walls(triangles: np.ndarray) -> List[Wall]:
    """Return the walls of triangles (N, 3, 3) [m] in the world: where they cross the plane at the height CUT.

    Pieces on one line become one. Raise InvalidInput if the mesh is elsewhere, or has more than MOST_WALLS of them.
    """
    low, high = triangles[:, :, 2].min(1), triangles[:, :, 2].max(1)
    crossing = (low < CUT) & (high > CUT)
    lines: Dict[Tuple[int, int], List[Tuple[float, float, float, float]]] = {}  # (direction, offset): pieces
    for triangle, bottom, top in zip(triangles[crossing], low[crossing], high[crossing]):
        (x, y), (other_x, other_y) = _crossing(triangle)
        length = math.hypot(other_x - x, other_y - y)
        if length < SHORTEST:
            continue
        angle = math.atan2(other_y - y, other_x - x) % math.pi
        direction = round(angle / SAME_ANGLE) % round(math.pi / SAME_ANGLE)
        cos, sin = math.cos(direction * SAME_ANGLE), math.sin(direction * SAME_ANGLE)
        start, end = sorted((cos * x + sin * y, cos * other_x + sin * other_y))
        offset = (cos * (y + other_y) - sin * (x + other_x)) / 2.0
        lines.setdefault((direction, round(offset / SAME_LINE)), []).append(
            (start, end, float(bottom), float(top)))
    found = [_wall(direction * SAME_ANGLE, offset * SAME_LINE, piece)
             for (direction, offset), pieces in lines.items() for piece in _joined(pieces)]
    if not found:
        raise InvalidInput(f'it is not a box, and no part of it stands {CUT:g} m above the floor')
    if len(found) > MOST_WALLS:
        raise InvalidInput(f'it is not a box, and its outline {CUT:g} m above the floor has {len(found)} pieces; at '
                           f'most {MOST_WALLS} are read')
    return found


def _crossing(triangle: np.ndarray) -> Tuple[Tuple[float, float], Tuple[float, float]]:
    """Return the two points (x, y) at which the sides of a triangle cross the plane at CUT."""
    points = []
    for start, end in ((0, 1), (1, 2), (2, 0)):
        below, above = triangle[start, 2] - CUT, triangle[end, 2] - CUT
        if (below < 0.0) != (above < 0.0):
            x, y = triangle[start, :2] + (triangle[end, :2] - triangle[start, :2]) * (below / (below - above))
            points.append((float(x), float(y)))
    return points[0], points[1]


def _joined(pieces: List[Tuple[float, float, float, float]]) -> List[Tuple[float, float, float, float]]:
    """Return the pieces (start, end, bottom, top) [m] of one line, with those that touch as one."""
    joined: List[Tuple[float, float, float, float]] = []
    for start, end, bottom, top in sorted(pieces):
        if joined and start <= joined[-1][1] + SAME_LINE:
            first, last, low, high = joined.pop()
            joined.append((first, max(last, end), min(low, bottom), max(high, top)))
        else:
            joined.append((start, end, bottom, top))
    return joined


def _wall(angle: float, offset: float, piece: Tuple[float, float, float, float]) -> Wall:
    start, end, bottom, top = piece
    cos, sin, middle = math.cos(angle), math.sin(angle), (start + end) / 2.0
    bottom = max(0.0, bottom)
    return Wall(cos * middle - sin * offset, sin * middle + cos * offset, angle, end - start, bottom, top)


def triangles(path: str) -> np.ndarray:
    """Return the triangles (N, 3, 3) [m] of a mesh file; raise InvalidInput if it cannot be read."""
    if path.lower().endswith('.stl'):
        return _vertices(path).reshape(-1, 3, 3)
    _vertices(path)  # refuses what cannot be read
    try:
        found = _collada_triangles(_collada_root(path))
    except (ValueError, IndexError, KeyError) as error:
        raise InvalidInput(f'it is not a box, and its triangles cannot be read: {error}') from None
    if not len(found):
        raise InvalidInput('it is not a box, and has no triangles')
    return found


def _vertices(path: str) -> np.ndarray:
    """Return the vertices (N, 3) [m] of a mesh file; raise InvalidInput if it cannot be read."""
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
    return vertices


def _stl(path: str) -> np.ndarray:
    """Return the vertices (N, 3) [m] of an STL file, binary or ASCII."""
    with open(path, 'rb') as file:
        content = file.read()
    count = int.from_bytes(content[STL_HEADER - 4:STL_HEADER], 'little')
    if len(content) == STL_HEADER + count * STL_TRIANGLE.itemsize:
        return np.frombuffer(content, STL_TRIANGLE, offset=STL_HEADER)['corners'].reshape(-1, 3).astype(float)
    words = re.findall(rb'\bvertex\s+(\S+)\s+(\S+)\s+(\S+)', content)  # ASCII
    return np.array([[float(word) for word in vertex] for vertex in words]).reshape(-1, 3)


def _collada_root(path: str) -> Element:
    root = documents.read_xml(path)
    for element in root.iter():
        element.tag = element.tag.rpartition('}')[2]
    return root  # as Gazebo, it does not heed <up_axis>: the meshes of public worlds are upright whatever that says


def _collada(path: str) -> np.ndarray:
    """Return the vertices (N, 3) [m] of a COLLADA file."""
    root = _collada_root(path)
    placed = [points @ matrix[:3, :3].T + matrix[:3, 3] for geometry, matrix in _placed(root)
              for points in _positions(geometry).values()]
    return np.concatenate(placed) if placed else np.zeros((0, 3))


def _collada_triangles(root: Element) -> np.ndarray:
    """Return the triangles (N, 3, 3) [m] of a COLLADA document."""
    found = [points[numbers] @ matrix[:3, :3].T + matrix[:3, 3] for geometry, matrix in _placed(root)
             for points, numbers in _faces(geometry)]
    return np.concatenate(found) if found else np.zeros((0, 3, 3))


def _placed(root: Element) -> List[Tuple[Element, np.ndarray]]:
    """Return each geometry with its matrix (4, 4), to metres, for each place in the scene."""
    unit = root.find('asset/unit')
    metres = np.diag([float(unit.get('meter', '1')) if unit is not None else 1.0] * 3 + [1.0])
    geometries = {'#' + (geometry.get('id') or ''): geometry for geometry in root.iter('geometry')}
    found: List[Tuple[Element, np.ndarray]] = []

    def visit(node: Element, parent: np.ndarray) -> None:
        matrix = parent @ _node_matrix(node)
        found.extend((geometries[url], matrix) for url in (each.get('url', '') for each in
                                                          node.findall('instance_geometry')) if url in geometries)
        for child in node.findall('node'):
            visit(child, matrix)
    for node in root.iterfind('.//visual_scene/node'):
        visit(node, metres)
    return found or [(geometry, metres) for geometry in geometries.values()]


def _node_matrix(node: Element) -> np.ndarray:
    """Return the product of a node's transformations."""
    matrix = np.eye(4)
    for element in node:
        step = np.eye(4)
        numbers = [float(word) for word in (element.text or '').split()] if element.tag in TRANSFORMATIONS else []
        if element.tag == 'matrix':
            step = np.array(numbers).reshape(4, 4)
        elif element.tag == 'translate':
            step[:3, 3] = numbers
        elif element.tag == 'scale':
            step[:3, :3] = np.diag(numbers)
        elif element.tag == 'rotate':
            step[:3, :3] = cv2.Rodrigues(np.array(numbers[:3]) * math.radians(numbers[3]))[0]
        elif element.tag in ('lookat', 'skew'):
            raise ValueError(f'its parts have a <{element.tag}>')
        matrix = matrix @ step
    return matrix


def _positions(geometry: Element) -> Dict[str, np.ndarray]:
    """Return {'#id' of <vertices>: positions (N, 3)} of a geometry."""
    sources = {'#' + source.get('id', ''): source.findtext('float_array') or '' for source in geometry.iter('source')}
    return {'#' + vertices.get('id', ''): np.array(sources[entry.get('source', '')].split(), float).reshape(-1, 3)
            for vertices in geometry.iter('vertices') for entry in vertices.findall('input')
            if entry.get('semantic') == 'POSITION'}


def _faces(geometry: Element) -> Iterator[Tuple[np.ndarray, np.ndarray]]:
    """Yield positions (N, 3) and the triangles (M, 3) of numbers in them."""
    positions = _positions(geometry)
    for faces in geometry.iter():
        if faces.tag not in ('triangles', 'polylist'):
            continue
        inputs = faces.findall('input')
        stride = 1 + max(int(entry.get('offset', '0')) for entry in inputs)
        vertex = next(entry for entry in inputs if entry.get('semantic') == 'VERTEX')
        every = np.array((faces.findtext('p') or '').split(), int).reshape(-1, stride)
        numbers = every[:, int(vertex.get('offset', '0'))]
        if faces.tag == 'triangles':
            yield positions[vertex.get('source', '')], numbers.reshape(-1, 3)
            continue
        first, corners = 0, []
        for count in map(int, (faces.findtext('vcount') or '').split()):
            corners += [(numbers[first], numbers[first + after], numbers[first + after + 1])
                        for after in range(1, count - 1)]
            first += count
        yield positions[vertex.get('source', '')], np.array(corners, int).reshape(-1, 3)
