"""Renders colour and depth images of a floor plan as the Robotont's camera sees it.

The image is composed of the layers that visibility.visible_from finds, the farthest first. Each face is drawn by the
perspective map of its plane, from an image of its pattern in a size that suits the distance. Its upper and lower edges
are blended by how much of a pixel they cover; upright edges fall between two columns.
"""
from typing import Optional, Sequence, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.floor_plan import FloorPlan
from robotont_gazebo.core import native, visibility
from robotont_gazebo.core.backdrop import Background
from robotont_gazebo.core.camera import (
    DEPTH_FAR,
    DEPTH_NEAR,
    HEIGHT,
    HORIZONTAL_FOV,
    WIDTH,
    CameraPose,
    PinholeCamera,
    require_pose,
    require_range,
)
from robotont_gazebo.core.faces import FacePainter
from robotont_gazebo.core.layers import LayerMask


class Renderer:
    """Renders one FloorPlan. Not thread-safe: only one thread may use a Renderer at a time.

    ``patterns``: False draws plain colours, without bricks, tiles, markers and the sky's gradient. ``depth_range`` [m]:
    the depth image shows only what lies between these two. Raises InvalidInput for an impossible camera, alvar_core's
    CodeError for a panel id that no marker can have.
    """

    def __init__(self, plan: FloorPlan, width: float = WIDTH, height: float = HEIGHT,
                 horizontal_fov: float = HORIZONTAL_FOV, patterns: bool = True,
                 depth_range: Tuple[float, float] = (DEPTH_NEAR, DEPTH_FAR)) -> None:
        self.camera = PinholeCamera(width, height, horizontal_fov)
        self._depth_range = require_range(*depth_range)
        self._solids = visibility.Solids(plan)
        self._background = Background(self.camera, plan.ground_colour, plan.sky_colour, patterns)
        self._painter = FacePainter(self._solids, self.camera, patterns)
        self._scene = native.library and native.Scene(native.library, self._solids, self.camera, self._painter,
                                                      self._background)
        self._canvas = self._scratch = np.zeros((0, 0, 4), np.uint8)  # of the drawing without compiled steps
        self._last_pose: Optional[CameraPose] = None
        self._last_visible: visibility.VisibleLayers

    def render(self, camera_pose: Sequence[float], bgr: bool = False) -> np.ndarray:
        """Return the image of a camera at (x, y, z, yaw) [m, rad]: a new array (height, width, 3) uint8.

        RGB, or with ``bgr`` in OpenCV's order.
        """
        pose = require_pose(camera_pose)
        if self._scene:
            return self._scene.picture(pose, bgr)
        return cv2.cvtColor(self._drawn(pose), cv2.COLOR_RGBA2BGR if bgr else cv2.COLOR_RGBA2RGB)

    def _drawn(self, pose: CameraPose) -> np.ndarray:
        """Return the image (height, width, 4) uint8 RGBA, which is overwritten by the next one."""
        if not self._canvas.size:
            self._canvas, self._scratch = (np.zeros((self.camera.height, self.camera.width, 4), np.uint8)
                                           for _ in range(2))
        visible = self.visible_from(pose)
        self._background.draw(self._canvas, pose, visible.floor_from)
        for layer in reversed(visible.layers):
            mask = LayerMask(layer, self.camera.height)
            self._painter.draw(self._scratch, pose, layer, mask)
            mask.blend(self._canvas, self._scratch)
        return self._canvas

    def depth(self, camera_pose: Sequence[float]) -> np.ndarray:
        """Return the depth (height, width) float32 [m] along the optical axis from (x, y, z, yaw) [m, rad].

        Depths that are not inside ``depth_range`` are NaN, as in the images of Gazebo's depth camera plugins.
        """
        pose = require_pose(camera_pose)
        rows = self.camera.down
        out = np.empty((self.camera.height, self.camera.width), np.float32)
        out[:] = self._reported(np.where(rows > 0.0, pose.z / np.maximum(rows, 1e-9), np.nan))[:, None]
        if self._scene:
            self._scene.draw_depth(out, pose, rows, *self._depth_range)
            return out
        for layer in reversed(self.visible_from(pose).layers):
            self._draw_depth(out, pose, layer)
        return out

    def visible_from(self, pose: CameraPose) -> visibility.VisibleLayers:
        """Return the VisibleLayers for a camera at ``pose``; the next call for another pose may overwrite them."""
        if self._scene:
            return self._scene.visible_from(pose)
        if pose != self._last_pose:
            self._last_visible, self._last_pose = visibility.visible_from(self._solids, self.camera, pose), pose
        return self._last_visible

    def _draw_depth(self, out: np.ndarray, pose: CameraPose, layer: visibility.Layer) -> None:
        height = self.camera.height
        first, end = (np.ceil(np.clip(row, 0, height)).astype(np.int16) for row in (layer.upper, layer.lower))
        for kind, level in ((visibility.FRONT, None), (visibility.TOP, self._solids.top),
                            (visibility.UNDER, self._solids.bottom)):
            mine = (layer.solid >= 0) & (layer.kind == kind) & (first < end)
            if mine.any():
                columns = np.flatnonzero(mine)
                part = np.s_[columns[0]:columns[-1] + 1]
                top, bottom = int(first[mine].min()), int(end[mine].max())
                rows = np.arange(top, bottom, dtype=np.int16)[:, None]
                mask = (rows >= first[part]) & (rows < np.where(mine, end, 0)[part])
                depth = layer.depth[None, part] if level is None else \
                    (pose.z - level[layer.solid[part]]) / _no_zero(self.camera.down[top:bottom, None])
                np.copyto(out[top:bottom, part], self._reported(depth), where=mask)

    def _reported(self, depth: np.ndarray) -> np.ndarray:
        """Return depths as float32, NaN where the camera does not report them."""
        near, far = self._depth_range
        with np.errstate(invalid='ignore'):
            reported: np.ndarray = np.where((depth > near) & (depth < far), depth, np.nan).astype(np.float32)
            return reported


def _no_zero(slope: np.ndarray) -> np.ndarray:
    return np.where(slope == 0.0, 1e-9, slope)

