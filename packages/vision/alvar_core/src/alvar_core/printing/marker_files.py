"""Make the files of markers: images (PNG) that print at true size, and a bundle file (XML) for several markers."""
from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, replace
from typing import Sequence, Tuple

import cv2
import numpy as np

from alvar_core import bundles, drawing
from alvar_core.arrays import Bools, Floats, Image
from alvar_core.code import Value

DPI = 96.0  # pixels per inch of the images, as in the original
PAGES = {'a4': (210.0, 297.0), 'letter': (215.9, 279.4)}  # [mm]
MAX_PIXELS = 20000  # [px] side of an image
LETTERS_IN_NAME = 9  # characters of a marker's text in a file name
IDS_IN_NAME = 64  # characters: a file name of this length gets no more ids

File = Tuple[str, bytes]  # name, content


class CreateError(ValueError):
    """createMarker cannot fulfil a request; the text says what is possible."""


@dataclass(frozen=True)
class Marker:
    """A marker to draw.

    ``value``: number or text; ``cells`` (n, n), bool, True is white; ``margin`` [cells]: width of the border; ``side``
    [m] of the black square; ``at`` [m]: its centre to the right of and above the bundle's origin, or None; ``pixels``:
    its side in an image.
    """

    value: Value
    cells: Bools
    margin: int
    side: float
    at: tuple[float, float] | None
    pixels: int

    @property
    def centre(self) -> tuple[float, float]:
        """Return ``at``, or the origin for a marker without a position."""
        return self.at or (0.0, 0.0)

    @property
    def count(self) -> int:
        """Return the number of cells in a row, including the border."""
        return len(self.cells) + 2 * self.margin

    @property
    def black(self) -> Bools:
        """Return the black cells (count, count), bool, of the whole marker."""
        return np.pad(~self.cells, self.margin, constant_values=True)

    @property
    def name(self) -> str:
        """Return its part of a file name: the number, or the first letters of the text."""
        if not isinstance(self.value, str):
            return str(self.value)
        return ''.join(c.lower() if c.isalnum() else '_' for c in self.value[:LETTERS_IN_NAME])


def png(image: Image, metres: float) -> bytes:
    """Return the bytes of a PNG of a grey image that prints ``metres`` wide."""
    good, encoded = cv2.imencode('.png', image)
    if not good:
        raise CreateError(f'OpenCV could not write a PNG of {image.shape[1]} x {image.shape[0]} pixels')
    data, per_metre = encoded.tobytes(), round(image.shape[1] / metres)
    chunk = b'pHYs' + struct.pack('>IIB', per_metre, per_metre, 1)
    behind_header = 8 + 12 + 13
    return (data[:behind_header] + struct.pack('>I', 9) + chunk + struct.pack('>I', zlib.crc32(chunk))
            + data[behind_header:])


def image_of(marker: Marker) -> Image:
    """Return the grey image, uint8, of a marker's black square."""
    if not marker.count <= marker.pixels <= MAX_PIXELS:
        raise CreateError(f'marker {marker.value}: its {marker.count} x {marker.count} cells on {marker.pixels} pixels '
                          f'({1e3 * marker.side:.4g} mm); {marker.count} to {MAX_PIXELS} pixels are possible (-s, -u)')
    return drawing.image_of_cells(marker.cells, marker.pixels, marker.margin)


def image_of_bundle(markers: Sequence[Marker]) -> tuple[Image, float]:
    """Return (grey image uint8, its width [m]) of markers at their positions."""
    check_places(markers)
    scale = DPI / 0.0254
    lefts, tops = [m.centre[0] - m.side / 2 for m in markers], [m.centre[1] + m.side / 2 for m in markers]
    corners = [(round((x - min(lefts)) * scale), round((max(tops) - y) * scale)) for x, y in zip(lefts, tops)]
    width, height = (max(c[k] + m.pixels for c, m in zip(corners, markers)) for k in (0, 1))
    if max(width, height) > MAX_PIXELS:
        raise CreateError(f'an image of {width} x {height} pixels is too large; up to {MAX_PIXELS} x {MAX_PIXELS} are '
                          'possible: put the markers closer together (-xy), or print each on its own (--pdf)')
    image = np.full((height, width), 255, np.uint8)
    for (x, y), marker in zip(corners, markers):
        image[y:y + marker.pixels, x:x + marker.pixels] = image_of(marker)
    return image, width / scale


def check_places(markers: Sequence[Marker]) -> None:
    """Raise CreateError if markers overlap or an id appears twice."""
    for number, one in enumerate(markers):
        for other in markers[:number]:
            if other.value == one.value:
                raise CreateError(f'marker {one.value} appears twice; each marker of a bundle needs its own id')
            away = max(abs(a - b) for a, b in zip(one.centre, other.centre))
            if away < (one.side + other.side) / 2 - 1e-9:
                raise CreateError(f'markers {other.value} and {one.value} overlap; place them with -xy X Y')


def placed(markers: Sequence[Marker]) -> list[Marker]:
    """Return the markers of a bundle; one without a position is put at the origin."""
    return [replace(marker, at=marker.centre) for marker in markers]


def bundle_corners(markers: Sequence[Marker]) -> dict[Value, Floats]:
    """Return {id: corners (4, 3) [m]} of the markers with a number, for bundles.xml."""
    return {m.value: drawing.object_corners(m.side) + [*m.centre, 0] for m in markers if not isinstance(m.value, str)}


def is_bundle(markers: Sequence[Marker]) -> bool:
    """Return whether the markers have positions, and so share one image."""
    return len(markers) > 1 and any(m.at is not None for m in markers)


def files(markers: Sequence[Marker]) -> list[File]:
    """Return the files of markers: a PNG for each, or one PNG and one XML for a bundle."""
    return _files_of_bundle(placed(markers)) if is_bundle(markers) else _files_of_each(markers)


def _files_of_bundle(markers: Sequence[Marker]) -> list[File]:
    name = 'MarkerData'
    for marker in markers:
        name += '_' + marker.name if len(name) < IDS_IN_NAME else ''
    made = [(f'{name}.png', png(*image_of_bundle(markers)))]
    corners = bundle_corners(markers)
    if len(corners) > 1:
        made.append((f'{name}.xml', bundles.xml(corners).encode()))
    return made


def _files_of_each(markers: Sequence[Marker]) -> list[File]:
    made: dict[str, bytes] = {}
    for marker in markers:
        name, again = f'MarkerData_{marker.name}', 2
        data = png(image_of(marker), marker.side)
        while made.get(f'{name}.png', data) != data:
            name, again = f'MarkerData_{marker.name}_{again}', again + 1
        made[f'{name}.png'] = data
    return list(made.items())
