"""Bundles: markers fixed to each other, and the XML files that describe them.

<multimarker markers="2">
    <marker index="8" status="1">
        <corner x="-2.2" y="-2.2" z="0" /> ... four: bottom left, bottom right, top right, top left as drawn
    </marker> ...

Lengths in the files are in centimetres, here in metres. The first marker is the master: its id is the id of the bundle.
The corners are given in the bundle's frame (usually that of the master: origin in its centre, x right, y up, z out of
it). A marker with status 0 belongs to the bundle, but its position is unknown: ALVAR's training writes this for a
marker that it never saw.

The format is that of ALVAR 2.0's MultiMarker, as read by ar_track_alvar.
"""
from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Iterable, Mapping, NoReturn
from xml.etree.ElementTree import Element

import numpy as np

from alvar_core import code
from alvar_core.arrays import ArrayLike, Floats
from plain_support import LARGEST_MARKER_ID, documents, shown

METRES = 0.01  # [m] per unit of the files
FROM_FILE = [3, 2, 1, 0]  # converts the order of corners in a file to top left, clockwise, and back
UNEVEN = 0.05  # share of the side by which a marker may differ from a square
LOST_CORNER = 0.02  # share of the side: some versions of createMarker write the first corner this near to the centre
MAX_LENGTH = 1e6  # [cm]


class BundleError(ValueError):
    """A bundle file cannot be used; the text names the file, the element, and what is allowed."""


@dataclass(frozen=True)
class Bundle:
    """A rigid set of markers.

    ``source`` is the file, ``master`` the id of the first marker, ``ids`` those of all markers. ``corners``
    {id: (4, 3)} [m], in the bundle's frame: top left, top right, bottom right, bottom left of each marker whose
    position is known. ``notes`` are texts about peculiarities of the file.
    """

    source: str
    master: int
    ids: tuple[int, ...]
    corners: Mapping[code.Value, Floats]
    notes: tuple[str, ...] = ()

    @property
    def sizes(self) -> dict[code.Value, float]:
        """Return {id: side [m]} of the markers whose position is known."""
        return {number: float(np.mean(sides(corners))) for number, corners in self.corners.items()}


def sides(corners: Floats) -> Floats:
    """Return the lengths (4,) of the sides between corners (4, 3)."""
    lengths: Floats = np.linalg.norm(np.roll(corners, -1, 0) - corners, axis=1)
    return lengths


def marker_pose(corners: Floats) -> tuple[Floats, Floats]:
    """Return rotation (3, 3) and position (3,) of a marker (x right, y up, z out of it) with corners (4, 3)."""
    top_left, top_right, bottom_right, bottom_left = corners
    x = top_right + bottom_right - top_left - bottom_left
    x = x / np.linalg.norm(x)
    z = np.cross(x, top_left + top_right - bottom_left - bottom_right)
    z = z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z], 1), corners.mean(0)


def read(path: str | os.PathLike[str]) -> Bundle:
    """Return the Bundle in an XML file; raise BundleError."""
    try:
        root = documents.read_xml(path)
    except OSError as error:
        raise BundleError(f'bundle file {path} cannot be read: {error.strerror}') from None
    except documents.DocumentError as error:
        raise BundleError(f'bundle file {path}: {error}') from None
    return _Reader(path).bundle(root)


class _Reader:
    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = str(path)
        self.notes: list[str] = []

    def fail(self, where: str, what: str) -> NoReturn:
        raise BundleError(f'bundle file {self.path}, {where}: {what}')

    def bundle(self, root: Element) -> Bundle:
        if root.tag != 'multimarker':
            self.fail(f'<{root.tag:.80}>', 'the outermost element must be <multimarker markers="NUMBER OF MARKERS">')
        count = self.whole(root, 'markers', '<multimarker>', 1)
        markers = root.findall('marker')
        if len(markers) < count:
            self.fail('<multimarker>', f'markers="{shown(count)}", but there are {len(markers)} <marker> elements')
        if len(markers) > count:
            self.notes.append(f'{len(markers)} <marker> elements, but markers="{count}": those after the first {count} '
                              'are ignored, as in the original')
        corners: dict[code.Value, Floats] = {}
        ids: list[int] = []
        for number, marker in enumerate(markers[:count], 1):
            index, place = self.marker(marker, number)
            if index in ids:
                self.fail(f'marker {number}', f'index="{index}" appears twice; each marker needs its own id')
            ids.append(index)
            if place is not None:
                corners[index] = place
        if not corners:
            self.fail('<multimarker>', 'every marker has status="0" (position unknown); one with status="1" is needed')
        return Bundle(self.path, ids[0], tuple(ids), corners, tuple(self.notes))

    def marker(self, marker: Element, number: int) -> tuple[int, Floats | None]:
        where = f'marker {number}'
        index = self.whole(marker, 'index', where, 0, LARGEST_MARKER_ID)
        where += f' (index {index})'
        if self.whole(marker, 'status', where, 0) == 0:
            return index, None
        corners = marker.findall('corner')
        if len(corners) != 4:
            self.fail(where, f'{len(corners)} <corner> elements; four are needed: bottom left, bottom right, top '
                             'right, top left')
        place = np.array([[self.number(corner, axis, f'{where}, corner {k}') for axis in ('x', 'y', 'z')]
                          for k, corner in enumerate(corners, 1)])
        return index, self.square(place, where)[FROM_FILE] * METRES

    def square(self, place: Floats, where: str) -> Floats:
        """Check corners (4, 3) in the file's order and return them; restore a first one that createMarker has lost."""
        side = np.linalg.norm(place[2] - place[1])
        if side > 0 and np.linalg.norm(place[0] - (place[1] + place[3]) / 2) < LOST_CORNER * side:
            place = np.concatenate([[place[1] + place[3] - place[2]], place[1:]])
            self.notes.append(f'{where}: the first corner lies at the centre, as a faulty createMarker writes it; '
                              'it was computed from the other three')
        lengths = sides(place)
        diagonals = np.linalg.norm(place[:2] - place[2:], axis=1)
        if lengths.min() < 1e-3 * max(float(lengths.max()), 1e-9) or diagonals.min() < 0.1 * diagonals.max():
            self.fail(where, 'the corners are not a square: two of them coincide')
        expected = np.append(lengths, diagonals / math.sqrt(2))
        if np.ptp(expected) > UNEVEN * expected.mean():
            self.notes.append(f'{where}: the corners are not a square; the sides are '
                              + ', '.join(f'{length:.4g}' for length in lengths) + ' cm, its diagonals '
                              + ', '.join(f'{length:.4g}' for length in diagonals) + ' cm')
        return place

    def whole(self, element: Element, name: str, where: str, low: int, high: int | None = None) -> int:
        text = element.get(name)
        try:
            value = None if text is None else int(text)
        except ValueError:
            value = None
        if value is None or value < low or high is not None and value > high:
            allowed = 'a whole number ' + (f'from {low} to {high}' if high is not None else f'of at least {low}')
            self.fail(where, f'{name} is missing; {allowed} is needed' if text is None else
                      f'{name}="{text:.80}": {allowed} is needed')
        return value

    def number(self, element: Element, name: str, where: str) -> float:
        text = element.get(name)
        try:
            value = math.nan if text is None else float(text)
        except ValueError:
            value = math.nan
        if not abs(value) <= MAX_LENGTH:
            self.fail(where, f'{name} is missing; a number of centimetres is needed' if text is None else
                      f'{name}="{text:.80}": a number of centimetres from -{MAX_LENGTH:g} to {MAX_LENGTH:g} is needed')
        return value


def xml(corners: Mapping[code.Value, ArrayLike], unknown: Iterable[code.Value] = ()) -> str:
    """Return the text of a bundle file from ``corners`` {id: (4, 3)} [m], in the order of Bundle.corners.

    The markers ``unknown`` follow with status 0, as the original's training writes those that it has not placed.
    """
    markers = [(index, 1, np.asarray(place, float)[FROM_FILE]) for index, place in corners.items()]
    markers += [(index, 0, np.zeros((4, 3))) for index in unknown]
    lines = ['<?xml version="1.0" encoding="UTF-8" standalone="no" ?>', f'<multimarker markers="{len(markers)}">']
    for index, status, place in markers:
        points = np.round(place / METRES, 6) + 0.0  # no -0
        lines += [f'    <marker index="{index}" status="{status}">',
                  *(f'        <corner x="{x:.10g}" y="{y:.10g}" z="{z:.10g}" />' for x, y, z in points),
                  '    </marker>']
    return '\n'.join(lines + ['</multimarker>', ''])
