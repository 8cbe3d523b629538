"""Draw sky and floor, the background of a world."""
import math
from typing import Iterator, Optional, Sequence, Tuple

import cv2
import numpy as np

from kinematic_core.worlds.floor_plan import Colour
from robotont_gazebo.core import textures
from robotont_gazebo.core.camera import CameraPose, PinholeCamera

SHARPNESS = 1.1  # pixels of the floor's image per pixel of the camera, in the geometric mean of its two directions
LEVELS = 5  # images of the floor, each half as fine as the previous one; beyond the last one it is plain
NO_FLOOR = 255  # the level of rows that do not show the floor's pattern
ZENITH_TONE, HORIZON_WHITE = 0.82, 0.55  # brightness of the sky at the top, and share of white at the horizon
SKY_HEIGHT = 0.6  # [tangent of the elevation] from which on the sky has its darkest tone


class Background:
    """Draws sky and floor for one PinholeCamera; ``patterns``: False leaves both plain.

    colour: that of the floor; rows (height, 4) uint8 RGBA: the colour of each row without pattern.
    """

    def __init__(self, camera: PinholeCamera, ground_colour: Sequence[int], sky_colour: Sequence[int],
                 patterns: bool = True) -> None:
        red, green, blue = ground_colour
        self._camera, self._patterns = camera, patterns
        self.colour: Colour = (red, green, blue)
        self.rows = textures.rgba(self._row_colours(np.array(sky_colour, float)))
        self._plain: Optional[np.ndarray] = None
        self._levels: Tuple[float, np.ndarray] = (math.nan, np.empty(0))

    def _row_colours(self, sky: np.ndarray) -> np.ndarray:
        """Return the colours (height, 3) of the rows without pattern; ``sky`` (3,): its colour."""
        down = self._camera.down[:, None]
        ground = textures.floor_mean(self.colour) if self._patterns else np.array(self.colour, float)
        if not self._patterns:
            return np.where(down >= 0.0, ground, sky)
        up = np.clip(-down / SKY_HEIGHT, 0.0, 1.0)
        horizon = sky + (255.0 - sky) * HORIZON_WHITE
        return np.where(down >= 0.0, ground, horizon + (sky * ZENITH_TONE - horizon) * np.sqrt(up))

    def draw(self, canvas: np.ndarray, pose: CameraPose, floor_from: np.ndarray) -> None:
        """Fill the canvas (height, width, 4) uint8 RGBA; above row floor_from (width,) a column shows no floor."""
        if self._plain is None:
            self._plain = np.repeat(self.rows[:, None], self._camera.width, axis=1)
        np.copyto(canvas, self._plain)
        highest = max(int(floor_from.min()), 0)
        for halved, first, end in self._parts(pose.z):
            first = max(first, highest)
            if first < end:
                columns = np.flatnonzero(floor_from < end)
                self._draw_part(canvas, pose, (first, end, int(columns[0]), int(columns[-1]) + 1), halved)

    def levels(self, height: float) -> np.ndarray:
        """Return which floor image each row shows from ``height`` [m], (height,) uint8; NO_FLOOR: none."""
        if height != self._levels[0]:
            levels = np.full(self._camera.height, NO_FLOOR, np.uint8)
            for halved, first, end in self._parts(height):
                levels[first:end] = halved
            self._levels = height, levels
        return self._levels[1]

    def _parts(self, height: float) -> Iterator[Tuple[int, int, int]]:
        """Yield (how often the floor image is halved, first row, end row) of the parts of the floor, from below."""
        if not self._patterns or height <= 0.0:
            return
        end = self._camera.height
        for halved in range(LEVELS):
            row = self._camera.cy + self._camera.focal * height / self._depth_of(halved, height)
            first = min(max(int(math.ceil(row)), 0), end)
            yield halved, first, end
            end = first

    def _depth_of(self, halved: int, height: float) -> float:
        """Return the depth [m] up to which the floor image that is halved so often is fine enough."""
        scale = 2.0 ** halved * SHARPNESS / textures.FLOOR_RESOLUTION
        depth: float = (scale * self._camera.focal * math.sqrt(height)) ** (2 / 3)
        return depth

    def _draw_part(self, canvas: np.ndarray, pose: CameraPose, part: Tuple[int, int, int, int], halved: int) -> None:
        """Draw the floor in ``part``: first row, end row, first column, end column."""
        camera, (first, end, left, right), depth = self._camera, part, self._depth_of(halved, pose.z)
        aside = max(-camera.right[0], camera.right[-1])
        reach = textures.PERIOD * math.ceil(depth * math.hypot(1.0, aside) / textures.PERIOD + 1.0)
        image = textures.floor(self.colour, halved, reach)
        resolution = textures.FLOOR_RESOLUTION / 2 ** halved
        x, y = (value - textures.PERIOD * round(value / textures.PERIOD) + reach for value in (pose.x, pose.y))
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        # In units of the row's depth, z = focal * height / (row - cy): world = camera + z * (forward + slope * right).
        to_world = np.array([[sin * pose.z, x, cos * pose.z], [-cos * pose.z, y, sin * pose.z], [0.0, 1.0, 0.0]])
        to_slopes = np.array([[1.0, 0.0, left - camera.cx], [0.0, 1.0, first - camera.cy], [0.0, 0.0, camera.focal]])
        to_image = np.array([[resolution, 0.0, -0.5], [0.0, resolution, -0.5], [0.0, 0.0, 1.0]])
        cv2.warpPerspective(image, to_image @ to_world @ to_slopes, (right - left, end - first),
                            dst=canvas[first:end, left:right], flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
                            borderMode=cv2.BORDER_REPLICATE)
