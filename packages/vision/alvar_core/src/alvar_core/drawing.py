"""Draw markers, and project points of a marker into an image.

Marker frame: origin in the centre of the black square; looking at the marker as drawn: x right, y up, z out of it.
"""
from __future__ import annotations

import numpy as np

from alvar_core import code
from alvar_core.arrays import ArrayLike, Bools, Floats, Image
from alvar_core.camera import Camera

UNIT_CORNERS = np.array([[-0.5, 0.5, 0], [0.5, 0.5, 0], [0.5, -0.5, 0], [-0.5, -0.5, 0]])


def object_corners(size: float) -> Floats:
    """Return the corners (4, 3) in the marker frame, in the unit of ``size``.

    The order is top left, top right, bottom right, bottom left.
    """
    return UNIT_CORNERS * size


def marker_image(value: int | str, side: int, margin: int = code.MARGIN, resolution: int | None = None,
                 strong: bool = False) -> Image:
    """Return a uint8 image (side, side) of a marker's black square, without white around it.

    ``value`` is the id or text, ``side`` [px] the width, ``margin`` [cells] the width of the black border.
    """
    return image_of_cells(code.encode(value, strong=strong, resolution=resolution), side, margin)


def image_of_cells(cells: Bools, side: int, margin: int = code.MARGIN) -> Image:
    """Return the image of data cells (n, n) bool, True is white; see ``marker_image``."""
    count = len(cells) + 2 * margin
    if side < count:
        raise ValueError(f'a marker of {count} cells does not fit in {side} px; at least one pixel per cell is needed')
    white = np.pad(cells, margin).astype(np.uint8) * 255
    edges = np.round(np.arange(count + 1) * side / count).astype(int)
    index = np.repeat(np.arange(count), np.diff(edges))
    return white[np.ix_(index, index)]


def project(camera: Camera, rotation: Floats, position: Floats, points: ArrayLike) -> Floats:
    """Return the real pixels (N, 2) of points (N, 3) [m] in a marker's frame.

    ``rotation`` (3, 3) and ``position`` (3,) [m] are the pose of the marker in the camera's optical frame.
    """
    p = np.asarray(points, float) @ rotation.T + position
    ideal = p[:, :2] / p[:, 2:] * [camera.fx, camera.fy] + [camera.cx, camera.cy]
    return np.stack(camera.to_real(ideal[:, 0], ideal[:, 1]), 1)
