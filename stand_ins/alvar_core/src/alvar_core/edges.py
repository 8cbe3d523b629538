"""Large markers once more at the picture's full size: the outer edges of the black square, found to parts of a pixel.

The alignment (align.py) reads large markers at a fraction of the size, a few samples a cell, and is right to a part of
that.  Here the grey is read across the four sides.  Where it turns from black to white is measured by the area under
it, which noise and blur change little; the homography follows by robust least squares.  All of it works on a batch of
M markers at once, in cells (see align.py) unless px are named.
"""
import numpy as np

from alvar_core import homography

ALONG = np.linspace(-0.92, 0.92, 32)  # places along a side, in parts of half of it; corners are round
ACROSS = np.linspace(-1, 1, 15)  # places across it, in parts of the reach
ENDS = 3  # of them at each end are taken for black and white
REACH, SPREAD = 2.0, 2.0  # px and blurs that are read to each side of the edge
WIDEST = 0.4  # cells: paper may end beyond
ROUNDS = (0.15, 0.0)  # cells: at least so far in each round; the first one may start beside a sharp edge
MIN_STEP = 0.5  # of the median contrast: less is no edge
CUT, LEAST_CUT = 3.0, 0.4  # of the noise, px: what is further off is covered
SOLVED = 4  # times, what is far off counting less each time
MIN_SEEN = 0.6  # share of each side that must be seen
MIN_NOISE = 0.03  # px: rounding, pixels that are no points


class Edges:
    """The outer edges of markers of `cells` cells a side."""

    def __init__(self, cells):
        half = cells / 2
        along, edge = ALONG * half, np.full(len(ALONG), -half)
        points, normals = [], []
        sides = (along, edge, (0, -1)), (-edge, along, (1, 0)), (along, -edge, (0, 1)), (edge, along, (-1, 0))
        for x, y, normal in sides:
            points.append(np.stack([x, y], 1))
            normals.append(np.tile(normal, (len(along), 1)))
        self.points, self.normals = np.concatenate(points), np.concatenate(normals).astype(float)
        x, y = self.points.T
        zero, one = np.zeros_like(x), np.ones_like(x)
        by_x = np.stack([one, x, y, zero, zero, zero, x * x, x * y], 1)  # as in homography.small
        by_y = np.stack([zero, zero, zero, one, x, y, x * y, y * y], 1)
        self.jacobian = by_x * self.normals[:, :1] + by_y * self.normals[:, 1:]

    def refine(self, pyramid, camera, h, sigma):
        """Return (h, information, good) for h (M, 3, 3) and the picture's blur sigma (M,) px.

        information (M, 8, 8): on homography.small changes, noise included; good (M,): whether all sides are seen.
        """
        good = np.ones(len(h), bool)
        for least in ROUNDS:
            across, px = self._spans(h, camera, sigma, least)
            offset, weight = self._offsets(pyramid, camera, h, across)
            step, information, seen = self._solve(offset, weight, px)
            h = h @ homography.small(step)
            h = h / h[:, 2:, 2:]
            good &= seen
        return h, information, good

    def _spans(self, h, camera, sigma, least):
        """How far to read (M, P), cells, and px a cell there, across the edge."""
        ends = [np.stack(camera.to_real(*np.moveaxis(homography.apply(h, self.points + d * self.normals), 2, 0)), -1)
                for d in (-0.2, 0.2)]
        px = np.maximum(np.linalg.norm(ends[1] - ends[0], axis=2) / 0.4, 1e-3)
        return np.minimum(np.maximum((REACH + SPREAD * sigma[:, None]) / px, least), WIDEST), px

    def _offsets(self, pyramid, camera, h, across):
        """How far the edge is beyond the points (M, P), cells, and whether there is one."""
        places = self.points[:, None] + (across[..., None] * ACROSS)[..., None] * self.normals[:, None]
        p = homography.apply(h, places.reshape(len(h), -1, 2)).astype(np.float32)
        grey = pyramid.read(*camera.to_real(p[..., 0], p[..., 1]), np.zeros(len(h), int))
        grey = grey.reshape(across.shape + (len(ACROSS),))
        black, white = grey[..., :ENDS].mean(-1), grey[..., -ENDS:].mean(-1)
        step = white - black
        enough = step > MIN_STEP * np.maximum(np.median(step, 1, keepdims=True), 8.0)
        share = (grey - black[..., None]).mean(-1) / np.where(enough, step, 1.0)
        return across * (1 - 2 * share) * len(ACROSS) / (len(ACROSS) - 1), enough.astype(float)

    def _solve(self, offset, enough, px):
        """Small change of the homography (M, 8), its information (M, 8, 8), and whether all sides are seen (M,)."""
        weight = enough
        for _ in range(SOLVED):
            jw = self.jacobian.T * (weight * px * px)[:, None]
            normal = jw @ self.jacobian
            ridge = (1e-9 * np.trace(normal, axis1=1, axis2=2) + 1e-9)[:, None, None] * np.eye(8)
            step = np.linalg.solve(normal + ridge, jw @ offset[..., None])
            residual = (offset - (self.jacobian @ step)[..., 0]) * px
            noise = np.maximum(1.4826 * np.median(np.abs(residual), 1), MIN_NOISE)[:, None]
            t = residual / np.maximum(CUT * noise, LEAST_CUT)
            weight = enough * np.maximum(1 - t * t, 0) ** 2
        seen = (weight.reshape(len(offset), 4, -1) > 0.2).mean(2).min(1) > MIN_SEEN
        return step[..., 0], normal / noise[..., None] ** 2, seen
