"""Draw the faces of solids: bricks and markers in perspective, plain colours, shaded cylinders."""
import math
from functools import partial
from typing import Callable, Dict, Iterator, NamedTuple, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.floor_plan import Box, Colour, Solid
from robotont_gazebo.core import textures
from robotont_gazebo.core.camera import CameraPose, PinholeCamera
from robotont_gazebo.core.layers import LayerMask
from robotont_gazebo.core.visibility import (
    FRONT,
    LEFT_OF_X,
    LEFT_OF_Y,
    RIGHT_OF_X,
    RIGHT_OF_Y,
    ROUND,
    Layer,
    Solids,
    in_frame_at,
)

LIGHT = (0.16, 0.10)  # additional brightness of faces towards +x and +y
UPRIGHT, TOP_SHADE, UNDER_SHADE = 0.81, 1.0, 0.55  # brightness of upright faces on average, upper and lower ends
COARSEST = 12  # a pattern's image is halved at most this many times
FINEST_STEPS = COARSEST * textures.PANEL_STEPS  # levels of the image with most of them; kLevels of native/scene.h
SHARPER = 0.4  # halvings by which a wall's image has a higher resolution than the camera's

Row = Tuple[float, float, float]


class Pattern(NamedTuple):
    """Functions that return a face's Mipmap, when it is seen: in colour, and its tones (0..255) of ``colour`` (3,)."""

    image: Callable[[], textures.Mipmap]
    tones: Callable[[], textures.Mipmap]
    colour: np.ndarray


def shade(normal_x: textures.FloatOrArray, normal_y: textures.FloatOrArray) -> textures.FloatOrArray:
    """Return the brightness 0..1 of an upright face with this unit normal in the world; floats or arrays."""
    return UPRIGHT + LIGHT[0] * normal_x + LIGHT[1] * normal_y


class FacePainter:
    """Draws one Layer of Solids; ``patterns``: False for plain colours.

    patterns: the Pattern of (solid, face); plain (N, kinds, faces, 4): the colours of all others; patterned, sizes
    (N, faces): where there is a pattern, and its pixels per pixel of the camera, 1 m away.
    """

    def __init__(self, solids: Solids, camera: PinholeCamera, patterns: bool) -> None:
        self._solids, self._camera = solids, camera
        self._resolution = np.full((solids.count, ROUND + 1), np.nan)  # [px/m] of patterned faces, nan: plain
        self.plain = np.zeros((solids.count, 3, ROUND + 1, 4), np.uint8)  # colours by solid, kind and face
        self.patterns: Dict[Tuple[int, int], Pattern] = {}
        self._steps, self._sharper = np.ones(solids.count), np.full(solids.count, SHARPER)
        for index, shape in enumerate(solids.shapes):
            self._prepare(index, shape, patterns)
        self.patterned = ~np.isnan(self._resolution)
        self.sizes = np.where(self.patterned, self._resolution, 1.0) / camera.focal

    def _prepare(self, index: int, shape: Solid, patterns: bool) -> None:
        colour, solids = np.array(shape.colour, float), self._solids
        cos, sin = solids.cos[index], solids.sin[index]
        normals = ((-cos, -sin), (cos, sin), (sin, -cos), (-sin, cos), (0.0, 0.0))  # in the order of the faces
        brightness = np.array([[shade(*normal) for normal in normals], [TOP_SHADE] * 5, [UNDER_SHADE] * 5])
        self.plain[index] = textures.rgba(brightness[..., None] * colour)
        if not patterns or not isinstance(shape, Box):
            return
        if index in solids.panel_of:
            panel = solids.panel_of[index]
            what = panel.marker_id, panel.size, panel.marker_size
            textures.panel_tones(*what)  # refuses an impossible id
            self.patterns[index, LEFT_OF_X] = Pattern(partial(textures.panel, *what),
                                                      partial(textures.panel_tones, *what), np.full(3, 255.0))
            self._resolution[index, LEFT_OF_X] = textures.PANEL_PIXELS / panel.size
            self._steps[index], self._sharper[index] = textures.PANEL_STEPS, 0.0
        elif shape.height >= textures.COURSE:
            for face in range(ROUND):
                length = shape.width if face in (LEFT_OF_X, RIGHT_OF_X) else shape.length
                coarser = textures.coarser_for(length, shape.height)
                tone = round(brightness[FRONT, face] * textures.SHADES) / textures.SHADES
                size = coarser, shape.bottom <= 0.0
                self.patterns[index, face] = Pattern(partial(textures.wall, _colour(shape.colour), tone, *size),
                                                     partial(textures.wall_tones, *size), colour * tone)
                self._resolution[index, face] = textures.WALL_RESOLUTION / 2 ** coarser

    def draw(self, drawn: np.ndarray, pose: CameraPose, layer: Layer, mask: LayerMask) -> None:
        """Draw a layer onto ``drawn``, (height, width, 4) uint8 RGBA; outside its mask the result is undefined."""
        patterned = self.patterned[layer.solid, layer.face] & (layer.kind == FRONT) & (layer.solid >= 0)
        if not patterned.all():
            self._fill(drawn, pose, layer, mask, ~patterned & (layer.solid >= 0))
        if patterned.any():
            along, up = self._levels(layer)
            keys = np.where(patterned, ((layer.solid * 4 + layer.face) * 32 + along) * 32 + up, -1)
            for left, right in _runs(keys):
                if patterned[left]:
                    self._map(drawn, pose, (int(layer.solid[left]), int(layer.face[left])), (along[left], up[left]),
                              (left, right, *mask.rows_of(left, right)))

    def _fill(self, drawn: np.ndarray, pose: CameraPose, layer: Layer, mask: LayerMask, columns: np.ndarray) -> None:
        colours = self.plain[layer.solid, layer.kind, layer.face]
        curved = columns & (layer.face == ROUND) & (layer.kind == FRONT)
        if curved.any():
            colours[curved] = self._round_colours(pose, layer, np.flatnonzero(curved))
        words, target = colours.view(np.uint32)[:, 0], drawn.view(np.uint32)[:, :, 0]
        for left, right in _runs(np.where(columns, layer.solid, -1)):
            if columns[left]:
                top, bottom = mask.rows_of(left, right)
                target[top:bottom, left:right] = words[left:right]

    def _round_colours(self, pose: CameraPose, layer: Layer, columns: np.ndarray) -> np.ndarray:
        solids, index, depth = self._solids, layer.solid[columns], layer.depth[columns]
        aside = depth * self._camera.right[columns]
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        normal_x = (pose.x + depth * cos + aside * sin - solids.x[index]) / solids.radius[index]
        normal_y = (pose.y + depth * sin - aside * cos - solids.y[index]) / solids.radius[index]
        base = np.array([self._solids.shapes[k].colour for k in range(solids.count)], float)[index]
        return textures.rgba(base * shade(normal_x, normal_y)[:, None])

    def _levels(self, layer: Layer) -> Tuple[np.ndarray, np.ndarray]:
        """Return the levels (width,) along and up of the pattern's image in each column, whole numbers."""
        size = self.sizes[layer.solid, layer.face] * layer.depth
        sharper, steps = self._sharper[layer.solid], self._steps[layer.solid]
        along, up = (np.round(np.clip(np.log2(ratio) - sharper, 0, COARSEST) * steps).astype(int)
                     for ratio in (size / layer.incidence, size))
        return along, up

    def level_sizes(self) -> np.ndarray:
        """Return the sizes [pattern's px/px] from which on ``_levels`` are 1, 2, ..., (N, FINEST_STEPS); inf: never."""
        number, steps = np.arange(1, FINEST_STEPS + 1), self._steps[:, None]
        halvings = (number - 0.5) / steps + self._sharper[:, None]
        sizes: np.ndarray = np.where(number <= COARSEST * steps, 2.0 ** halvings, np.inf)
        return sizes

    def _map(self, drawn: np.ndarray, pose: CameraPose, which: Tuple[int, int], level: Tuple[int, int],
             part: Tuple[int, int, int, int]) -> None:
        """Draw the pattern of ``which`` (solid, face) at a level (along, up) in a part: left, right, top, bottom."""
        left, right, top, bottom = part
        if top >= bottom:
            return
        mipmap = self.patterns[which].image()
        image, along, up = mipmap.at(int(level[0]), int(level[1]))
        camera = self._camera
        x, y, z = left - camera.cx, top - camera.cy, camera.focal  # a ray through the part's pixel (0, 0)
        rows = [(a, b, a * x + b * y + c * z) for a, b, c in self._to_face(pose, *which, mipmap.height)]
        offset = textures.PAD - 0.5
        to_image = np.array([[along * s + offset * w for s, w in zip(rows[0], rows[2])],
                               [up * t + offset * w for t, w in zip(rows[1], rows[2])], rows[2]])
        cv2.warpPerspective(image, to_image, (right - left, bottom - top), dst=drawn[top:bottom, left:right],
                            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_CONSTANT)

    def _to_face(self, pose: CameraPose, index: int, face: int, height: float) -> Tuple[Row, Row, Row]:
        """Return the map (3 rows of 3) from (x, y, z) of a ray in the optical frame to (along, down, 1) [m] on a face.

        Along from its left edge, down from ``height`` [m] above its foot.
        """
        box = self._solids.shapes[index]
        assert isinstance(box, Box)
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


def _colour(colour: Colour) -> Colour:
    """Return the colour, a tuple or a list from a file, as a tuple, which can be a key."""
    red, green, blue = colour
    return red, green, blue


def _runs(keys: np.ndarray) -> Iterator[Tuple[int, int]]:
    """Yield (left, right) of each run of equal keys (width,)."""
    borders = np.flatnonzero(keys[1:] != keys[:-1]) + 1
    yield from zip([0, *borders.tolist()], [*borders.tolist(), len(keys)])

