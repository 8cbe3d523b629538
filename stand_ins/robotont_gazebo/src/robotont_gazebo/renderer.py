"""Pictures of a floor plan from the Robotont's camera: colour and depth.

The picture is put together from the layers that sight.look finds, the farthest first: each face is drawn by the one
perspective map that belongs to its plane, in a size of its pattern that fits the distance, and blended at its upper
and lower edges by how much of a pixel it covers. Upright edges fall between two columns.
"""
import cv2
import numpy as np

from robotont_gazebo import sight
from robotont_gazebo.backdrop import Backdrop
from robotont_gazebo.camera import FAR, HEIGHT, HORIZONTAL_FOV, NEAR, WIDTH, PinholeCamera, require_pose
from robotont_gazebo.faces import FacePainter
from robotont_gazebo.layers import Edges


class Renderer:
    """Renders a FloorPlan; not thread safe: one thread uses a Renderer at a time. Another plan: another Renderer.

    patterns: False leaves out bricks, tiles, markers and the sky's gradient, for plain colours. Raises InvalidInput
    for a camera that cannot be, alvar_core's CodeError for a panel's id that no marker can have.
    """

    def __init__(self, plan, width=WIDTH, height=HEIGHT, horizontal_fov=HORIZONTAL_FOV, patterns=True):
        self.camera = PinholeCamera(width, height, horizontal_fov)
        self._solids = sight.Solids(plan)
        self._backdrop = Backdrop(self.camera, plan.ground_colour, plan.sky_colour, patterns)
        self._painter = FacePainter(self._solids, self.camera, patterns)
        self._canvas, self._scratch = (np.zeros((self.camera.height, self.camera.width, 4), np.uint8) for _ in '12')
        self._last_pose = self._last_sight = None

    def render(self, camera_pose):
        """Return what is seen from (x, y, z, yaw) [m, rad] of the camera: (height, width, 3) uint8 RGB, a new array."""
        pose = require_pose(camera_pose)
        seen = self._look(pose)
        self._backdrop.draw(self._canvas, pose, seen.floor_from)
        for layer in reversed(seen.layers()):
            edges = Edges(layer, self.camera.height)
            self._painter.draw(self._scratch, pose, layer, edges)
            edges.blend(self._canvas, self._scratch)
        return cv2.cvtColor(self._canvas, cv2.COLOR_RGBA2RGB)

    def depth(self, camera_pose):
        """Return the depth (height, width) float32 [m] along the optical axis from (x, y, z, yaw) [m, rad].

        What is nearer than NEAR or farther than FAR is NaN, as in the pictures of Gazebo's depth camera plugins.
        """
        pose = require_pose(camera_pose)
        rows = self.camera.down
        out = np.empty((self.camera.height, self.camera.width), np.float32)
        out[:] = _reported(np.where(rows > 0.0, pose.z / np.maximum(rows, 1e-9), np.nan))[:, None]
        for layer in reversed(self._look(pose).layers()):
            self._lay_depth(out, pose, layer)
        return out

    def _look(self, pose):
        if pose != self._last_pose:
            self._last_sight, self._last_pose = sight.look(self._solids, self.camera, pose), pose
        return self._last_sight

    def _lay_depth(self, out, pose, layer):
        height = self.camera.height
        first, end = (np.ceil(np.clip(row, 0, height)).astype(np.int16) for row in (layer.upper, layer.lower))
        for kind, level in ((sight.FRONT, None), (sight.TOP, self._solids.top), (sight.UNDER, self._solids.bottom)):
            mine = (layer.solid >= 0) & (layer.kind == kind) & (first < end)
            if mine.any():
                columns = np.flatnonzero(mine)
                part = np.s_[columns[0]:columns[-1] + 1]
                top, bottom = int(first[mine].min()), int(end[mine].max())
                rows = np.arange(top, bottom, dtype=np.int16)[:, None]
                mask = (rows >= first[part]) & (rows < np.where(mine, end, 0)[part])
                depth = layer.depth[None, part] if level is None else \
                    (pose.z - level[layer.solid[part]]) / _no_zero(self.camera.down[top:bottom, None])
                np.copyto(out[top:bottom, part], _reported(depth), where=mask)


def _reported(depth):
    """Return depths as float32, NaN where the camera does not report them."""
    with np.errstate(invalid='ignore'):
        return np.where((depth >= NEAR) & (depth <= FAR), depth, np.nan).astype(np.float32)


def _no_zero(slope):
    return np.where(slope == 0.0, 1e-9, slope)

