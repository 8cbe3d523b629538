"""The compiled steps of the renderer (robotont_gazebo/native), where they were built.

Without them, visibility.visible_from, Background, FacePainter, LayerMask and Renderer do the same in numpy: where the
package was not built by catkin, and where the environment variable ROBOTONT_GAZEBO_PLAIN is set. Layers and depths are
the same to the bit; the colours of patterns differ by their rounding.
"""
import ctypes
import math
import os
from typing import Any, Dict, List, Optional, Tuple

import numpy as np

from robotont_gazebo.core import textures
from robotont_gazebo.core.backdrop import LEVELS, Background
from robotont_gazebo.core.camera import NEAR, CameraPose, PinholeCamera
from robotont_gazebo.core.faces import LIGHT, UPRIGHT, FacePainter
from robotont_gazebo.core.layers import STEEPEST
from robotont_gazebo.core.visibility import FRONT, ROUND, SEAM, TIE, Layer, Solids, VisibleLayers

NAME = 'librobotont_gazebo_native.so'  # a library of the package, found as any other: by LD_LIBRARY_PATH
PLAIN = 'ROBOTONT_GAZEBO_PLAIN'  # the environment variable that switches them off
INTERFACE = 1  # to be raised with each change of what a step is given or returns: a library built before is left out
LAYERS, RUNS, SOURCES = 8, 128, 64  # room for so many at first


def _load() -> Optional[ctypes.CDLL]:
    if os.environ.get(PLAIN):
        return None
    try:
        steps = ctypes.CDLL(NAME)
        return steps if steps.robotont_interface() == INTERFACE else None
    except (OSError, AttributeError):  # it is not there, or so old that it cannot say what it is
        return None


library = _load()

# ------------------------------------------------------------------- the structures of scene.h and picture.cpp

_SOURCE = np.dtype([('tones', 'u8'), ('width', 'i8'), ('height', 'i8'), ('along', 'f8'), ('up', 'f8'), ('top', 'f8'),
                    ('tint', 'i8', 3), ('plain', 'i8'), ('round', 'f8', 3)])
_FLOOR_IMAGE = np.dtype([('tones', 'u8'), ('bits', 'i8')])


class _Camera(ctypes.Structure):
    _fields_ = [('width', ctypes.c_int64), ('height', ctypes.c_int64), ('focal', ctypes.c_double),
                ('cx', ctypes.c_double), ('cy', ctypes.c_double), ('near', ctypes.c_double), ('tie', ctypes.c_double),
                ('seam', ctypes.c_double), ('right', ctypes.c_void_p)]


class _Pose(ctypes.Structure):
    _fields_ = [(name, ctypes.c_double) for name in ('x', 'y', 'z', 'cos', 'sin')]


class _Layers(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_int64) for name in ('capacity', 'run_capacity', 'count', 'run_count')),
                *((name, ctypes.c_void_p) for name in ('solid', 'kind', 'face', 'upper', 'lower', 'depth', 'incidence',
                                                       'floor_from', 'runs'))]


class _Style(ctypes.Structure):
    _fields_ = [('rows', ctypes.c_void_p), ('floor', ctypes.c_void_p),
                *((name, ctypes.c_double) for name in ('period', 'pad', 'steepest', 'upright', 'light_x', 'light_y')),
                ('floor_tint', ctypes.c_int64 * 3)]


class _Picture(ctypes.Structure):
    _fields_ = [('pixels', ctypes.c_void_p), ('blue_first', ctypes.c_int64), ('levels', ctypes.c_void_p),
                ('sources', ctypes.c_void_p), ('source_of_run', ctypes.c_void_p)]


def _address(array: np.ndarray) -> int:
    address: int = array.__array_interface__['data'][0]
    return address


class Scene:
    """What one camera sees in one world. Not thread-safe."""

    def __init__(self, steps: ctypes.CDLL, solids: Solids, camera: PinholeCamera, painter: FacePainter,
                 background: Background) -> None:
        self._steps, self._painter, self._background = steps, painter, background
        self._shapes, self._size = solids.shapes, (camera.height, camera.width)
        self._right, self._solids = np.ascontiguousarray(camera.right), _solid_rows(solids, painter)
        self._camera = _Camera(camera.width, camera.height, camera.focal, camera.cx, camera.cy, NEAR, TIE, SEAM,
                               _address(self._right))
        self._seen_from: Optional[CameraPose] = None
        self._pose, self._layers = _Pose(), _Layers()
        self._make_room(LAYERS, RUNS)
        self._index: Dict[Tuple[int, ...], int] = {}  # of sources, by solid, kind, face and levels
        self._sources = np.zeros(SOURCES, _SOURCE)
        self._kept: List[np.ndarray] = []  # whose addresses are in sources
        self._rows = _packed(background.rows)
        self._floor_tones = [textures.floor_tones(halved) for halved in range(LEVELS)]
        self._floor = np.array([(_address(tones), (len(tones) - 1).bit_length() - 1) for tones in self._floor_tones],
                               _FLOOR_IMAGE)
        self._style = _Style(_address(self._rows), _address(self._floor), textures.PERIOD, textures.PAD, STEEPEST,
                             UPRIGHT, *LIGHT, (ctypes.c_int64 * 3)(*_tint(np.array(background.colour, float))))
        self._picture = _Picture()

    def _make_room(self, layers: int, runs: int) -> None:
        width = self._size[1]
        self._integers, self._floats = np.empty((3, layers, width), np.int32), np.empty((4, layers, width))
        self._floor_from, self._runs = np.empty(width), np.empty((runs, 8), np.int32)
        self._source_of_run = np.empty(runs, np.int32)
        self._layers = _Layers(layers, runs, 0, 0, *map(_address, self._integers), *map(_address, self._floats),
                               _address(self._floor_from), _address(self._runs))

    def _look(self, pose: CameraPose) -> None:
        """Find the layers that are visible from ``pose``."""
        if pose == self._seen_from:
            return
        self._seen_from = None
        self._pose = _Pose(pose.x, pose.y, pose.z, math.cos(pose.yaw), math.sin(pose.yaw))
        while not self._steps.robotont_visible(ctypes.byref(self._camera), ctypes.byref(self._pose),
                                               ctypes.c_void_p(_address(self._solids)), len(self._solids),
                                               ctypes.byref(self._layers)):
            self._make_room(max(self._layers.count, self._layers.capacity),
                            max(2 * self._layers.run_count, self._layers.run_capacity))
        self._seen_from = pose

    def visible_from(self, pose: CameraPose) -> VisibleLayers:
        """Return the VisibleLayers for a camera at ``pose``, which are overwritten when it looks from another one."""
        self._look(pose)
        solid, kind, face = self._integers
        upper, lower, depth, incidence = self._floats
        rows = zip(solid, kind, face, upper, lower, depth, incidence)
        return VisibleLayers([Layer(*row) for row, _ in zip(rows, range(self._layers.count))], self._floor_from)

    def picture(self, pose: CameraPose, bgr: bool) -> np.ndarray:
        """Return the picture (height, width, 3) uint8 of a camera at ``pose``, a new array, RGB or BGR."""
        self._look(pose)
        count = self._layers.run_count
        self._source_of_run[:count] = [self._source(tuple(key)) for key in self._runs[:count, 3:].tolist()]
        levels = self._background.levels(pose.z)
        pixels = np.empty((*self._size, 3), np.uint8)
        self._picture = _Picture(_address(pixels), bgr, _address(levels), _address(self._sources),
                                 _address(self._source_of_run))
        self._steps.robotont_picture(ctypes.byref(self._camera), ctypes.byref(self._pose),
                                     ctypes.c_void_p(_address(self._solids)), ctypes.byref(self._layers),
                                     ctypes.byref(self._style), ctypes.byref(self._picture))
        return pixels

    def draw_depth(self, out: np.ndarray, pose: CameraPose, down: np.ndarray, near: float, far: float) -> None:
        """Draw the depths [m] between ``near`` and ``far`` of all solids onto ``out`` (height, width) float32.

        NaN elsewhere; ``down`` (height,): y / z of each row.
        """
        self._look(pose)
        self._steps.robotont_depth(ctypes.byref(self._camera), ctypes.byref(self._pose),
                                   ctypes.c_void_p(_address(self._solids)), ctypes.byref(self._layers),
                                   ctypes.c_void_p(_address(down)), ctypes.c_double(near), ctypes.c_double(far),
                                   ctypes.c_void_p(_address(out)))

    def _source(self, key: Tuple[int, ...]) -> int:
        """Return the index of the source of a face: solid, kind, face, levels along and up."""
        index = self._index.get(key)
        if index is None:
            index = self._index[key] = len(self._index)
            if index == len(self._sources):
                self._sources = np.concatenate([self._sources, np.zeros_like(self._sources)])
            self._sources[index] = self._new_source(*key)
        return index

    def _new_source(self, solid: int, kind: int, face: int, along: int, up: int) -> Tuple[Any, ...]:
        pattern = self._painter.patterns.get((solid, face)) if kind == FRONT else None
        if pattern is not None:
            mipmap = pattern.tones()
            image, per_metre_along, per_metre_up = mipmap.at(along, up)
            self._kept.append(image)
            height, width = image.shape
            top = self._shapes[solid].bottom + mipmap.height
            return (_address(image), width, height, per_metre_along, per_metre_up, top, _tint(pattern.colour), 0,
                    (-1.0,) * 3)
        plain = int(_packed(self._painter.plain[solid, kind, face]))
        curved = kind == FRONT and face == ROUND
        return 0, 0, 0, 0.0, 0.0, 0.0, (0,) * 3, plain, self._shapes[solid].colour if curved else (-1.0,) * 3


def _solid_rows(solids: Solids, painter: FacePainter) -> np.ndarray:
    """Return the solids as rows of numbers: Solid of scene.h."""
    numbers = np.stack([solids.box, solids.x, solids.y, solids.cos, solids.sin, solids.half_x, solids.half_y,
                        solids.radius, solids.bottom, solids.top, solids.reach, solids.rank], 1).astype(float)
    sizes = np.where(painter.patterned, painter.sizes, np.nan)
    return np.ascontiguousarray(np.concatenate([numbers, sizes, painter.level_sizes()], 1))


def _tint(colour: np.ndarray) -> Tuple[int, ...]:
    """Return a colour (3,), 0..255, in parts of 1 / 65536."""
    return tuple(np.round(colour * (65536 / 255)).astype(int).tolist())


def _packed(colours: np.ndarray) -> np.ndarray:
    """Return colours (..., 4), uint8 RGBA, as numbers (...): red + 256 * green + 65536 * blue."""
    packed: np.ndarray = colours[..., :3].astype(np.uint32) @ np.array([1, 256, 65536], np.uint32)
    return packed
