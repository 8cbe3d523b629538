"""Large markers once more at the picture's full size: the outer edges of the black square, found to parts of a pixel.

The alignment (align.py) reads large markers at a fraction of the size, a few samples a cell, and is right to a part of
that.  Here the grey is read across the four sides.  Where it turns from black to white is measured by the area under
it, which noise and blur change little; a line through each side follows by robust least squares, and the corners are
where they meet.  All of it works on a batch of M markers at once, in cells (see align.py) unless px are named; sides
and corners are counted from the upper one and from its left end, clockwise.
"""
import numpy as np

from alvar_core.detection import homography

ALONG = np.linspace(-0.9, 0.9, 22)  # places along a side, in parts of half of it; corners are round
ACROSS = np.linspace(-1, 1, 13)  # places across it, in parts of the reach
ENDS = 3  # of them at each end are taken for black and white
REACH, SPREAD = 2.0, 2.0  # px and blurs that are read to each side of the edge
WIDEST = 0.4  # cells: paper may end beyond
START = 0.15  # cells that the edge may be off at first; where that is beyond the reach it is read twice
MIN_STEP = 0.5  # of the median contrast: less is no edge
CUT, LEAST_CUT = 3.0, 0.4  # of the noise, px: what is further off is covered
FITS = 3  # what is far off counts less each time
MIN_SEEN = 0.6  # share of each side that must be seen
MIN_NOISE = 0.03  # px: rounding, pixels that are no points
SHARES = np.zeros((len(ACROSS), 3), np.float32)  # of the greys across the edge: means of black, of white, of all
SHARES[:ENDS, 0] = SHARES[-ENDS:, 1] = 1 / ENDS
SHARES[:, 2] = 1 / len(ACROSS)


class Edges:
    """The outer edges of markers of `cells` cells a side."""

    def __init__(self, cells):
        self.half = half = cells / 2
        self.square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self.t = ALONG * half
        self.normals = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]], float)
        along = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]], float)
        points = half * self.normals[:, None] + self.t[:, None] * along[:, None]  # (4, K, 2)
        self.points = np.concatenate([points, np.ones((4, len(ALONG), 1))], 2).reshape(-1, 3).T
        self.outward = np.concatenate([self.normals, np.zeros((4, 1))], 1).T
        self.corners = np.concatenate([self.square, np.ones((4, 1))], 1).T
        ones = np.ones_like(self.t)
        self.powers = np.stack([ones, self.t, self.t ** 2], 1)
        # Corners (x, y of each: rows) move by the offsets and rises (columns) of the side that begins there and the
        # one that ends there.
        self.corners_of_lines = np.zeros((8, 8))
        for corner in range(4):
            for side, end in ((corner, -half), (corner - 1, half)):
                for power in (0, 1):
                    self.corners_of_lines[2 * corner:2 * corner + 2, 2 * (side % 4) + power] += \
                        self.normals[side] * end ** power

    def refine(self, pyramid, camera, h, sigma):
        """Return (corners, covariance, good) of markers at h (M, 3, 3), for a picture's blur sigma (M,) px.

        corners (M, 4, 2) ideal px; covariance (M, 8, 8): of the corners, px^2; good (M,): whether all sides are seen.
        """
        corners = homography.apply(h, self.square)
        side = corners[:, [1, 2, 3, 0]] - corners
        length = np.sqrt((side * side).sum(2))
        px = (length[:, [1, 2, 3, 0]] + length[:, [3, 0, 1, 2]]) / (4 * self.half)  # a cell, across the sides
        across = np.minimum((REACH + SPREAD * sigma[:, None]) / px, WIDEST)
        good = np.ones(len(corners), bool)
        if (across < START).any():
            corners, _, good = self._once(pyramid, camera, h, np.maximum(across, START), px)
            h = homography.from_square(corners, self.half)
        corners, covariance, seen = self._once(pyramid, camera, h, across, px)
        return corners, covariance, good & seen

    def _once(self, pyramid, camera, h, across, px):
        offset, enough = self._offsets(pyramid, camera, h, across)
        lines, spread, seen = self._lines(offset, enough, px)
        moved = self.square + (lines.reshape(-1, 8) @ self.corners_of_lines.T).reshape(-1, 4, 2)
        blocks = np.zeros((len(h), 4, 2, 4, 2))
        blocks[:, range(4), :, range(4)] = spread.transpose(1, 0, 2, 3)
        to_px = self._px_of_corners(h) @ self.corners_of_lines
        covariance = to_px @ blocks.reshape(-1, 8, 8) @ to_px.transpose(0, 2, 1)
        return homography.apply(h, moved), covariance, seen

    def _px_of_corners(self, h):
        """(M, 8, 8): derivative of the corners, ideal px, by themselves in cells."""
        p = (h @ self.corners).transpose(0, 2, 1)
        w = p[:, :, 2:, None]
        out = np.zeros((len(h), 4, 2, 4, 2))
        each = (h[:, None, :2, :2] - (p[:, :, :2, None] / w) * h[:, None, 2:, :2]) / w
        out[:, range(4), :, range(4)] = each.transpose(1, 0, 2, 3)
        return out.reshape(-1, 8, 8)

    def _offsets(self, pyramid, camera, h, across):
        """How far the edges are beyond the points (M, 4, K), cells, and whether there is one."""
        count = len(h)
        reach = (h @ self.outward)[..., None] * (across[..., None] * ACROSS)[:, None]  # (M, 3, 4, S)
        p = (h @ self.points).reshape(count, 3, 4, -1, 1).astype(np.float32) + reach[:, :, :, None].astype(np.float32)
        x, y, w = p.reshape(count, 3, -1).transpose(1, 0, 2)
        grey = pyramid.read(*camera.to_real(x / w, y / w), np.zeros(count, int)).reshape(-1, len(ACROSS))
        black, white, mean = (grey @ SHARES).T.reshape(3, count, -1)
        step = white - black
        enough = step > MIN_STEP * np.maximum(_median(step), 8.0)[:, None]
        share = ((mean - black) / np.where(enough, step, 1.0)).reshape(count, 4, -1)
        offset = across[..., None] * (1 - 2 * share) * (len(ACROSS) / (len(ACROSS) - 1))
        return offset, enough.reshape(share.shape).astype(float)

    def _lines(self, offset, enough, px):
        """Offset and rise (M, 4, 2) of each side, their covariance (M, 4, 2, 2), whether all sides are seen (M,)."""
        shape, t = offset.shape[:2], self.t
        offset, enough, px = offset.reshape(-1, len(t)), enough.reshape(-1, len(t)), px.reshape(-1, 1)
        weight = enough
        for _ in range(FITS):
            s0, s1, s2 = (weight @ self.powers).T[:, :, None]
            y0, y1 = ((weight * offset) @ self.powers[:, :2]).T[:, :, None]
            det = np.maximum(s0 * s2 - s1 * s1, 1e-9)
            middle, rise = (y0 * s2 - y1 * s1) / det, (s0 * y1 - s1 * y0) / det
            residual = np.abs(offset - middle - rise * t) * px
            noise = np.maximum(1.4826 * _median(residual.reshape(shape[0], -1)), MIN_NOISE).repeat(4)[:, None]
            part = residual / np.maximum(CUT * noise, LEAST_CUT)
            weight = enough * np.maximum(1 - part * part, 0) ** 2
        seen = (weight > 0.2).sum(1).reshape(shape).min(1) > MIN_SEEN * len(t)
        lines, spread = np.hstack([middle, rise]), np.hstack([s2, -s1, -s1, s0])
        spread *= (noise / px) ** 2 / det
        return lines.reshape(*shape, 2), spread.reshape(*shape, 2, 2), seen


def _median(values):
    """Median of the rows of (M, P), nearly: without numpy's checks."""
    middle = values.shape[1] // 2
    return np.partition(values, middle, 1)[:, middle]
