"""Align a marker with the edges of its cells, whatever the light is.

Across each edge between a black and a white cell, and between the black square and the paper around it, the position of
the step is measured with the black and white next to it. A robust fit then moves the marker. What a shadow's edge
disturbs is an outlier of the fit. Coordinates are in cells as in alignment.py.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Callable

import cv2
import numpy as np

from alvar_core.arrays import Bools, Floats, Image
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds

Model = Callable[[Floats, Floats], Floats]  # (parameters (B, n), points (P, 2) in cells): ideal px (B, P, 2)


@dataclass
class EdgePoints:
    """Points on edges: ``middle`` (P, 2) [cells], ``outward`` (P, 2): the direction from black to white."""

    middle: Floats
    outward: Floats


@dataclass
class EdgeFit:
    """The result of a fit.

    ``parameters`` (n,), their ``covariance`` (n, n); ``error`` [px]: typical residual of the edges; ``seen``: share of
    the points that are edges and agree; ``cost`` [px^2]: sum of the squared residuals, each at most 1.
    """

    parameters: Floats
    covariance: Floats
    error: float
    seen: float
    cost: float


def edge_points(black: Bools, places: Floats) -> EdgePoints:
    """Return the points on the edges of a marker's cells (n, n), bool; ``places`` along each edge, -0.5 to 0.5."""
    n = len(black)
    white = np.pad(~black, 1, constant_values=True).astype(np.int8)
    sideways, down = np.diff(white, axis=1)[1:-1], np.diff(white, axis=0)[:, 1:-1]
    row, column = np.nonzero(sideways)
    upright = np.stack([column - n / 2, row - n / 2 + 0.5], 1), sideways[row, column]
    row, column = np.nonzero(down)
    level = np.stack([column - n / 2 + 0.5, row - n / 2], 1), down[row, column]
    middle, outward = [], []
    for (at, sign), axis in ((upright, 0), (level, 1)):
        along, across = np.zeros(2), np.zeros(2)
        along[1 - axis], across[axis] = 1, 1
        middle.append((at[:, None] + np.asarray(places)[:, None] * along).reshape(-1, 2))
        outward.append(np.repeat(sign[:, None] * across, len(places), 0))
    return EdgePoints(np.concatenate(middle), np.concatenate(outward))


class EdgeAligner:
    """Fits a Model to the edges in an image."""

    ACROSS = np.linspace(-1, 1, 15, dtype=np.float32)

    def __init__(self) -> None:
        self._ends = np.zeros((len(self.ACROSS), 3), np.float32)
        self._ends[:3, 0] = self._ends[-3:, 1] = 1 / 3
        self._ends[:, 2] = 1 / len(self.ACROSS)

    def fit(self, grey: Image, camera: Camera, model: Model, start: Floats, points: EdgePoints, scale: Floats,
            reach: float, steps: int) -> EdgeFit | None:
        """Return the EdgeFit of a model from ``start`` (n,); None if too few edges are seen.

        ``scale`` (n,): small changes of the parameters; ``reach`` [px]: half the width that is read across an edge.
        """
        theta = start.astype(np.float64)
        count = len(theta)
        moves = np.concatenate([np.zeros((1, count)), np.diag(scale)])
        tip = points.middle + 0.05 * points.outward
        normal = np.eye(count)
        error, seen, cost = 0.0, 0.0, 0.0
        for step in range(steps):
            at = model(theta + moves, points.middle)
            across = model(theta[None], tip)[0] - at[0]
            # the gradient of the edge is at a right angle to it in the image
            side = model(theta[None], points.middle + 0.05 * points.outward[:, ::-1] * [1, -1])[0] - at[0]
            direction = np.stack([-side[:, 1], side[:, 0]], 1)
            direction *= np.sign((direction * across).sum(1))[:, None]
            direction /= np.sqrt((direction * direction).sum(1))[:, None] + 1e-12
            width = reach * (1.6 if step == 0 else 1.0)
            offset, good = self._offsets(grey, camera, at[0], direction, width)
            jacobian = np.einsum('bpc,pc->pb', at[1:] - at[0], direction)
            error, weight = self._weights(offset, good, theta, step)
            if weight is None:
                return None
            for _ in range(3):
                weighted = jacobian * weight[:, None]
                normal = jacobian.T @ weighted
                change = np.linalg.solve(normal + 1e-9 * np.eye(count) * np.trace(normal), weighted.T @ offset)
                residual = offset - jacobian @ change
                error, weight = self._weights(residual, good, theta, step)
                if weight is None:
                    return None
            theta = theta + change * scale
            seen = float((weight > 0.1).mean())
            cost = float(np.where(good, np.minimum(residual ** 2, 1.0), 1.0).sum())
        covariance = np.linalg.inv(normal + 1e-9 * np.eye(count) * np.trace(normal)) * max(error, 0.03) ** 2
        return EdgeFit(theta, covariance * np.outer(scale, scale), error, seen, cost)

    def _weights(self, residual: Floats, good: Bools, theta: Floats, step: int) -> tuple[float, Floats | None]:
        if good.sum() < 3 * len(theta):
            return 0.0, None
        size = np.abs(residual)
        error = 1.4826 * float(np.median(size[good]))
        limit = thresholds.EDGE_OUTLIER * max(error, thresholds.MIN_EDGE_OUTLIER / 3)
        return error, good * np.maximum(1 - (size / limit) ** 2, 0) ** 2

    def _offsets(self, grey: Image, camera: Camera, at: Floats, direction: Floats,
                 reach: float) -> tuple[Floats, Bools]:
        """Return how far [px] the edges lie beyond the points, and which are edges."""
        where = at[:, None] + (reach * self.ACROSS)[:, None] * direction[:, None]
        x, y = camera.to_real(where[..., 0], where[..., 1])
        read = cv2.remap(grey, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR,
                         borderMode=cv2.BORDER_REPLICATE).astype(np.float32)
        black, white, mean = (read @ self._ends).T
        step = white - black
        contrast = step / (white + black + thresholds.DARK_GREY)
        good = (contrast > thresholds.MIN_LOCAL_CONTRAST) & (step > thresholds.MIN_LOCAL_STEP)
        inside = (x[:, 0] > 0) & (y[:, 0] > 0) & (x[:, 0] < grey.shape[1] - 1) & (y[:, 0] < grey.shape[0] - 1)
        inside &= (x[:, -1] > 0) & (y[:, -1] > 0) & (x[:, -1] < grey.shape[1] - 1) & (y[:, -1] < grey.shape[0] - 1)
        share = (mean - black) / np.where(good, step, 1.0)
        offset = reach * (1 - 2 * share) * len(self.ACROSS) / (len(self.ACROSS) - 1)
        return offset.astype(np.float64), good & inside


def of_homography(h: Floats) -> Model:
    """Return the Model of small changes (B, 8) of a homography (3, 3), applied before it."""
    def model(theta: Floats, points: Floats) -> Floats:
        return homography.apply(h @ homography.small(theta), points)
    return model


def changed(h: Floats, theta: Floats) -> Floats:
    """Return the homography (3, 3) after small changes (8,)."""
    out: Floats = (h @ homography.small(theta[None]))[0]
    out /= out[2, 2]
    return out
