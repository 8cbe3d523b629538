"""Find candidates: quadrilaterals in a grey image that could be the black square of a marker.

Quads are (4, 2) real pixel corners, clockwise in the image (for an upright marker: top left, top right, bottom right,
bottom left); which corner comes first is not known yet.
"""
from __future__ import annotations

import ctypes
from typing import Sequence, Tuple

import cv2
import numpy as np

from alvar_core import native
from alvar_core.arrays import Floats, Image, Integers
from alvar_core.detection import homography, thresholds
from alvar_core.detection.broken_outlines import straight_parts
from alvar_core.detection.prepared_image import ImageBuffers
from alvar_core.detection.thresholds import Pass

Point = Tuple[float, float]


def mean_around(smooth: Image, window: int, buffers: ImageBuffers) -> Image:
    """Return the mean of the window (width and height) around each pixel."""
    return cv2.blur(smooth, (window, window), dst=buffers.get('dark', *smooth.shape),
                    borderType=cv2.BORDER_REPLICATE | cv2.BORDER_ISOLATED)


def binary(smooth: Image, window: int, offset: int, buffers: ImageBuffers) -> Image:
    """Return a binary image in which pixels darker than the mean of their surroundings are 255."""
    dark, clean = mean_around(smooth, window, buffers), buffers.get('clean', *smooth.shape)
    # As cv2.adaptiveThreshold with a mean of the window, which looks each difference up in a table.
    darker = cv2.subtract(dark, smooth, dst=clean)
    _, dark = cv2.threshold(darker, offset - 1, 255, cv2.THRESH_BINARY, dst=dark)
    return cv2.medianBlur(dark, 3, dst=clean)


def candidates(smooth: Image, passes: Sequence[Pass] | None = None, buffers: ImageBuffers | None = None,
               parts: list[Floats] | None = None) -> Floats:
    """Return the quads (N, 4, 2), float64, that some passes find in a lightly smoothed grey image.

    The default is all of thresholds.PASSES. ``parts`` gets the straight parts (K, 2, 2) of the outlines of the first of
    PASSES, which is the finest.
    """
    passes = thresholds.PASSES if passes is None else passes
    buffers = buffers or ImageBuffers()
    shrunk: dict[float, Image] = {1: smooth}
    quads = np.concatenate([np.zeros((0, 4, 2))] + [_one_pass(shrunk, buffers, parts, *each)
                                                     for each in passes])
    if native.library:
        return quads
    area = homography.area(quads)
    quads = np.where(area[:, None, None] < 0, quads[:, ::-1], quads)
    side = quads[:, [1, 2, 3, 0]] - quads
    square = (side * side).sum(2)
    large = np.abs(area) >= thresholds.MIN_OUTLINE_SIDE * thresholds.MIN_OUTLINE_SIDE
    found: Floats = quads[large & (square.min(1) * thresholds.MAX_ASPECT ** 2 > square.max(1))]
    return found


def _shrunk(images: dict[float, Image], factor: float, buffers: ImageBuffers) -> Image:
    """Return the image shrunk by a factor; ``images`` {factor: image} has the full one and gets all that are made."""
    if factor not in images:
        full = images[1] if factor <= 2 else _shrunk(images, factor / 2, buffers)  # halving twice is faster
        ratio = min(factor, 2.0)
        width, height = int(full.shape[1] / ratio), int(full.shape[0] / ratio)
        images[factor] = cv2.resize(full, (width, height), dst=buffers.get('shrunk', height, width),
                                    interpolation=cv2.INTER_AREA if ratio >= 2 else cv2.INTER_LINEAR)
    return images[factor]


def _one_pass(images: dict[float, Image], buffers: ImageBuffers, parts: list[Floats] | None, shrink: float, window: int,
              offset: int) -> Floats:
    smooth = _shrunk(images, shrink, buffers)
    parted = parts is not None and shrink == thresholds.PASSES[0].shrink
    if native.library:
        found, straight = _outlines_compiled(smooth, mean_around(smooth, window, buffers), offset, shrink, parted)
        if parts is not None and parted:
            parts.append(straight)
        return found
    dark = binary(smooth, window, offset, buffers)
    outlines, tree = cv2.findContours(dark, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if tree is None:
        return np.zeros((0, 4, 2))
    if parts is not None and parted:
        parts.append(straight_parts(outlines, shrink))
    quads: list[list[Point]] = []
    for i in np.flatnonzero(tree[0, :, 3] < 0).tolist():
        if len(outlines[i]) >= 4 * thresholds.MIN_OUTLINE_SIDE:
            quads += quads_of_outline(outlines[i])
    return (np.array(quads, np.float64).reshape(-1, 4, 2) + 0.5) * shrink - 0.5


def _outlines_compiled(smooth: Image, mean: Image, offset: int, shrink: float,
                       parted: bool) -> tuple[Floats, Floats]:
    """Return the quads (N, 4, 2) of all outlines, and the straight parts (K, 2, 2), by native/outlines.cpp."""
    assert native.library
    limits = np.array([
        thresholds.MIN_OUTLINE_SIDE, thresholds.MIN_FILLED, thresholds.POLYGON_TOLERANCE,
        thresholds.MAX_POLYGON_CORNERS, thresholds.MAX_ASPECT, thresholds.MIN_BROKEN_OUTLINE,
        thresholds.PART_TOLERANCE, thresholds.MIN_PART])
    found, room = np.zeros(2, np.int32), [256, 1024]
    while True:
        quads, straight = np.empty((room[0], 4, 2)), np.empty((room[1], 2, 2))
        native.library.alvar_outlines(
            *native.image(smooth), *native.image(mean), offset, ctypes.c_double(shrink),
            native.address(limits), room[0], native.address(quads), room[1] if parted else -1,
            native.address(straight), native.address(found))
        if (found <= room).all():
            return quads[:found[0]], straight[:found[1]]
        room = found.tolist()


def quads_of_outline(outline: Image) -> list[list[Point]]:
    """Return the quads (lists of four corners) around the convex hull of an outline (N, 1, 2) int32; maybe none."""
    _, _, width, height = cv2.boundingRect(outline)
    smallest = thresholds.MIN_OUTLINE_SIDE
    if min(width, height) < smallest or cv2.contourArea(outline) < thresholds.MIN_FILLED * width * height:
        return []
    stride = len(outline) // 80
    hull = cv2.convexHull(outline if stride < 2 else np.ascontiguousarray(outline[::stride]))
    polygon = cv2.approxPolyDP(hull, max(1.0, thresholds.POLYGON_TOLERANCE * (width + height)), True)
    count = len(polygon)
    if count < 4 or count > thresholds.MAX_POLYGON_CORNERS:
        return []
    corners = polygon[:, 0].tolist()
    quad = four_sides(corners)
    found = [] if quad is None else [quad]
    if 5 <= count <= 6 and min(width, height) > 2 * smallest:
        for i in range(count):
            a, b, c = corners[i - 2], corners[i - 1], corners[i]
            found.append([a, b, c, (a[0] + c[0] - b[0], a[1] + c[1] - b[1])])
    return found


def four_sides(corners: Sequence[Point]) -> list[Point] | None:
    """Remove sides of a convex polygon until four are left; return its corners.

    Each time, remove the side for which extending its neighbours until they meet adds the least area. Return None if
    the neighbours of no side meet.
    """
    p = list(corners)
    while len(p) > 4:
        sides = [(bx - ax, by - ay) for (ax, ay), (bx, by) in zip(p, p[1:] + p[:1])]
        before, after = sides[-1:] + sides[:-1], sides[1:] + sides[:1]
        turns = [ux * vy - uy * vx for (ux, uy), (vx, vy) in zip(before, sides)]
        best = None
        for i, ((ux, uy), (vx, vy), turn, next_turn) in enumerate(zip(before, after, turns, turns[1:] + turns[:1])):
            both = ux * vy - uy * vx
            if both and both * turn >= 0 and both * next_turn >= 0:
                along = next_turn / both  # share of the previous side, up to the point where the neighbours meet
                if best is None or along * abs(turn) < best[0]:
                    best = along * abs(turn), i, along
        if best is None:
            return None
        _, i, along = best
        (x, y), (ux, uy) = p[i], before[i]
        p[i] = x + along * ux, y + along * uy
        p.pop((i + 1) % len(p))
    return p


def side_limits() -> Floats:
    """Return the thresholds that native/candidates.cpp needs."""
    return np.array([thresholds.SIDE_REACH, thresholds.SIDE_NEARNESS, thresholds.MIN_SIDE_RISE,
                     thresholds.SIDE_OUTLIERS])


ALONG = np.array([0.12, 0.31, 0.5, 0.69, 0.88], np.float32)  # positions along a side, as shares of its length
POWERS = np.stack([np.ones_like(ALONG), ALONG - 0.5, (ALONG - 0.5) ** 2], 1)
ACROSS = np.linspace(-1, 1, 13, dtype=np.float32)  # positions across it, as shares of the reach
NEXT = [1, 2, 3, 0]


def refined(smooth: Image, quads: Floats) -> Floats:
    """Move the sides of quads to where the grey rises most from inside to outside; return the quads (K, 4, 2).

    Quads without such a rise nearby are left out. Corners of outlines are rough: blur, noise and things that touch the
    square shift them by up to a cell.
    """
    if not len(quads):
        return quads
    if native.library:
        out = np.array(quads, np.float64, order='C')
        limits = side_limits()
        kept = native.library.alvar_refine_sides(*native.image(smooth), native.address(limits), len(out),
                                                 native.address(out))
        return out[:kept]
    q = quads.astype(np.float32)
    side = q[:, NEXT] - q
    normal = side[..., ::-1] * np.array([1, -1], np.float32) / np.sqrt((side * side).sum(-1, keepdims=True))
    reach = (thresholds.SIDE_REACH * homography.mean_side(q))[:, None]
    x, y = (((q[..., i, None] + ALONG * side[..., i, None])[..., None]
             + ACROSS * (normal[..., i] * reach)[..., None, None]).reshape(4 * len(q), -1) for i in (0, 1))
    read = cv2.remap(smooth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    grey = read.reshape(-1, 4, len(ALONG), len(ACROSS)).astype(np.float32)
    rise = (grey[..., 2:] - grey[..., :-2]) * (1 - thresholds.SIDE_NEARNESS * ACROSS[1:-1] ** 2)
    best = rise.argmax(-1)
    weight = rise.max(-1)
    typical = np.sort(weight, -1)[..., len(ALONG) // 2]
    kept = np.flatnonzero(np.sort(typical, -1)[:, 1] > thresholds.MIN_SIDE_RISE)
    reach, normal = reach[kept], normal[kept]
    middle, slope = _line(ACROSS[1:-1][best[kept]], np.maximum(weight[kept], 0.5))
    middle, slope = (middle * reach)[..., None], (slope * reach)[..., None]
    return _meeting(q[kept] + (middle - 0.5 * slope) * normal, side[kept] + slope * normal).astype(np.float64)


def _line(offset: Floats, weight: Floats) -> tuple[Floats, Floats]:
    """Fit a robust line to offsets (N, 4, 5) over ALONG; return its value in the middle and its slope, each (N, 4)."""
    middle, slope = np.sort(offset, -1)[..., len(ALONG) // 2], np.zeros((1, 1, 1), np.float32)
    for _ in range(2):
        r = thresholds.SIDE_OUTLIERS * (offset - middle[..., None] - slope * POWERS[:, 1])
        w = weight / (1 + r * r) ** 2
        s0, s1, s2 = (w.reshape(-1, len(ALONG)) @ POWERS).T.reshape(3, *middle.shape)
        y0, y1 = ((w * offset).reshape(-1, len(ALONG)) @ POWERS[:, :2]).T.reshape(2, *middle.shape)
        s2 = s2 + np.float32(0.02) * s0
        det = s0 * s2 - s1 * s1
        middle, slope = (y0 * s2 - y1 * s1) / det, ((s0 * y1 - s1 * y0) / det)[..., None]
    return middle, slope[..., 0]


def _meeting(first: Floats, along: Floats) -> Floats:
    """Return the corners (N, 4, 2) where each line (through ``first``, direction ``along``) meets the previous one."""
    p, d = first[:, [3, 0, 1, 2]], along[:, [3, 0, 1, 2]]
    cross = d[..., 0] * along[..., 1] - d[..., 1] * along[..., 0]
    gap = first - p
    s = (gap[..., 0] * along[..., 1] - gap[..., 1] * along[..., 0]) / np.where(np.abs(cross) < 1e-9, 1e-9, cross)
    return p + s[..., None] * d


def distinct(quads: Floats, score: Floats, which: Integers) -> list[int]:
    """Return those of the indices ``which``, best score first, whose corners are not near those of a better quad."""
    chosen: list[int] = which[np.argsort(-score[which])].tolist()
    if len(chosen) < 2:
        return chosen
    sides, centres = homography.mean_side(quads).tolist(), quads.mean(1).tolist()
    kept: list[int] = []
    for i in chosen:
        (x, y), side = centres[i], sides[i]
        for k in kept:
            near = thresholds.SAME_QUAD * min(side, sides[k])
            if abs(x - centres[k][0]) < near and abs(y - centres[k][1]) < near and _apart(quads[i], quads[k]) < near:
                break
        else:
            kept.append(i)
    return kept


def _apart(a: Floats, b: Floats) -> float:
    """Return how far the corners of two quads are apart along an axis, at most, whichever corner comes first."""
    return float(np.abs(a - b[ROTATED]).max((1, 2)).min())


ROTATED = np.array([[0, 1, 2, 3], [1, 2, 3, 0], [2, 3, 0, 1], [3, 0, 1, 2]])  # orders of the corners
