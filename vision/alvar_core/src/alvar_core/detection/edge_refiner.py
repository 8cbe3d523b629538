"""Measure the outer edges of the black square of large markers, in the full-size image, with subpixel accuracy.

The alignment (alignment.py) reads large markers in a reduced image, with a few samples per cell, which limits its
accuracy. Here the grey is read across the four sides. The position of the step from black to white is computed from
the area under the grey values, which noise and blur change little. A robust least-squares fit gives the line of each
side, and the corners are the intersections. All functions work on a batch of M markers, in cells (see alignment.py)
unless px are stated; sides are counted clockwise from the upper one, corners from its left end.
"""
from __future__ import annotations

import ctypes

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds
from alvar_core.detection.pyramid import Pyramid

ALONG = np.linspace(-0.9, 0.9, 22)  # positions along a side, as shares of its half; without the blurred corners
ACROSS = np.linspace(-1, 1, 13)  # positions across it, as shares of the reach
ENDS = slice(0, 3), slice(-3, None)  # those that give black and white
SHARES = np.zeros((len(ACROSS), 3), np.float32)  # weights for the means of black, of white, and of all greys
SHARES[ENDS[0], 0] = SHARES[ENDS[1], 1] = 1 / 3
SHARES[:, 2] = 1 / len(ACROSS)


class EdgeRefiner:
    """Measures the outer edges of markers with ``cells`` cells per side."""

    def __init__(self, cells: int) -> None:
        self._half = half = cells / 2
        self._square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self._t = ALONG * half
        self._normals = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]], float)
        along = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]], float)
        points = half * self._normals[:, None] + self._t[:, None] * along[:, None]  # (4, K, 2)
        self._points = np.concatenate([points, np.ones((4, len(ALONG), 1))], 2).reshape(-1, 3).T
        self._outward = np.concatenate([self._normals, np.zeros((4, 1))], 1).T
        self._corners = np.concatenate([self._square, np.ones((4, 1))], 1).T
        curve = ALONG ** 2 - (ALONG ** 2).mean()
        self._bow_basis = np.stack([np.ones_like(ALONG), ALONG, curve])  # at right angles to each other
        self._powers = np.stack([np.ones_like(self._t), self._t, self._t ** 2], 1)
        self._corners_of_lines = self._moves_of_corners()

    def _moves_of_corners(self) -> Floats:
        """Return the derivative (8, 8) of the corners (rows: x, y of each) by offset and slope of the sides (columns).

        A corner depends on the side that begins and on the one that ends there.
        """
        moves = np.zeros((8, 8))
        for corner in range(4):
            for side, end in ((corner, -self._half), (corner - 1, self._half)):
                for power in (0, 1):
                    moves[2 * corner:2 * corner + 2, 2 * (side % 4) + power] += self._normals[side] * end ** power
        return moves

    def refine(self, pyramid: Pyramid, camera: Camera, h: Floats, sigma: Floats) -> tuple[Floats, Floats, Bools]:
        """Return (corners, covariance, good) of markers at ``h`` (M, 3, 3); ``sigma`` (M,) [px] is the image's blur.

        ``corners`` (M, 4, 2) [ideal px], their ``covariance`` (M, 8, 8) [px^2], ``good`` (M,): all sides are visible.
        """
        corners = homography.apply(h, self._square)
        side = corners[:, [1, 2, 3, 0]] - corners
        length = np.sqrt((side * side).sum(2))
        px = (length[:, [1, 2, 3, 0]] + length[:, [3, 0, 1, 2]]) / (4 * self._half)  # per cell, across the sides
        reach = (thresholds.EDGE_REACH + thresholds.EDGE_BLURS * sigma[:, None]) / px
        across = np.minimum(reach, thresholds.MAX_EDGE_REACH)
        good = np.ones(len(corners), bool)
        if (across < thresholds.EDGE_START).any():
            corners, _, good = self._once(pyramid, camera, h, np.maximum(across, thresholds.EDGE_START), px)
            h = homography.from_square(corners, self._half)
        corners, covariance, seen = self._once(pyramid, camera, h, across, px)
        return corners, covariance, good & seen

    def bow(self, pyramid: Pyramid, camera: Camera, corners: Floats) -> Floats:
        """Return the height [px] of the second largest bow of a side, (M,), by corners (M, 4, 2) [ideal px].

        Bent paper makes bows of at least two sides, something that covers a part of one, or a crease, makes one: if the
        largest is much larger, it counts by thresholds.BOW_OF_ONE. A bow that noise explains counts 0.
        """
        compiled = native.library_for(camera)
        if compiled:
            return self._bow_compiled(*compiled, pyramid, corners)
        h = homography.from_square(corners, self._half)
        px = np.sqrt(homography.area(corners))[:, None] / (2 * self._half)
        across = np.minimum(thresholds.BOW_REACH / px, thresholds.MAX_EDGE_REACH).repeat(4, 1)
        offset, enough = self._offsets(pyramid, camera, h, across)
        basis, squares = self._bow_basis, np.maximum(enough @ self._bow_basis.T ** 2, 1e-9)
        shares = (enough * offset) @ basis.T / squares  # (M, 4, 3): of mean, slope and bow
        residual = enough * (offset - shares @ basis)
        noise = 1.4826 * _median(np.abs(residual).reshape(len(h), -1))[:, None]
        height, error = np.abs(shares[..., 2]), noise / np.sqrt(squares[..., 2])
        bows = np.sort(np.where(height > thresholds.BOW_OVER_NOISE * error, height, 0.0) * px, 1)
        bow: Floats = np.maximum(bows[:, -2], thresholds.BOW_OF_ONE * bows[:, -1])
        return bow

    def _bow_compiled(self, library: ctypes.CDLL, lens: Floats, pyramid: Pyramid, corners: Floats) -> Floats:
        """Do the same as ``bow`` with the compiled step of native/corners.cpp."""
        corners, bows, limits = np.ascontiguousarray(corners, np.float64), np.empty(len(corners)), compiled_limits()
        library.alvar_bows(*native.image(pyramid.full), native.address(lens), len(corners), round(2 * self._half),
                           native.address(corners), native.address(limits), native.address(bows))
        return bows

    def _once(self, pyramid: Pyramid, camera: Camera, h: Floats, across: Floats,
              px: Floats) -> tuple[Floats, Floats, Bools]:
        offset, enough = self._offsets(pyramid, camera, h, across)
        lines, spread, seen = self._lines(offset, enough, px)
        moved = self._square + (lines.reshape(-1, 8) @ self._corners_of_lines.T).reshape(-1, 4, 2)
        blocks = np.zeros((len(h), 4, 2, 4, 2))
        blocks[:, range(4), :, range(4)] = spread.transpose(1, 0, 2, 3)
        to_px = self._px_of_corners(h) @ self._corners_of_lines
        covariance = to_px @ blocks.reshape(-1, 8, 8) @ to_px.transpose(0, 2, 1)
        return homography.apply(h, moved), covariance, seen

    def _px_of_corners(self, h: Floats) -> Floats:
        """Return the derivative (M, 8, 8) of the corners [ideal px] by the same corners in cells."""
        p = (h @ self._corners).transpose(0, 2, 1)
        w = p[:, :, 2:, None]
        out = np.zeros((len(h), 4, 2, 4, 2))
        each = (h[:, None, :2, :2] - (p[:, :, :2, None] / w) * h[:, None, 2:, :2]) / w
        out[:, range(4), :, range(4)] = each.transpose(1, 0, 2, 3)
        return out.reshape(-1, 8, 8)

    def _offsets(self, pyramid: Pyramid, camera: Camera, h: Floats, across: Floats) -> tuple[Floats, Floats]:
        """Return how far [cells] the edges lie outside the points (M, 4, K), and whether there is one (0 or 1)."""
        count = len(h)
        reach = (h @ self._outward)[..., None] * (across[..., None] * ACROSS)[:, None]  # (M, 3, 4, S)
        p = (h @ self._points).reshape(count, 3, 4, -1, 1).astype(np.float32) + reach[:, :, :, None].astype(np.float32)
        x, y, w = p.reshape(count, 3, -1).transpose(1, 0, 2)
        grey = pyramid.read(*camera.to_real(x / w, y / w), np.zeros(count, int)).reshape(-1, len(ACROSS))
        black, white, mean = (grey @ SHARES).T.reshape(3, count, -1)
        step = white - black
        contrast = np.maximum(_median(step), thresholds.MIN_EDGE_CONTRAST)
        enough = step > thresholds.MIN_EDGE_STEP * contrast[:, None]
        share = ((mean - black) / np.where(enough, step, 1.0)).reshape(count, 4, -1)
        offset = across[..., None] * (1 - 2 * share) * (len(ACROSS) / (len(ACROSS) - 1))
        return offset, enough.reshape(share.shape).astype(float)

    def _lines(self, offset: Floats, enough: Floats, px: Floats) -> tuple[Floats, Floats, Bools]:
        """Return offset and slope (M, 4, 2) of each side, their covariance (M, 4, 2, 2), and whether all are visible.

        The last result is (M,).
        """
        markers, sides, places = offset.shape
        offset, enough, px = offset.reshape(-1, places), enough.reshape(-1, places), px.reshape(-1, 1)
        weight = enough
        for _ in range(thresholds.EDGE_FITS):
            s0, s1, s2 = (weight @ self._powers).T[:, :, None]
            y0, y1 = ((weight * offset) @ self._powers[:, :2]).T[:, :, None]
            det = np.maximum(s0 * s2 - s1 * s1, 1e-9)
            middle, rise = (y0 * s2 - y1 * s1) / det, (s0 * y1 - s1 * y0) / det
            residual = np.abs(offset - middle - rise * self._t) * px
            noise = np.maximum(1.4826 * _median(residual.reshape(markers, -1)), thresholds.MIN_EDGE_NOISE)
            noise = noise.repeat(4)[:, None]
            part = residual / np.maximum(thresholds.EDGE_OUTLIER * noise, thresholds.MIN_EDGE_OUTLIER)
            weight = enough * np.maximum(1 - part * part, 0) ** 2
        counted = (weight > 0.2).sum(1).reshape(markers, sides)
        seen = counted.min(1) > thresholds.MIN_EDGE_SEEN * places
        lines, spread = np.hstack([middle, rise]), np.hstack([s2, -s1, -s1, s0])
        spread *= (noise / px) ** 2 / det
        return lines.reshape(markers, sides, 2), spread.reshape(markers, sides, 2, 2), seen


def compiled_limits() -> Floats:
    """Return the thresholds of edges that native/corners.cpp needs."""
    return np.array([
        thresholds.EDGE_REACH, thresholds.EDGE_BLURS, thresholds.MAX_EDGE_REACH, thresholds.EDGE_START,
        thresholds.MIN_EDGE_STEP, thresholds.MIN_EDGE_CONTRAST, thresholds.EDGE_FITS, thresholds.EDGE_OUTLIER,
        thresholds.MIN_EDGE_OUTLIER, thresholds.MIN_EDGE_NOISE, thresholds.MIN_EDGE_SEEN, thresholds.BOW_REACH,
        thresholds.BOW_OVER_NOISE, thresholds.BOW_OF_ONE])


def _median(values: Floats) -> Floats:
    """Return an approximate median of the rows of (M, P), without numpy's checks."""
    middle = values.shape[1] // 2
    return np.partition(values, middle, 1)[:, middle]
