"""Drawing the faces of solids: bricks and markers in perspective, plain colours, cylinders shaded around."""
import math

import cv2
import numpy as np

from robotont_gazebo import textures
from robotont_gazebo.sight import FRONT, LEFT_OF_X, LEFT_OF_Y, RIGHT_OF_X, RIGHT_OF_Y, ROUND, in_frame_at

LIGHT = (0.16, 0.10)  # how much brighter faces towards +x and +y are
UPRIGHT, TOP_SHADE, UNDER_SHADE = 0.81, 1.0, 0.55  # brightness of upright faces on average, upper and lower ends
COARSEST = 12  # times that a pattern's picture is halved at most
SHARPER = 0.4  # times halved that a wall's picture is finer than the camera's


def shade(normal_x, normal_y):
    """Return the brightness 0..1 of an upright face by its unit normal in the world."""
    return UPRIGHT + LIGHT[0] * normal_x + LIGHT[1] * normal_y


class FacePainter:
    """Draws what one layer of a Sight shows of Solids; patterns: False for plain colours."""

    def __init__(self, solids, camera, patterns):
        self._solids, self._camera = solids, camera
        self._resolution = np.full((solids.count, ROUND + 1), np.nan)  # [px/m] of patterned faces, nan: plain
        self._plain = np.zeros((solids.count, 3, ROUND + 1, 4), np.uint8)  # colours by solid, kind and face
        self._pattern = {}
        self._steps, self._sharper = np.ones(solids.count), np.full(solids.count, SHARPER)
        for index, shape in enumerate(solids.shapes):
            self._prepare(index, shape, patterns)
        self._patterned = ~np.isnan(self._resolution)
        self._sizes = np.where(self._patterned, self._resolution, 1.0) / camera.focal  # [pattern's px/px] 1 m away

    def _prepare(self, index, shape, patterns):
        colour, solids = np.array(shape.colour, float), self._solids
        cos, sin = solids.cos[index], solids.sin[index]
        normals = ((-cos, -sin), (cos, sin), (sin, -cos), (-sin, cos), (0.0, 0.0))  # in the order of the faces
        brightness = np.array([[shade(*normal) for normal in normals], [TOP_SHADE] * 5, [UNDER_SHADE] * 5])
        self._plain[index] = textures.rgba(brightness[..., None] * colour)
        if not patterns or not solids.box[index]:
            return
        if index in solids.panel_of:
            panel = solids.panel_of[index]
            self._pattern[index, LEFT_OF_X] = textures.panel(panel.marker_id, panel.size, panel.marker_size)
            self._resolution[index, LEFT_OF_X] = textures.PANEL_PIXELS / panel.size
            self._steps[index], self._sharper[index] = textures.PANEL_STEPS, 0.0
        elif shape.height >= textures.COURSE:
            for face in range(ROUND):
                length = shape.width if face in (LEFT_OF_X, RIGHT_OF_X) else shape.length
                coarser = textures.coarser_for(length, shape.height)
                tone = round(brightness[FRONT, face] * textures.SHADES) / textures.SHADES
                self._pattern[index, face] = tuple(shape.colour), tone, coarser, shape.bottom <= 0.0
                self._resolution[index, face] = textures.WALL_RESOLUTION / 2 ** coarser

    def draw(self, drawn, pose, layer, edges):
        """Draw a layer onto `drawn`, (height, width, 4) uint8 RGBA; more than its Edges cover is left undefined."""
        patterned = self._patterned[layer.solid, layer.face] & (layer.kind == FRONT) & (layer.solid >= 0)
        if not patterned.all():
            self._fill(drawn, pose, layer, edges, ~patterned & (layer.solid >= 0))
        if patterned.any():
            along, up = self._levels(layer)
            keys = np.where(patterned, ((layer.solid * 4 + layer.face) * 32 + along) * 32 + up, -1)
            for left, right in _runs(keys):
                if patterned[left]:
                    self._map(drawn, pose, (int(layer.solid[left]), int(layer.face[left])), (along[left], up[left]),
                              (left, right, *edges.rows_of(left, right)))

    def _fill(self, drawn, pose, layer, edges, columns):
        colours = self._plain[layer.solid, layer.kind, layer.face]
        curved = columns & (layer.face == ROUND) & (layer.kind == FRONT)
        if curved.any():
            colours[curved] = self._round_colours(pose, layer, np.flatnonzero(curved))
        words, target = colours.view(np.uint32)[:, 0], drawn.view(np.uint32)[:, :, 0]
        for left, right in _runs(np.where(columns, layer.solid, -1)):
            if columns[left]:
                top, bottom = edges.rows_of(left, right)
                target[top:bottom, left:right] = words[left:right]

    def _round_colours(self, pose, layer, columns):
        solids, index, depth = self._solids, layer.solid[columns], layer.depth[columns]
        aside = depth * self._camera.right[columns]
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        normal_x = (pose.x + depth * cos + aside * sin - solids.x[index]) / solids.radius[index]
        normal_y = (pose.y + depth * sin - aside * cos - solids.y[index]) / solids.radius[index]
        base = np.array([self._solids.shapes[k].colour for k in range(solids.count)], float)[index]
        return textures.rgba(base * shade(normal_x, normal_y)[:, None])

    def _levels(self, layer):
        """Return the levels along and up of the pattern's picture in each column, whole numbers."""
        size = self._sizes[layer.solid, layer.face] * layer.depth
        sharper, steps = self._sharper[layer.solid], self._steps[layer.solid]
        return (np.round(np.clip(np.log2(ratio) - sharper, 0, COARSEST) * steps).astype(int)
                for ratio in (size / layer.incidence, size))

    def _map(self, drawn, pose, which, level, part):
        left, right, top, bottom = part
        if top >= bottom:
            return
        pattern = self._pattern[which]
        mipmap = pattern if isinstance(pattern, textures.Mipmap) else textures.wall(*pattern)
        picture, along, up = mipmap.at(int(level[0]), int(level[1]))
        camera = self._camera
        x, y, z = left - camera.cx, top - camera.cy, camera.focal  # a ray through the part's pixel (0, 0)
        rows = [(a, b, a * x + b * y + c * z) for a, b, c in self._to_face(pose, *which, mipmap.height)]
        offset = textures.PAD - 0.5
        to_picture = np.array([[along * s + offset * w for s, w in zip(rows[0], rows[2])],
                               [up * t + offset * w for t, w in zip(rows[1], rows[2])], rows[2]])
        cv2.warpPerspective(picture, to_picture, (right - left, bottom - top), dst=drawn[top:bottom, left:right],
                            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_CONSTANT)

    def _to_face(self, pose, index, face, height):
        """Return the map (3 rows of 3) from (x, y, z) of a ray in the optical frame to (along, down, 1) [m] on a face.

        Along from its left edge, down from `height` [m] above its foot.
        """
        box = self._solids.shapes[index]
        half_x, half_y = box.length / 2.0, box.width / 2.0
        ox, oy, fx, fy, rx, ry = in_frame_at(box.x, box.y, math.cos(box.yaw), math.sin(box.yaw), pose)
        if face >= LEFT_OF_Y:
            ox, oy, fx, fy, rx, ry, half_x, half_y = oy, -ox, fy, -fx, ry, -rx, half_y, half_x
        if face in (RIGHT_OF_X, RIGHT_OF_Y):
            ox, oy, fx, fy, rx, ry = -ox, -oy, -fx, -fy, -rx, -ry
        # Now the viewer looks along +x at the face x = -half_x, -y is to the right, and 1 / depth is linear in the ray.
        inverse = rx / (-half_x - ox), 0.0, fx / (-half_x - ox)
        aside, above = half_y - oy, box.bottom + height - pose.z
        return ((aside * inverse[0] - ry, 0.0, aside * inverse[2] - fy),
                (above * inverse[0], 1.0, above * inverse[2]), inverse)


def _runs(keys):
    """Yield (left, right) of the stretches of equal keys."""
    borders = np.flatnonzero(keys[1:] != keys[:-1]) + 1
    yield from zip([0, *borders.tolist()], [*borders.tolist(), len(keys)])

