"""Homographies in batches of M: from four corners, applied to points, small changes."""
import numpy as np

_SMALL = np.zeros((8, 9))  # which number of a matrix each small change is
_SMALL[range(8), [2, 0, 1, 5, 3, 4, 6, 7]] = 1, 1, 1, 1, 1, 1, -1, -1


def from_square(quads, half):
    """(M, 3, 3) from the square [-half, half]^2 (y down) to quads (M, 4, 2): top left, then clockwise as seen."""
    q = np.asarray(quads, np.float64)
    p0, p1, p2, p3 = q[:, 0], q[:, 1], q[:, 2], q[:, 3]
    d1, d2, d3 = p1 - p2, p3 - p2, p0 - p1 + p2 - p3
    den = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
    den = np.where(np.abs(den) < 1e-12, 1e-12, den)
    g = (d3[:, 0] * d2[:, 1] - d2[:, 0] * d3[:, 1]) / den
    h = (d1[:, 0] * d3[:, 1] - d3[:, 0] * d1[:, 1]) / den
    m = np.empty((len(q), 3, 3))
    m[:, :2, 0] = p1 - p0 + g[:, None] * p1
    m[:, :2, 1] = p3 - p0 + h[:, None] * p3
    m[:, :2, 2] = p0
    m[:, 2, 0], m[:, 2, 1], m[:, 2, 2] = g, h, 1
    unit = np.array([[0.5 / half, 0, 0.5], [0, 0.5 / half, 0.5], [0, 0, 1]])
    m = m @ unit
    return m / m[:, 2:, 2:]


def apply(h, points):
    """Points (P, 2) or (M, P, 2) through h (M, 3, 3): (M, P, 2)."""
    points = np.asarray(points, np.float64)
    p = points @ np.swapaxes(h[:, :, :2], 1, 2) + h[:, None, :, 2]
    return p[..., :2] / p[..., 2:]


def small(d):
    """(M, 3, 3) from small changes (M, 8): identity plus [[d1, d2, d0], [d4, d5, d3], [-d6, -d7, 0]]."""
    return (d @ _SMALL).reshape(-1, 3, 3) + np.eye(3)


def area(quads):
    """Signed area (M,) of quads (M, 4, 2): positive for top left, top right, bottom right, bottom left with y down."""
    d, e = quads[..., 0, :] - quads[..., 2, :], quads[..., 1, :] - quads[..., 3, :]
    return 0.5 * (d[..., 0] * e[..., 1] - d[..., 1] * e[..., 0])
