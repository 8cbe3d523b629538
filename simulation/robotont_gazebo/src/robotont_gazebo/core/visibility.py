"""Find the visible faces of upright solids in each column of a level camera's image, nearest first.

The camera has no roll or pitch, so every upright edge is upright in the image. A column corresponds to one line in the
floor plan, which is inside each solid from one depth to another; the rows of the solid follow from these two depths.
Order and occlusion are therefore exact in each column, even for overlapping solids. Depths are along the optical axis,
in metres; rows and columns are in px, with whole numbers at their centres.
"""
import math
from typing import Any, Iterator, List, NamedTuple, Tuple

import numpy as np

from kinematic_core.worlds.floor_plan import Box, FloorPlan, Solid
from robotont_gazebo.core.camera import NEAR, CameraPose, PinholeCamera

Numbers = Any  # a float, or an array (N, 1)

FRONT, TOP, UNDER = range(3)  # kinds of pieces: an upright face, the upper and the lower end of a solid
LEFT_OF_X, RIGHT_OF_X, LEFT_OF_Y, RIGHT_OF_Y, ROUND = range(5)  # faces: the box's own -x, +x, -y, +y sides; a cylinder
TIE = 1e-7  # [m] by which a higher solid counts as nearer than a lower one whose face is in the same plane
SEAM = 1.0  # [px] by which an end overlaps the upright face below or above it, so that there is no gap


class Layer(NamedTuple):
    """The content of one layer in each column, arrays (width,); ``solid`` is -1 where it is empty.

    ``solid``: index; ``kind``: FRONT, TOP, UNDER; ``face``: LEFT_OF_X ... ROUND; ``upper``, ``lower``: the rows between
    which it is visible, apart from nearer layers; ``depth``: that of the upright face; ``incidence``: that of the ray
    on the face, |cosine| / z.
    """

    solid: np.ndarray
    kind: np.ndarray
    face: np.ndarray
    upper: np.ndarray
    lower: np.ndarray
    depth: np.ndarray
    incidence: np.ndarray


class VisibleLayers(NamedTuple):
    """All that is visible: the Layers, nearest first, and the floor.

    ``floor_from`` (width,): the row [px] above which a column shows no floor.
    """

    layers: List[Layer]
    floor_from: np.ndarray


class Solids:
    """The solids of a FloorPlan as arrays (N,), in the order of plan.solids(); ``box``: which are boxes.

    x, y, half_x, half_y, radius, bottom, top [m], cos, sin (of yaw); 0 where a shape has no such number.
    """

    def __init__(self, plan: FloorPlan) -> None:
        self.shapes = plan.solids()
        self.count = len(self.shapes)
        self.panel_of = {self.count - len(plan.panels) + index: panel for index, panel in enumerate(plan.panels)}
        rows = [_numbers(shape) for shape in self.shapes]
        columns = np.array(rows, float).reshape(-1, 10).T
        (self.box, self.x, self.y, self.cos, self.sin, self.half_x, self.half_y, self.radius, self.bottom,
         self.top) = columns
        self.box = self.box > 0.0
        self.reach = np.where(self.box, np.hypot(self.half_x, self.half_y), self.radius)
        height_order = np.lexsort((np.arange(self.count), self.top))
        self.rank = np.empty(self.count)
        self.rank[height_order] = np.arange(self.count)
        for index in self.panel_of:
            self.rank[index] += self.count


def _numbers(shape: Solid) -> Tuple[float, ...]:
    top = shape.bottom + shape.height
    if isinstance(shape, Box):
        return (1, shape.x, shape.y, math.cos(shape.yaw), math.sin(shape.yaw), shape.length / 2, shape.width / 2, 0.0,
                shape.bottom, top)
    return 0, shape.x, shape.y, 1.0, 0.0, 0.0, 0.0, shape.radius, shape.bottom, top


class CameraInFrame(NamedTuple):
    """A camera seen from a frame in the floor plan: position (x, y) [m], unit vectors forward and to the right.

    Numbers for one frame, arrays (N, 1) for N of them.
    """

    x: Numbers
    y: Numbers
    forward_x: Numbers
    forward_y: Numbers
    right_x: Numbers
    right_y: Numbers


def in_frame_at(x: Numbers, y: Numbers, cos: Numbers, sin: Numbers, pose: CameraPose) -> CameraInFrame:
    """Return the camera in the frame, or the frames, at (x, y) [m] turned by the angle with this cos and sin."""
    dx, dy = pose.x - x, pose.y - y
    forward, side = math.cos(pose.yaw), math.sin(pose.yaw)
    forward_x, forward_y = cos * forward + sin * side, cos * side - sin * forward
    return CameraInFrame(cos * dx + sin * dy, cos * dy - sin * dx, forward_x, forward_y, forward_y, -forward_x)


def _in_frames_of(solids: Solids, index: np.ndarray, pose: CameraPose) -> CameraInFrame:
    """Return the camera in the frames of the solids with these indices, arrays (N, 1)."""
    camera = in_frame_at(solids.x[index], solids.y[index], solids.cos[index], solids.sin[index], pose)
    return CameraInFrame(*(part[:, None] for part in camera))


def _in_view(solids: Solids, camera: PinholeCamera, pose: CameraPose) -> np.ndarray:
    """Return the indices of the solids that may be in the image, according to the circles around them."""
    dx, dy = solids.x - pose.x, solids.y - pose.y
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    ahead, right = cos * dx + sin * dy, sin * dx - cos * dy
    first, last = camera.right[0], camera.right[-1]
    return np.flatnonzero((ahead + solids.reach > NEAR)
                          & (right - first * ahead > -solids.reach * math.hypot(1.0, first))
                          & (last * ahead - right > -solids.reach * math.hypot(1.0, last)))


class _Crossings(NamedTuple):
    """Where rays enter and leave solids, (N, width): depths [m], face of entry, incidence; enter >= leave: no hit."""

    enter: np.ndarray
    leave: np.ndarray
    face: np.ndarray
    incidence: np.ndarray


def _cross_boxes(solids: Solids, index: np.ndarray, camera: PinholeCamera, pose: CameraPose) -> _Crossings:
    ox, oy, fx, fy, rx, ry = _in_frames_of(solids, index, pose)
    dx, dy = _no_zero(fx + rx * camera.right), _no_zero(fy + ry * camera.right)
    half_x, half_y = solids.half_x[index, None], solids.half_y[index, None]
    middle_x, reach_x = -ox / dx, half_x / np.abs(dx)
    middle_y, reach_y = -oy / dy, half_y / np.abs(dy)
    enter_x, enter_y = middle_x - reach_x, middle_y - reach_y
    by_x = enter_x > enter_y
    across = np.where(by_x, dx, dy)
    face = np.where(by_x, LEFT_OF_X, LEFT_OF_Y) + (across < 0)  # each RIGHT follows its LEFT
    return _Crossings(np.maximum(enter_x, enter_y), np.minimum(middle_x + reach_x, middle_y + reach_y), face,
                      np.abs(across))


def _cross_cylinders(solids: Solids, index: np.ndarray, camera: PinholeCamera, pose: CameraPose) -> _Crossings:
    ox, oy, fx, fy, rx, ry = _in_frames_of(solids, index, pose)
    dx, dy = fx + rx * camera.right, fy + ry * camera.right
    square = dx * dx + dy * dy
    middle = -(ox * dx + oy * dy) / square
    miss = (ox * dy - oy * dx) ** 2 / square
    with np.errstate(invalid='ignore'):
        reach = np.sqrt((solids.radius[index, None] ** 2 - miss) / square)
    reach = np.where(np.isnan(reach), -1.0, reach)
    return _Crossings(middle - reach, middle + reach, np.full(middle.shape, ROUND), np.ones(middle.shape))


def _no_zero(direction: np.ndarray) -> np.ndarray:
    return np.where(np.abs(direction) < 1e-12, 1e-12, direction)


def _cross(solids: Solids, camera: PinholeCamera, pose: CameraPose) -> Tuple[np.ndarray, _Crossings]:
    """Return the indices of the solids that rays meet, boxes first, and their _Crossings."""
    index = _in_view(solids, camera, pose)
    boxes, cylinders = index[solids.box[index]], index[~solids.box[index]]
    crossings = _cross_boxes(solids, boxes, camera, pose)
    if len(cylinders):
        crossings = _Crossings(*map(np.concatenate, zip(crossings, _cross_cylinders(solids, cylinders, camera, pose))))
    met = np.flatnonzero(((crossings.enter < crossings.leave) & (crossings.leave > NEAR)).any(1))
    return np.concatenate([boxes, cylinders])[met], _Crossings(*(part[met] for part in crossings))


def visible_from(solids: Solids, camera: PinholeCamera, pose: CameraPose) -> VisibleLayers:
    """Return the VisibleLayers of the solids for a camera at ``pose``."""
    index, crossings = _cross(solids, camera, pose)
    pieces = _pieces(solids, camera, pose, index, crossings)
    return _layers(camera, pieces)


class _Pieces(NamedTuple):
    """Candidates (P, width) for visible pieces, in any order; ``closed`` (P, 1): below it, only the floor is visible.

    ``key`` [m] orders them from near to far; inf: the piece does not exist.
    """

    solid: np.ndarray
    kind: np.ndarray
    face: np.ndarray
    upper: np.ndarray
    lower: np.ndarray
    depth: np.ndarray
    incidence: np.ndarray
    key: np.ndarray
    closed: np.ndarray


class _Part(NamedTuple):
    """Pieces of one kind: positions (N,) in the index of solids, and arrays (N, width)."""

    source: np.ndarray
    kind: int
    upper: np.ndarray
    lower: np.ndarray
    key: np.ndarray


def _pieces(solids: Solids, camera: PinholeCamera, pose: CameraPose, index: np.ndarray,
            crossings: _Crossings) -> _Pieces:
    enter, near = crossings.enter, np.maximum(crossings.enter, NEAR)
    hit = (enter < crossings.leave) & (crossings.leave > NEAR)
    key = np.where(hit, near, np.inf) - TIE * solids.rank[index, None]
    over_top, over_bottom = ((pose.z - z[index, None]) * camera.focal for z in (solids.top, solids.bottom))
    upper, lower = camera.cy + over_top / near, camera.cy + over_bottom / near
    parts = [_Part(np.arange(len(index)), FRONT, upper, lower, np.where(enter > NEAR, key, np.inf))]
    for k in np.flatnonzero(solids.top[index] < pose.z).tolist():
        higher = np.flatnonzero(solids.top[index] > solids.top[index[k]])
        for start, end, end_key in _stretches(k, higher, near, crossings.leave, hit, key):
            far_row, near_row = camera.cy + over_top[k] / end, camera.cy + over_top[k] / start
            seam = np.minimum(near_row + SEAM, np.maximum(near_row, lower[k]))
            parts.append(_Part(np.array([k]), TOP, far_row[None], seam[None], end_key[None]))
    for k in np.flatnonzero(solids.bottom[index] > pose.z).tolist():
        lower_ones = np.flatnonzero(solids.bottom[index] < solids.bottom[index[k]])
        for start, end, end_key in _stretches(k, lower_ones, near, crossings.leave, hit, key):
            near_row, far_row = camera.cy + over_bottom[k] / start, camera.cy + over_bottom[k] / end
            seam = np.maximum(near_row - SEAM, np.minimum(near_row, upper[k]))
            parts.append(_Part(np.array([k]), UNDER, seam[None], far_row[None], end_key[None]))
    source = np.concatenate([part.source for part in parts])
    return _Pieces(index[source], np.repeat([part.kind for part in parts], [len(part.source) for part in parts]),
                   crossings.face[source], np.concatenate([part.upper for part in parts]),
                   np.concatenate([part.lower for part in parts]), near[source], crossings.incidence[source],
                   np.concatenate([part.key for part in parts]), solids.bottom[index][source] <= 0.0)


def _stretches(k: int, others: np.ndarray, near: np.ndarray, leave: np.ndarray, hit: np.ndarray,
               key: np.ndarray) -> Iterator[Tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Yield (start, end, key), each (width,), of the intervals [m] of the upper or lower end of solid k.

    Where one of ``others`` starts above (or below) the end, the part behind it is a separate interval, which is drawn
    before that other solid.
    """
    start, start_key = near[k], key[k] + 0.5 * TIE
    while np.isfinite(start_key).any():
        end, next_key = np.maximum(leave[k], start), np.full(len(start), np.inf)
        if len(others):
            starts = np.where(hit[others] & (near[others] > start) & (near[others] < end), near[others], np.inf)
            first = starts.argmin(0), np.arange(len(start))
            inside = np.isfinite(starts[first])
            end = np.where(inside, starts[first], end)
            next_key = np.where(inside, key[others][first] + 0.75 * TIE, next_key)
        yield start, end, start_key
        start, start_key = end, next_key


def _layers(camera: PinholeCamera, pieces: _Pieces) -> VisibleLayers:
    order = np.argsort(pieces.key, axis=0)
    position = order * camera.width + np.arange(camera.width)
    key, upper, lower = (part.take(position) for part in (pieces.key, pieces.upper, pieces.lower))
    closed = np.isfinite(key) & pieces.closed[order]
    clipped = np.maximum(upper, -0.5)
    covered = np.full((len(order) + 1, camera.width), np.inf)
    np.minimum.accumulate(np.where(closed, clipped, np.inf), axis=0, out=covered[1:])
    seen = np.isfinite(key) & (clipped < np.minimum(covered[:-1], camera.height - 0.5)) & (clipped < lower)
    floor_from = np.where(closed & (upper <= camera.cy), lower, camera.cy).max(0, initial=camera.cy)
    layer = np.cumsum(seen, axis=0) - 1
    target = (layer * camera.width + np.arange(camera.width))[seen]
    source, piece = position[seen], order[seen]
    shape = int(layer.max(initial=-1)) + 1, camera.width

    def laid(values: np.ndarray, empty: float) -> np.ndarray:
        """Return the values (seen pieces,) in their layers and columns, (layers, width), ``empty`` elsewhere."""
        out = np.full(shape, empty, values.dtype)
        out.put(target, values)
        return out
    columns = (laid(pieces.solid[piece], -1), laid(pieces.kind[piece], FRONT), laid(pieces.face.take(source), ROUND),
               laid(pieces.upper.take(source), 0.0), laid(pieces.lower.take(source), 0.0),
               laid(pieces.depth.take(source), 1.0), laid(pieces.incidence.take(source), 1.0))
    return VisibleLayers([Layer(*rows) for rows in zip(*columns)], floor_from)
