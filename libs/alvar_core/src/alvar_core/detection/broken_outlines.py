"""Find squares whose outline is broken, by a shadow's edge for instance: from the straight parts of all outlines.

An outline that leaves a side of the square where the shadow begins still follows the rest of that side. Two straight
parts that meet at a right turn are a corner, and two corners that face each other are a square.
"""
from __future__ import annotations

from typing import Sequence

import cv2
import numpy as np

from alvar_core.arrays import Floats, Image, Integers
from alvar_core.detection import thresholds


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


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def squares(parts: Floats) -> Floats:
    """Return the quads (N, 4, 2), clockwise, that straight parts (K, 2, 2) form, those with most of their rim first."""
    if len(parts) < 3:
        return np.zeros((0, 4, 2))
    step = parts[:, 1] - parts[:, 0]
    length = np.sqrt((step * step).sum(1))
    longest = _longest_by_direction(step, length)
    start, length = parts[longest, 0], length[longest]
    along = step[longest] / length[:, None]
    start, along, length = _joined(start, along, length)
    first, second, corner = _corners(start, along, length)
    if len(first) < 2:
        return np.zeros((0, 4, 2))
    return _facing(start, along, length, first, second, corner)


def _longest_by_direction(step: Floats, length: Floats) -> Integers:
    """Return the indices of the longest parts of each direction, so that stripes do not displace all others."""
    sector = np.floor(np.arctan2(step[:, 1], step[:, 0]) * (thresholds.DIRECTIONS / (2 * np.pi))).astype(int)
    order = np.lexsort((-length, sector))
    begins = np.searchsorted(sector[order], sector[order])  # the first of the same direction
    chosen: Integers = order[np.arange(len(order)) - begins < thresholds.MAX_PARTS]
    return chosen


def _joined(start: Floats, along: Floats, length: Floats) -> tuple[Floats, Floats, Floats]:
    """Add the parts that follow when parts of one line are joined across gaps."""
    gap = start[None] - start[:, None]
    begin = (gap * along[:, None]).sum(2)
    end = begin + length[None]
    off = np.abs(_cross(along[:, None], gap + 0.5 * (length[:, None] * along)[None]))
    near = np.maximum(begin, 0) - np.minimum(end, length[:, None]) < thresholds.JOINED_GAP * np.maximum(
        length[:, None], length[None])
    one = near & (off < thresholds.JOINED_OFF) & (along @ along.T > thresholds.JOINED_TURN)
    low, high = np.where(one, begin, 0).min(1), np.where(one, end, 0).max(1)
    longer = np.flatnonzero(high - low > length + thresholds.MIN_PART)
    low, high = low[longer], high[longer]
    return (np.concatenate([start, start[longer] + low[:, None] * along[longer]]),
            np.concatenate([along, along[longer]]), np.concatenate([length, high - low]))


def _corners(start: Floats, along: Floats, length: Floats) -> tuple[Integers, Integers, Floats]:
    """Return the parts before and after each corner, and its place."""
    turn = _cross(along[:, None], along[None])
    gap = start[None] - start[:, None]
    with np.errstate(divide='ignore', invalid='ignore'):
        before = _cross(gap, along[None]) / turn  # from the start of the first part to the corner
        after = _cross(gap, along[:, None]) / turn  # from the start of the second part
    reach = thresholds.CORNER_GAP * np.maximum(length[:, None], length[None]) + 2
    spare = thresholds.CORNER_SPARE * length + 3
    good = ((turn > thresholds.MIN_TURN) & (before > (length - spare)[:, None]) & (before < length[:, None] + reach)
            & (after < spare[None]) & (after > -reach))
    first, second = np.nonzero(good)
    missing = np.abs(before[first, second] - length[first]) + np.abs(after[first, second])
    best = np.argsort(missing / (length[first] + length[second]))[:thresholds.MAX_CORNERS]
    first, second = first[best], second[best]
    return first, second, start[first] + before[first, second, None] * along[first]


def _meeting(p: Floats, u: Floats, q: Floats, v: Floats) -> Floats:
    with np.errstate(divide='ignore', invalid='ignore'):
        return p + (_cross(q - p, v) / _cross(u, v))[..., None] * u


def _facing(start: Floats, along: Floats, length: Floats, first: Integers, second: Integers, corner: Floats) -> Floats:
    """Return the quads of corners that face each other."""
    parallel = along @ along.T < -thresholds.MIN_OPPOSITE
    a, b = np.nonzero(np.triu(parallel[first][:, first] & parallel[second][:, second], 1))
    i, j, k, m = first[a], second[a], first[b], second[b]
    ahead = ((corner[b] - corner[a]) * along[j]).sum(1) > 0
    ahead &= ((corner[a] - corner[b]) * along[m]).sum(1) > 0
    a, b, i, j, k, m = (each[ahead] for each in (a, b, i, j, k, m))
    quads = np.stack([_meeting(start[m], along[m], start[i], along[i]), corner[a],
                      _meeting(start[j], along[j], start[k], along[k]), corner[b]], 1)
    sides = np.stack([i, j, k, m], 1)
    side = np.roll(quads, -1, 1) - quads
    width = (side * along[sides]).sum(2)
    from_corner = ((start[sides] - quads) * along[sides]).sum(2)
    beyond = thresholds.CORNER_SPARE * width + 3
    with np.errstate(invalid='ignore'):
        good = ((width > thresholds.MIN_BROKEN_SIDE).all(1) & (width.max(1) < thresholds.MAX_ASPECT * width.min(1))
                & (from_corner > -beyond).all(1) & (from_corner + length[sides] < width + beyond).all(1))
        shown = length[sides].sum(1) / width.sum(1)
        good &= shown > thresholds.MIN_SHOWN
    best = np.flatnonzero(good)
    best = best[np.argsort(-shown[best])][:thresholds.MAX_BROKEN]
    found: Floats = quads[best]
    return found
