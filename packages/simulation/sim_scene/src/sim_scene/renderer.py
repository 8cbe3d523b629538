"""Renders colour and depth images of a floor plan as the Robotont's camera sees it.

The steps that draw are compiled (native/); here, they are given the camera, the solids and the images of patterns.
"""
from typing import Sequence, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.camera import (
    DEPTH_FAR,
    DEPTH_NEAR,
    GAMMA,
    HEIGHT,
    HORIZONTAL_FOV,
    NEAR,
    WIDTH,
    PinholeCamera,
    require_gamma,
    require_pose,
    require_range,
)
from kinematic_core.worlds.floor_plan import FloorPlan
from sim_scene import textures
from sim_scene.faces import Faces, light
from sim_scene.native import Background, Camera, Pose, Scene
from sim_scene.response import Response, response_of

SHARPNESS = 1.1  # pixels of the floor's image per pixel of the camera, in the geometric mean of its two directions
LEVELS = 5  # images of the floor, each half as fine as the previous one; beyond the last one it is plain
ZENITH_TONE, HORIZON_WHITE = 0.82, 0.55  # brightness of the sky at the top, and share of white at the horizon
SKY_HEIGHT = 0.6  # [tangent of the elevation] from which on the sky has its darkest tone


class Renderer:
    """Renders one FloorPlan. Not thread-safe: only one thread may use a Renderer at a time.

    ``patterns``: False draws plain colours, without bricks, tiles, markers and the sky's gradient. ``depth_range`` [m]:
    the depth image shows only what lies between these two. ``gamma``: of the camera's response; edges are blended in
    light, value ** gamma. Raises InvalidInput for an impossible camera, alvar_core's
    CodeError for a panel id that no marker can have.
    """

    def __init__(self, plan: FloorPlan, width: float = WIDTH, height: float = HEIGHT,
                 horizontal_fov: float = HORIZONTAL_FOV, patterns: bool = True,
                 depth_range: Tuple[float, float] = (DEPTH_NEAR, DEPTH_FAR), gamma: float = GAMMA) -> None:
        self.camera = camera = PinholeCamera(width, height, horizontal_fov)
        self._near, self._far = require_range(*depth_range)
        response = response_of(require_gamma(gamma))
        faces = Faces(plan, response, patterns)
        self._scene = Scene(camera=Camera(width=camera.width, height=camera.height, focal=camera.focal, cx=camera.cx,
                                          cy=camera.cy, near=NEAR),
                            solids=faces.solids, pattern=faces.pattern, light=light(),
                            response=response.compiled,
                            background=_background(camera, plan.ground_colour, plan.sky_colour, response, patterns))

    def render(self, camera_pose: Sequence[float], bgr: bool = False) -> np.ndarray:
        """Return the image of a camera at (x, y, z, yaw) [m, rad]: a new array (height, width, 3) uint8.

        RGB, or with ``bgr`` in OpenCV's order.
        """
        return self._scene.picture(Pose(*require_pose(camera_pose)), bgr=bgr)

    def depth(self, camera_pose: Sequence[float]) -> np.ndarray:
        """Return the depth (height, width) float32 [m] along the optical axis from (x, y, z, yaw) [m, rad].

        Depths that are not inside ``depth_range`` are NaN, as in the images of Gazebo's depth camera plugins.
        """
        return self._scene.depth(Pose(*require_pose(camera_pose)), near=self._near, far=self._far)

    def points(self, depth: np.ndarray) -> np.ndarray:
        """Return the points (height, width, 3) [m] in the optical frame of a depth image (height, width) [m].

        Both are float32; NaN stays NaN.
        """
        right, down = (slopes.astype(np.float32) for slopes in (self.camera.right, self.camera.down))
        return cv2.merge([depth * right, depth * down[:, None], depth])


def _background(camera: PinholeCamera, ground: Sequence[int], sky: Sequence[int], response: Response,
                patterns: bool) -> Background:
    """Return the Background that a camera sees, with floor and sky of these colours; ``patterns``: False for plain."""
    ground_colour, sky_colour = np.array(ground, float), np.array(sky, float)
    floor = [response.image(textures.floor(halved, response)) for halved in range(LEVELS)] if patterns else []
    rows = _rows(camera, ground_colour, sky_colour, response) if patterns else \
        np.where(camera.down[:, None] >= 0.0, ground_colour, sky_colour)
    return Background(rows=textures.rounded(rows), floor=floor, colour=ground_colour, period=textures.PERIOD,
                      sharpness=SHARPNESS)


def _rows(camera: PinholeCamera, ground: np.ndarray, sky: np.ndarray, response: Response) -> np.ndarray:
    """Return the colours (height, 3) of the rows: the sky's gradient, and the mean of the floor's pattern."""
    down = camera.down[:, None]
    up = np.clip(-down / SKY_HEIGHT, 0.0, 1.0)
    horizon = sky + (255.0 - sky) * HORIZON_WHITE
    darker = horizon + (sky * ZENITH_TONE - horizon) * np.sqrt(up)
    return np.where(down >= 0.0, textures.floor_mean(ground, response), darker)
