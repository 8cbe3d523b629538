"""Find squares whose outline is broken, by a shadow's edge for instance: from the straight parts of all outlines.

An outline that leaves a side of the square where the shadow begins still follows the rest of that side. Two straight
parts that meet at a right turn are a corner, and two corners that face each other are a square.
"""
from __future__ import annotations

import ctypes
from typing import Sequence

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Complexes, Floats, Image, Integers
from alvar_core.detection import thresholds

PART_PLACES = np.array([0.2, 0.5, 0.8])  # along a part, where it is read


def straight_parts(outlines: Sequence[Image], shrink: float) -> Floats:
    """Return the straight parts (N, 2, 2) [px of the full image] of outlines, the dark side on their right."""
    polygons = [cv2.approxPolyDP(outline, thresholds.PART_TOLERANCE, True) for outline in outlines
                if len(outline) >= thresholds.MIN_BROKEN_OUTLINE]
    if not polygons:
        return np.zeros((0, 2, 2))
    points = np.concatenate(polygons)[:, 0].astype(np.float64)
    ends = np.cumsum([len(polygon) for polygon in polygons])
    after = np.arange(1, len(points) + 1)
    after[ends - 1] = np.concatenate([[0], ends[:-1]])
    step = points[after] - points
    long = np.flatnonzero((step * step).sum(1) >= thresholds.MIN_PART ** 2)
    return (np.stack([points[after[long]], points[long]], 1) + 0.5) * shrink - 0.5


def distinct_parts(smooth: Image, parts: Floats) -> Floats:
    """Return those straight parts (N, 2, 2) that are dark on their right, compared with their left."""
    if native.library:
        found = np.array(parts, np.float64, order='C')
        return found[:native.library.alvar_distinct_parts(
            *native.image(smooth), len(found), native.address(found), ctypes.c_double(thresholds.PART_SIDE),
            ctypes.c_double(thresholds.DARK_GREY), ctypes.c_double(thresholds.MIN_LOCAL_CONTRAST))]
    step = parts[:, 1] - parts[:, 0]
    left = np.stack([step[:, 1], -step[:, 0]], 1) * (thresholds.PART_SIDE / np.hypot(*step.T))[:, None]
    along = parts[:, None, 0] + PART_PLACES[:, None] * step[:, None]
    places = np.concatenate([along - left[:, None], along + left[:, None]], 1).astype(np.float32)
    grey = cv2.remap(smooth, places[..., 0], places[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    black, white = grey.astype(np.float32).reshape(len(parts), 2, -1).transpose(1, 0, 2)
    contrast = np.median((white - black) / (white + black + thresholds.DARK_GREY), 1)
    return parts[contrast > thresholds.MIN_LOCAL_CONTRAST]


def squares(parts: Floats) -> Floats:
    """Return the quads (N, 4, 2), clockwise, that straight parts (K, 2, 2) form, those with most of their rim first."""
    if len(parts) < 3:
        return np.zeros((0, 4, 2))
    if native.library:
        return _squares_compiled(native.library, parts)
    step = parts[:, 1] - parts[:, 0]
    length = np.sqrt((step * step).sum(1))
    longest = _longest_by_direction(step, length)
    start, length = _complex(parts[longest, 0]), length[longest]
    along = _complex(step[longest]) / length
    start, along, length = _joined(start, along, length)
    first, second, corner = _corners(start, along, length)
    if len(first) < 2:
        return np.zeros((0, 4, 2))
    return _facing(start, along, length, first, second, corner)


def _squares_compiled(library: ctypes.CDLL, parts: Floats) -> Floats:
    """Do the same as ``squares`` with the compiled step of native/squares.cpp."""
    limits = np.array([
        thresholds.DIRECTIONS, thresholds.MAX_PARTS, thresholds.JOINED_TURN, thresholds.JOINED_GAP,
        thresholds.JOINED_OFF, thresholds.MIN_PART, thresholds.CORNER_GAP, thresholds.CORNER_SPARE,
        thresholds.MIN_TURN, thresholds.MIN_OPPOSITE, thresholds.MAX_CORNERS, thresholds.MAX_BROKEN,
        thresholds.MIN_BROKEN_SIDE, thresholds.MAX_ASPECT, thresholds.MIN_SHOWN])
    parts, quads = np.ascontiguousarray(parts, np.float64), np.empty((thresholds.MAX_BROKEN, 4, 2))
    return quads[:library.alvar_squares(len(parts), native.address(parts), native.address(limits),
                                        native.address(quads))]


# Below, points and directions are complex numbers x + i y: then few operations are needed on large arrays.

def _complex(points: Floats) -> Complexes:
    """Return points (N, 2) as (N,) complex numbers."""
    numbers: Complexes = points[:, 0] + 1j * points[:, 1]
    return numbers


def _dot(a: Complexes, b: Complexes) -> Floats:
    return a.real * b.real + a.imag * b.imag


def _cross(a: Complexes, b: Complexes) -> Floats:
    return a.real * b.imag - a.imag * b.real


def _dots(a: Complexes, b: Complexes) -> Floats:
    """Return the dot product of each of ``a`` (N,) with each of ``b`` (K,)."""
    product: Floats = np.stack([a.real, a.imag], 1) @ np.stack([b.real, b.imag])
    return product


def _longest_by_direction(step: Floats, length: Floats) -> Integers:
    """Return the indices of the longest parts of each direction, so that stripes do not displace all others."""
    sector = np.floor(np.arctan2(step[:, 1], step[:, 0]) * (thresholds.DIRECTIONS / (2 * np.pi))).astype(int)
    order = np.lexsort((-length, sector))
    begins = np.searchsorted(sector[order], sector[order])  # the first of the same direction
    chosen: Integers = order[np.arange(len(order)) - begins < thresholds.MAX_PARTS]
    return chosen


def _joined(start: Complexes, along: Complexes, length: Floats) -> tuple[Complexes, Complexes, Floats]:
    """Add the parts that follow when parts of one line are joined across gaps."""
    i, j = np.nonzero(_dots(along, along) > thresholds.JOINED_TURN)  # each with itself, too
    turned = (start[j] - start[i]) * along[i].conj()  # from the start of i: along it, and to its side
    begin, end = turned.real, turned.real + length[j]
    off = np.abs((turned + 0.5 * length[j] * along[j] * along[i].conj()).imag)
    near = np.maximum(begin, 0) - np.minimum(end, length[i]) < thresholds.JOINED_GAP * np.maximum(length[i], length[j])
    one = near & (off < thresholds.JOINED_OFF)
    rows = np.searchsorted(i, np.arange(len(start)))
    low, high = np.minimum.reduceat(np.where(one, begin, 0), rows), np.maximum.reduceat(np.where(one, end, 0), rows)
    longer = np.flatnonzero(high - low > length + thresholds.MIN_PART)
    low, high = low[longer], high[longer]
    return (np.concatenate([start, start[longer] + low * along[longer]]), np.concatenate([along, along[longer]]),
            np.concatenate([length, high - low]))


def _corners(start: Complexes, along: Complexes, length: Floats) -> tuple[Integers, Integers, Complexes]:
    """Return the parts before and after each corner, and its place."""
    turn = _dots(1j * along, along)
    reach = thresholds.CORNER_GAP * np.maximum(length[:, None], length) + 2
    before = _cross(start, along) - _dots(1j * start, along) - turn * length[:, None]  # times turn, as below
    first, second = np.nonzero((turn > thresholds.MIN_TURN) & (np.abs(before) < reach * turn))
    turn, reach, before = turn[first, second], reach[first, second], before[first, second]
    before /= turn  # from the end of the first part to the corner
    after = _cross(start[second] - start[first], along[first]) / turn  # from the start of the second part
    spare = thresholds.CORNER_SPARE * length + 3
    good = np.flatnonzero((before > -spare[first]) & (after < spare[second]) & (after > -reach))
    missing = np.abs(before[good]) + np.abs(after[good])
    best = good[np.argsort(missing / (length[first[good]] + length[second[good]]))[:thresholds.MAX_CORNERS]]
    first, second = first[best], second[best]
    return first, second, start[first] + (before[best] + length[first]) * along[first]


def _facing(start: Complexes, along: Complexes, length: Floats, first: Integers, second: Integers,
            corner: Complexes) -> Floats:
    """Return the quads of corners that face each other."""
    before, after = along[first], along[second]
    facing = (_dots(before, before) < -thresholds.MIN_OPPOSITE) & (_dots(after, after) < -thresholds.MIN_OPPOSITE)
    facing &= _dots(corner, after) > _dot(corner, after)  # each lies ahead of the other
    a, b = np.nonzero(facing & facing.T)
    once = a < b
    a, b = a[once], b[once]
    sides = np.stack([first[a], second[a], first[b], second[b]])
    at, way, lengths = start[sides], along[sides], length[sides]
    # the last side meets the first one, the second meets the third: their directions differ by a turn at a corner
    p, u, q, v = at[[3, 1]], way[[3, 1]], at[[0, 2]], way[[0, 2]]
    turn = _cross(u, v)
    meeting = p + _cross(q - p, v) / np.where(turn == 0, 1e-12, turn) * u
    quads = np.stack([meeting[0], corner[a], meeting[1], corner[b]])
    width = _dot(quads[[1, 2, 3, 0]] - quads, way)
    from_corner = _dot(at - quads, way)
    beyond = thresholds.CORNER_SPARE * width + 3
    shown = lengths.sum(0) / np.maximum(width.sum(0), 1e-12)
    least = width.min(0)
    good = ((least > thresholds.MIN_BROKEN_SIDE) & (width.max(0) < thresholds.MAX_ASPECT * least)
            & ((from_corner > -beyond) & (from_corner + lengths < width + beyond)).all(0)
            & (shown > thresholds.MIN_SHOWN))
    best = np.flatnonzero(good)
    best = best[np.argsort(-shown[best])][:thresholds.MAX_BROKEN]
    found = quads[:, best].T
    return np.stack([found.real, found.imag], 2)
