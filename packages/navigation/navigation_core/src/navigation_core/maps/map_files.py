"""Map files as map_server reads and map_saver writes them: a YAML file and an image."""
import itertools
import math
import os
import re
import struct
from typing import Any, Mapping, NamedTuple, Tuple

import cv2
import numpy as np

from navigation_core.maps.grid_map import FREE, MAX_CELLS, OCCUPIED, UNKNOWN, GridMap
from navigation_core.poses import Array, Pose
from plain_support import documents, shown, write_together
from plain_support.documents import DocumentError

MODES = 'trinary', 'scale', 'raw'
OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196  # that map_saver writes
WHITE, GREY, BLACK = 254, 205, 0  # values of pixels that map_saver writes: free, unknown, occupied
HEADER_BYTES = 10_000  # of an image, in which its size stands


class MapError(ValueError):
    """A map cannot be read or written; the text names file, key and value. ``missing``: there is no such file."""

    def __init__(self, text: str, missing: bool = False) -> None:
        super().__init__(text)
        self.missing = missing


class Description(NamedTuple):
    """What the YAML file of a map says."""

    image: str
    resolution: float
    origin: Pose
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: str


def read_description(path: str) -> Description:
    """Return the Description in a YAML file; its image is relative to the file's folder. Raise MapError."""
    try:
        content = documents.read_yaml(path)
    except OSError as error:
        raise MapError(f'Map_server could not open {path}: {error.strerror}. Type the path of a YAML file that '
                       'map_saver has written', isinstance(error, FileNotFoundError)) from None
    except DocumentError as error:
        raise MapError(f'{path} is not a map file: {error}') from None
    if not isinstance(content, dict):
        raise MapError(f'{path} is not a map file: it must contain lines such as "resolution: 0.05"')
    try:
        image = content.get('image')
        if not isinstance(image, str) or not image:
            raise MapError(f'image is {shown(image)}; it must be the path of a PGM or PNG file')
        mode = content.get('mode', MODES[0])
        if mode not in MODES:
            raise MapError(f'mode is {shown(mode)}; it must be one of {", ".join(MODES)}')
        origin = content.get('origin')
        if not isinstance(origin, list) or len(origin) != 3:
            raise MapError(f'origin is {shown(origin)}; it must be [x, y, yaw] of the lower left corner, in m and rad')
        described = Description(
            os.path.join(os.path.dirname(path), image), _number('resolution', content.get('resolution')),
            Pose(*(_number('origin', value) for value in origin)), bool(_number('negate', content.get('negate'))),
            _number('occupied_thresh', content.get('occupied_thresh')),
            _number('free_thresh', content.get('free_thresh')), mode)
        if described.resolution <= 0.0:
            raise MapError(f'resolution is {described.resolution:g}; it must be more than 0 m for each pixel')
    except MapError as error:
        raise MapError(f'{path}: {error}') from None
    return described


def read_image(described: Description) -> GridMap:
    """Return the map that a description and its image make; raise MapError."""
    path = described.image
    try:
        with open(path, 'rb') as file:
            size = image_size(file.read(HEADER_BYTES))
            if size and size[0] * size[1] > MAX_CELLS:
                raise MapError(f'the image {path} has {size[0]} x {size[1]} pixels; a map has at most {MAX_CELLS} '
                               'cells, such as 5000 x 5000. Save it with a coarser resolution, or cut it')
            file.seek(0)
            pixels = cv2.imdecode(np.frombuffer(file.read(), np.uint8), cv2.IMREAD_UNCHANGED)
    except OSError as error:
        raise MapError(f'failed to open image file "{path}": {error.strerror}', True) from None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise MapError(f'failed to open image file "{path}": it is not a PGM, PNG, BMP or JPEG image')
    if pixels.dtype != np.uint8:
        pixels = (pixels / 257.0).astype(np.uint8)
    return GridMap(_cells(pixels if pixels.ndim == 3 else pixels[:, :, None], described)[::-1], described.resolution,
                   described.origin)


def image_size(start: bytes) -> Tuple[int, ...]:
    """Return (width, height) as the first bytes of a PNG or PGM file state them, else ()."""
    if start.startswith(b'\x89PNG') and len(start) >= 24:
        return struct.unpack('>II', start[16:24])
    if start[:2] in (b'P2', b'P3', b'P5', b'P6'):
        words = b' '.join(line.partition(b'#')[0] for line in start[2:].split(b'\n')[:50]).split()
        if len(words) >= 2 and words[0].isdigit() and words[1].isdigit():
            return int(words[0]), int(words[1])
    return ()


def saved(grid: GridMap, name: str, occupied: int = 65, free: int = 25) -> Tuple[bytes, bytes]:
    """Return the bytes of the PGM and of the YAML file that map_saver writes as NAME.pgm and NAME.yaml.

    Cells of at least ``occupied`` are black, of 0 to ``free`` white, others grey.
    """
    cells = grid.cells[::-1]
    pixels = np.where((cells >= 0) & (cells <= free), WHITE, np.where(cells >= occupied, BLACK, GREY)).astype(np.uint8)
    header = f'P5\n# CREATOR: map_saver.cpp {grid.resolution:.3f} m/pix\n{grid.width} {grid.height}\n255\n'
    origin = ', '.join(f'{value:f}' for value in grid.origin)
    text = (f'image: {os.path.basename(name)}.pgm\nresolution: {grid.resolution:f}\norigin: [{origin}]\nnegate: 0\n'
            f'occupied_thresh: {OCCUPIED_THRESH}\nfree_thresh: {FREE_THRESH}\n\n')
    return header.encode() + pixels.tobytes(), text.encode()


def keep_earlier(name: str, files: Mapping[str, bytes]) -> str:
    """Copy the map NAME that ``files`` will replace to the next free NAME_2, NAME_3, ...; return that name, or ''.

    ``files``: {path: content} of NAME.pgm and NAME.yaml. Files that stay the same are not copied. Raise OSError.
    """
    earlier = {}
    for path in filter(os.path.isfile, files):
        with open(path, 'rb') as file:
            earlier[path] = file.read()
    if all(files[path] == content for path, content in earlier.items()):
        return ''
    kept = next(free for free in (f'{name}_{number}' for number in itertools.count(2))
                if not any(os.path.lexists(free + os.path.splitext(path)[1]) for path in files))
    own, new = (os.path.basename(path).encode() + b'.pgm' for path in (name, kept))
    image = re.compile(rb'^image: (.*/)?%b$' % re.escape(own), re.MULTILINE)  # in the text, not in the image
    write_together({kept + os.path.splitext(path)[1]: image.sub(lambda _: b'image: ' + new, content, 1)
                    if path.endswith('.yaml') else content for path, content in earlier.items()})
    return kept


def _cells(pixels: Array, described: Description) -> Array:
    """Return the cells of pixels (rows, columns, channels); the mean of the channels says how dark one is.

    In the mode trinary, an alpha channel counts as one of them. In the mode scale, a pixel that is transparent is
    unknown.
    """
    channels = pixels.shape[2]
    alpha = channels in (2, 4)
    coloured = pixels if described.mode == 'trinary' or not alpha else pixels[:, :, :-1]
    light = coloured.mean(axis=2)
    if described.negate:
        light = 255.0 - light
    if described.mode == 'raw':
        return np.asarray(light.astype(np.uint8).astype(np.int8))
    dark = (255.0 - light) / 255.0
    if described.mode == 'trinary':
        between: Any = UNKNOWN
    else:
        share = (dark - described.free_thresh) / max(described.occupied_thresh - described.free_thresh, 1e-9)
        between = np.trunc(1.0 + 98.0 * share)
        if alpha:
            between = np.where(pixels[:, :, -1] == 0, UNKNOWN, between)
    cells = np.where(dark > described.occupied_thresh, OCCUPIED, np.where(dark < described.free_thresh, FREE, between))
    return np.asarray(cells.astype(np.int8))


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) and key == 'negate':
        return float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise MapError(f'{key} is {shown(value)}; it must be a number')
    return float(value)
