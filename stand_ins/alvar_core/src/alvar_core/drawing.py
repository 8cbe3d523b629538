"""Drawn markers, and where points of a marker appear in an image."""
import numpy as np

from alvar_core import code

UNIT_CORNERS = np.array([[-0.5, 0.5, 0], [0.5, 0.5, 0], [0.5, -0.5, 0], [-0.5, -0.5, 0]])


def object_corners(size):
    """(4, 3) corners in the marker frame: top left, top right, bottom right, bottom left."""
    return UNIT_CORNERS * size


def marker_picture(value, side, margin=2, resolution=None, strong=False):
    """uint8 picture (side, side) of a marker's black square, no white around; value: id or text; side in px."""
    return picture_of_cells(code.encode(value, strong=strong, resolution=resolution), side, margin)


def picture_of_cells(cells, side, margin=2):
    """As marker_picture(), of data cells (n, n), true is white."""
    count = len(cells) + 2 * margin
    if side < count:
        raise ValueError(f'a marker of {count} cells does not fit in {side} px; at least one pixel a cell is needed')
    white = np.pad(cells, margin).astype(np.uint8) * 255
    edges = np.round(np.arange(count + 1) * side / count).astype(int)
    index = np.repeat(np.arange(count), np.diff(edges))
    return white[np.ix_(index, index)]


def project(camera, rotation, position, points):
    """Real pixels (N, 2) of marker points (N, 3) in metres."""
    p = np.asarray(points, float) @ rotation.T + position
    ideal = p[:, :2] / p[:, 2:] * [camera.fx, camera.fy] + [camera.cx, camera.cy]
    return np.stack(camera.to_real(ideal[:, 0], ideal[:, 1]), 1)
