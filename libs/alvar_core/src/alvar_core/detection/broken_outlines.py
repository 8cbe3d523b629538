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
    step = parts[:, 1] - parts[:, 0]
    left = np.stack([step[:, 1], -step[:, 0]], 1) * (thresholds.PART_SIDE / np.hypot(*step.T))[:, None]
    along = parts[:, None, 0] + PART_PLACES[:, None] * step[:, None]
    places = np.concatenate([along - left[:, None], along + left[:, None]], 1).astype(np.float32)
    grey = cv2.remap(smooth, places[..., 0], places[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    black, white = grey.astype(np.float32).reshape(len(parts), 2, -1).transpose(1, 0, 2)
    contrast = np.median((white - black) / (white + black + thresholds.DARK_GREY), 1)
    found: Floats = parts[contrast > thresholds.MIN_LOCAL_CONTRAST]
    return found


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _crossed(a: Floats, b: Floats) -> Floats:
    """Return the cross product of each of ``a`` (N, 2) with each of ``b`` (K, 2)."""
    product: Floats = np.stack([-a[:, 1], a[:, 0]], 1) @ b.T
    return product


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
    begin = along @ start.T
    begin -= begin.diagonal()[:, None].copy()
    end = begin + length
    off = _crossed(along, start + 0.5 * length[:, None] * along)
    off = np.abs(off - _cross(along, start)[:, None])
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
    turn, at = _crossed(along, along), _cross(start, along)
    with np.errstate(divide='ignore', invalid='ignore'):
        before = (at - _crossed(start, along)) / turn  # from the start of the first part to the corner
        after = -(at[:, None] + _crossed(along, start)) / turn  # from the start of the second part
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
    before, after = along[first], along[second]
    facing = (before @ before.T < -thresholds.MIN_OPPOSITE) & (after @ after.T < -thresholds.MIN_OPPOSITE)
    facing &= corner @ after.T > (corner * after).sum(1)  # each lies ahead of the other
    a, b = np.nonzero(np.triu(facing & facing.T, 1))
    i, j, k, m = first[a], second[a], first[b], second[b]
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
