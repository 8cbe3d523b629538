"""Sky and floor, the background of a world."""
from typing import Sequence

import numpy as np

from kinematic_core.worlds.camera import PinholeCamera
from sim_scene import textures
from sim_scene.native import Background
from sim_scene.response import Response

SHARPNESS = 1.1  # pixels of the floor's image per pixel of the camera, in the geometric mean of its two directions
LEVELS = 5  # images of the floor, each half as fine as the previous one; beyond the last one it is plain
ZENITH_TONE, HORIZON_WHITE = 0.82, 0.55  # brightness of the sky at the top, and share of white at the horizon
SKY_HEIGHT = 0.6  # [tangent of the elevation] from which on the sky has its darkest tone


def background(camera: PinholeCamera, ground: Sequence[int], sky: Sequence[int], response: Response,
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
