"""Files of markers: pictures (PNG) that print at their size, and of several in known places a bundle file (XML)."""
import struct
import zlib
from dataclasses import dataclass, replace

import cv2
import numpy as np

from alvar_core import bundles, drawing

DPI = 96.0  # pixels per inch of the pictures, as in the original
MAX_PIXELS = 20000  # of a picture's side
LETTERS_IN_NAME, IDS_IN_NAME = 9, 64  # letters of a text, length from which on no more ids are put into a file's name


class CreateError(ValueError):
    """What createMarker cannot do: the text says what, and what is possible."""


@dataclass(frozen=True)
class Marker:
    """A marker to draw.

    value: number or text; cells: (n, n) bool, true is white; margin: cells of the rim; side: of the black square, m;
    at: its centre right of and above the bundle's origin, m, or None; pixels: its side in a picture.
    """

    value: object
    cells: np.ndarray
    margin: int
    side: float
    at: object
    pixels: int

    @property
    def count(self):
        """Cells in a row, rim included."""
        return len(self.cells) + 2 * self.margin

    @property
    def black(self):
        """(count, count) bool, the whole black square."""
        return np.pad(~self.cells, self.margin, constant_values=True)

    @property
    def name(self):
        """How a file's name tells it: the number, or the text's first letters."""
        if not isinstance(self.value, str):
            return str(self.value)
        return ''.join(c.lower() if c.isalnum() else '_' for c in self.value[:LETTERS_IN_NAME])


def png(picture, metres):
    """The bytes of a PNG of a grey picture that is so many metres wide."""
    good, data = cv2.imencode('.png', picture)
    if not good:
        raise CreateError(f'OpenCV could not write a PNG of {picture.shape[1]} x {picture.shape[0]} pixels')
    data, per_metre = data.tobytes(), round(picture.shape[1] / metres)
    chunk = b'pHYs' + struct.pack('>IIB', per_metre, per_metre, 1)
    behind_header = 8 + 12 + 13
    return (data[:behind_header] + struct.pack('>I', 9) + chunk + struct.pack('>I', zlib.crc32(chunk))
            + data[behind_header:])


def picture_of(marker):
    """uint8 grey picture of a marker's black square."""
    if not marker.count <= marker.pixels <= MAX_PIXELS:
        raise CreateError(f'marker {marker.value}: its {marker.count} x {marker.count} cells on {marker.pixels} pixels '
                          f'({1e3 * marker.side:.4g} mm); {marker.count} to {MAX_PIXELS} pixels are possible (-s, -u)')
    return drawing.picture_of_cells(marker.cells, marker.pixels, marker.margin)


def picture_of_bundle(markers):
    """(uint8 grey picture, its width in metres) of markers at their places."""
    check_places(markers)
    scale = DPI / 0.0254
    lefts, tops = [m.at[0] - m.side / 2 for m in markers], [m.at[1] + m.side / 2 for m in markers]
    corners = [(round((x - min(lefts)) * scale), round((max(tops) - y) * scale)) for x, y in zip(lefts, tops)]
    width, height = (max(c[k] + m.pixels for c, m in zip(corners, markers)) for k in (0, 1))
    if max(width, height) > MAX_PIXELS:
        raise CreateError(f'a picture of {width} x {height} pixels is too large; up to {MAX_PIXELS} x {MAX_PIXELS} are '
                          'possible: put the markers nearer to each other (-xy) or make a sheet of each (--pdf)')
    picture = np.full((height, width), 255, np.uint8)
    for (x, y), marker in zip(corners, markers):
        picture[y:y + marker.pixels, x:x + marker.pixels] = picture_of(marker)
    return picture, width / scale


def check_places(markers):
    """CreateError if markers lie on each other, or an id is there twice."""
    for number, one in enumerate(markers):
        for other in markers[:number]:
            if other.value == one.value:
                raise CreateError(f'marker {one.value} is there twice; each marker of a bundle needs its own id')
            if max(abs(one.at[0] - other.at[0]), abs(one.at[1] - other.at[1])) < (one.side + other.side) / 2 - 1e-9:
                raise CreateError(f'markers {other.value} and {one.value} lie on each other; -xy X Y before an id says '
                                  'where it is')


def placed(markers):
    """The markers of a bundle; one without a place is at the origin."""
    return [replace(marker, at=marker.at or (0.0, 0.0)) for marker in markers]


def bundle_corners(markers):
    """{id: corners (4, 3) m} of the markers with a number, for bundles.xml()."""
    return {m.value: drawing.object_corners(m.side) + [*m.at, 0] for m in markers if not isinstance(m.value, str)}


def is_bundle(markers):
    """Whether markers were given places, and share one picture therefore."""
    return len(markers) > 1 and any(m.at is not None for m in markers)


def files(markers):
    """Return [(file name, bytes)] of markers: one PNG each, or of a bundle one PNG and its XML."""
    if is_bundle(markers):
        markers, name = placed(markers), 'MarkerData'
        for marker in markers:
            name += '_' + marker.name if len(name) < IDS_IN_NAME else ''
        corners = bundle_corners(markers)
        made = [(f'{name}.png', png(*picture_of_bundle(markers)))]
        return made + ([(f'{name}.xml', bundles.xml(corners).encode())] if len(corners) > 1 else [])
    made = {}
    for marker in markers:
        name, again = f'MarkerData_{marker.name}', 2
        data = png(picture_of(marker), marker.side)
        while made.get(f'{name}.png', data) != data:
            name, again = f'MarkerData_{marker.name}_{again}', again + 1
        made[f'{name}.png'] = data
    return list(made.items())
