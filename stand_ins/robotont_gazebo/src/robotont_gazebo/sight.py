"""What each column of a level camera's picture meets: faces of upright solids, nearest first, hidden ones left out.

The camera has no roll or pitch, so every upright edge stays upright in the picture: a column looks along one line of
the floor plan, meets each solid there from one depth to another, and what it sees of the solid lies between rows that
follow from these two depths. Order and occlusion are therefore exact in each column, also for solids that reach into
each other. Depths are along the optical axis, in metres; rows and columns in px, whole numbers at their middles.
"""
import math
from typing import NamedTuple

import numpy as np

from kinematic_core.floor_plan import Box
from robotont_gazebo.camera import NEAR

FRONT, TOP, UNDER = range(3)  # kinds of pieces: an upright face, the upper and the lower end of a solid
LEFT_OF_X, RIGHT_OF_X, LEFT_OF_Y, RIGHT_OF_Y, ROUND = range(5)  # faces: the box's own -x, +x, -y, +y sides; a cylinder
TIE = 1e-7  # [m] by which a higher solid counts as nearer than a lower one with the same face
SEAM = 1.0  # [px] that an end reaches behind the upright face below or above it, so that nothing shines through


class Sight(NamedTuple):
    """All that is seen: arrays (layers, width), layer 0 the nearest. Where a layer has nothing, solid is -1.

    solid: index; kind: FRONT, TOP, UNDER; face: LEFT_OF_X ... ROUND; upper, lower: rows between which it is seen, not
    yet cut off by nearer layers; depth: of the upright face; incidence: of the ray and the face, |cosine| / z;
    floor_from (width,), of all layers: the row [px] above which a column shows no floor.
    """

    solid: np.ndarray
    kind: np.ndarray
    face: np.ndarray
    upper: np.ndarray
    lower: np.ndarray
    depth: np.ndarray
    incidence: np.ndarray
    floor_from: np.ndarray

    def layers(self):
        """Return one Sight for each layer, the nearest first, with arrays (width,)."""
        return [Sight(*layer, self.floor_from) for layer in zip(*self[:-1])]


class Solids:
    """The solids of a FloorPlan as arrays: those of plan.solids(), in that order; box says which are no cylinders.

    x, y, cos, sin, half_x, half_y, radius, bottom, top: (N,), those that a shape lacks are 0.
    """

    def __init__(self, plan):
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


def _numbers(shape):
    end = shape.bottom + shape.height
    if isinstance(shape, Box):
        return (1, shape.x, shape.y, math.cos(shape.yaw), math.sin(shape.yaw), shape.length / 2, shape.width / 2, 0.0,
                shape.bottom, end)
    return 0, shape.x, shape.y, 1.0, 0.0, 0.0, 0.0, shape.radius, shape.bottom, end


def in_frame_at(x, y, cos, sin, pose):
    """Return camera position (ox, oy), forward (fx, fy), right (rx, ry) in frames at (x, y), turned by cos and sin."""
    dx, dy = pose.x - x, pose.y - y
    forward, side = math.cos(pose.yaw), math.sin(pose.yaw)
    fx, fy = cos * forward + sin * side, cos * side - sin * forward
    return cos * dx + sin * dy, cos * dy - sin * dx, fx, fy, fy, -fx


def _in_frames_of(solids, index, pose):
    place = solids.x[index], solids.y[index], solids.cos[index], solids.sin[index]
    return (part[:, None] for part in in_frame_at(*place, pose))


def _in_view(solids, camera, pose):
    """Return the indices of solids that may be in the picture, by the circles around them."""
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


def _cross_boxes(solids, index, camera, pose):
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


def _cross_cylinders(solids, index, camera, pose):
    ox, oy, fx, fy, rx, ry = _in_frames_of(solids, index, pose)
    dx, dy = fx + rx * camera.right, fy + ry * camera.right
    square = dx * dx + dy * dy
    middle = -(ox * dx + oy * dy) / square
    miss = (ox * dy - oy * dx) ** 2 / square
    with np.errstate(invalid='ignore'):
        reach = np.sqrt((solids.radius[index, None] ** 2 - miss) / square)
    reach = np.where(np.isnan(reach), -1.0, reach)
    return _Crossings(middle - reach, middle + reach, np.full(middle.shape, ROUND), np.ones(middle.shape))


def _no_zero(direction):
    return np.where(np.abs(direction) < 1e-12, 1e-12, direction)


def _cross(solids, camera, pose):
    """Return the indices of solids that are met, boxes first, and their _Crossings."""
    index = _in_view(solids, camera, pose)
    boxes, cylinders = index[solids.box[index]], index[~solids.box[index]]
    crossings = _cross_boxes(solids, boxes, camera, pose)
    if len(cylinders):
        crossings = _Crossings(*map(np.concatenate, zip(crossings, _cross_cylinders(solids, cylinders, camera, pose))))
    met = np.flatnonzero(((crossings.enter < crossings.leave) & (crossings.leave > NEAR)).any(1))
    return np.concatenate([boxes, cylinders])[met], _Crossings(*(part[met] for part in crossings))


def look(solids, camera, pose):
    """Return the Sight of Solids that a PinholeCamera has from a CameraPose."""
    index, crossings = _cross(solids, camera, pose)
    pieces = _pieces(solids, camera, pose, index, crossings)
    return _layers(camera, pieces)


class _Pieces(NamedTuple):
    """Candidates (P, width) for what is seen, in any order; closed (P, 1): nothing is seen below it but the floor."""

    solid: np.ndarray
    kind: np.ndarray
    face: np.ndarray
    upper: np.ndarray
    lower: np.ndarray
    depth: np.ndarray
    incidence: np.ndarray
    key: np.ndarray
    closed: np.ndarray


def _pieces(solids, camera, pose, index, crossings):
    enter, near = crossings.enter, np.maximum(crossings.enter, NEAR)
    hit = (enter < crossings.leave) & (crossings.leave > NEAR)
    key = np.where(hit, near, np.inf) - TIE * solids.rank[index, None]
    over_top, over_bottom = ((pose.z - z[index, None]) * camera.focal for z in (solids.top, solids.bottom))
    upper, lower = camera.cy + over_top / near, camera.cy + over_bottom / near
    parts = [(np.arange(len(index)), FRONT, upper, lower, np.where(enter > NEAR, key, np.inf))]
    for k in np.flatnonzero(solids.top[index] < pose.z):
        higher = np.flatnonzero(solids.top[index] > solids.top[index[k]])
        for start, end, end_key in _stretches(k, higher, near, crossings.leave, hit, key):
            rows = camera.cy + over_top[k] / end, camera.cy + over_top[k] / start
            parts.append(([k], TOP, rows[0][None], np.minimum(rows[1] + SEAM, np.maximum(rows[1], lower[k]))[None],
                          end_key[None]))
    for k in np.flatnonzero(solids.bottom[index] > pose.z):
        lower_ones = np.flatnonzero(solids.bottom[index] < solids.bottom[index[k]])
        for start, end, end_key in _stretches(k, lower_ones, near, crossings.leave, hit, key):
            rows = camera.cy + over_bottom[k] / start, camera.cy + over_bottom[k] / end
            parts.append(([k], UNDER, np.maximum(rows[0] - SEAM, np.minimum(rows[0], upper[k]))[None], rows[1][None],
                          end_key[None]))
    source = np.concatenate([part[0] for part in parts])
    kind = np.repeat([part[1] for part in parts], [len(part[0]) for part in parts])
    upper, lower, key = (np.concatenate([part[k] for part in parts]) for k in (2, 3, 4))
    return _Pieces(index[source], kind, crossings.face[source], upper, lower, near[source],
                   crossings.incidence[source], key, solids.bottom[index][source] <= 0.0)


def _stretches(k, others, near, leave, hit, key):
    """Yield (start, end, key), each (width,), of the stretches [m] of the upper or lower end of solid k.

    Where one of `others` begins above (or below) the end, what lies behind is a stretch of its own, to be drawn before
    that other solid.
    """
    start, start_key = near[k], key[k] + 0.5 * TIE
    while np.isfinite(start_key).any():
        end, next_key = np.maximum(leave[k], start), np.full(len(start), np.inf)
        if len(others):
            begin = np.where(hit[others] & (near[others] > start) & (near[others] < end), near[others], np.inf)
            first = begin.argmin(0), np.arange(len(start))
            inside = np.isfinite(begin[first])
            end = np.where(inside, begin[first], end)
            next_key = np.where(inside, key[others][first] + 0.75 * TIE, next_key)
        yield start, end, start_key
        start, start_key = end, next_key


def _layers(camera, pieces):
    order = np.argsort(pieces.key, axis=0)
    place = order * camera.width + np.arange(camera.width)
    key, upper, lower = (part.take(place) for part in (pieces.key, pieces.upper, pieces.lower))
    closed = np.isfinite(key) & pieces.closed[order]
    clipped = np.maximum(upper, -0.5)
    covered = np.full((len(order) + 1, camera.width), np.inf)
    np.minimum.accumulate(np.where(closed, clipped, np.inf), axis=0, out=covered[1:])
    seen = np.isfinite(key) & (clipped < np.minimum(covered[:-1], camera.height - 0.5)) & (clipped < lower)
    floor_from = np.where(closed & (upper <= camera.cy), lower, camera.cy).max(0, initial=camera.cy)
    layer = np.cumsum(seen, axis=0) - 1
    target = (layer * camera.width + np.arange(camera.width))[seen]
    source, piece = place[seen], order[seen]
    shape = int(layer.max(initial=-1)) + 1, camera.width

    def laid(values, empty):
        out = np.full(shape, empty, values.dtype)
        out.put(target, values)
        return out
    return Sight(laid(pieces.solid[piece], -1), laid(pieces.kind[piece], FRONT), laid(pieces.face.take(source), ROUND),
                 *(laid(part.take(source), empty) for part, empty in
                   ((pieces.upper, 0.0), (pieces.lower, 0.0), (pieces.depth, 1.0), (pieces.incidence, 1.0))),
                 floor_from)
