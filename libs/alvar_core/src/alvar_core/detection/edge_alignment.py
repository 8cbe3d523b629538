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

    ``parameters`` (n,), their ``covariance`` (n, n); ``error`` [px]: typical residual of the edges; ``agrees`` (P,):
    which points are edges where the model has them, ``seen``: their share; ``cost`` [px^2]: sum of the squared
    residuals, each at most 1.
    """

    parameters: Floats
    covariance: Floats
    error: float
    agrees: Bools
    cost: float

    @property
    def seen(self) -> float:
        """Return the share of the points that are edges and agree."""
        return float(self.agrees.mean())


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

    def fit(self, grey: Image, camera: Camera, model: Model, starts: Floats, points: EdgePoints, scale: Floats,
            reach: float, steps: int) -> list[EdgeFit | None]:
        """Return the EdgeFit of a model from each of ``starts`` (K, n); None if too few edges are seen.

        ``scale`` (m,): small changes of the first m parameters, the others stay; ``reach`` [px]: half the width that is
        read across an edge.
        """
        theta = starts.astype(np.float64)
        count, free = len(theta), len(scale)
        moves = np.zeros((free + 1, theta.shape[1]))
        moves[1:, :free] = np.diag(scale)
        beside = np.concatenate([points.middle + 0.05 * points.outward,
                                 points.middle + 0.05 * points.outward[:, ::-1] * [1, -1]])
        seen_enough = np.ones(count, bool)
        ridge = 1e-9 * np.eye(free)
        for step in range(steps):
            at = model((theta[:, None] + moves).reshape(-1, theta.shape[1]), points.middle)
            at = at.reshape(count, free + 1, -1, 2)
            here, changes = at[:, 0], at[:, 1:] - at[:, :1]
            across, side = (model(theta, beside).reshape(count, 2, -1, 2) - at[:, :1]).transpose(1, 0, 2, 3)
            # the gradient of the edge is at a right angle to it in the image
            direction = side[..., ::-1] * [-1, 1]
            length = np.sqrt((side * side).sum(2)) + 1e-12
            direction *= (np.sign((direction * across).sum(2)) / length)[..., None]
            offset, good = self._offsets(grey, camera, here, direction, reach * (1.6 if step == 0 else 1.0))
            seen_enough &= good.sum(1) >= 3 * free
            if not seen_enough.any():
                return [None] * count
            jacobian = (changes * direction[:, None]).sum(3)
            error, weight = _weights(offset, good)
            for _ in range(3):
                weighted = jacobian * weight[:, None]
                normal = weighted @ jacobian.transpose(0, 2, 1)
                normal += ridge * (np.trace(normal, axis1=1, axis2=2) + 1e-9)[:, None, None]
                change = np.linalg.solve(normal, weighted @ offset[..., None])
                moved = (change.transpose(0, 2, 1) @ jacobian)[:, 0]
                residual = offset - moved
                error, weight = _weights(residual, good)
            theta[:, :free] += change[..., 0] * scale
            if step and np.abs(moved[seen_enough]).max() < thresholds.EDGES_SETTLED:
                break
        covariance = np.linalg.inv(normal) * (np.maximum(error, 0.03) ** 2)[:, None, None] * np.outer(scale, scale)
        agrees = good & (weight > 0.1)
        cost = np.where(good, np.minimum(residual ** 2, 1.0), 1.0).sum(1)
        return [EdgeFit(theta[k], covariance[k], float(error[k]), agrees[k], float(cost[k])) if seen_enough[k]
                else None for k in range(count)]

    def _offsets(self, grey: Image, camera: Camera, at: Floats, direction: Floats,
                 reach: float) -> tuple[Floats, Bools]:
        """Return how far [px] the edges lie beyond the points, and which are edges."""
        where = at[..., None, :] + (reach * self.ACROSS)[:, None] * direction[..., None, :]
        x, y = (each.astype(np.float32) for each in camera.to_real(where[..., 0], where[..., 1]))
        flat = len(x), -1
        read = cv2.remap(grey, x.reshape(flat), y.reshape(flat), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        black, white, mean = np.moveaxis(read.reshape(x.shape).astype(np.float32) @ self._ends, -1, 0)
        step = white - black
        contrast = step / (white + black + thresholds.DARK_GREY)
        good = (contrast > thresholds.MIN_LOCAL_CONTRAST) & (step > thresholds.MIN_LOCAL_STEP)
        ends = slice(None, None, len(self.ACROSS) - 1)
        for place, size in ((x[..., ends], grey.shape[1]), (y[..., ends], grey.shape[0])):
            good &= ((place > 0) & (place < size - 1)).all(-1)
        share = (mean - black) / np.where(good, step, 1.0)
        offset = reach * (1 - 2 * share) * len(self.ACROSS) / (len(self.ACROSS) - 1)
        return np.where(good, offset, 0.0).astype(np.float64), good


def _weights(residual: Floats, good: Bools) -> tuple[Floats, Floats]:
    """Return the typical size (K,) [px] of residuals (K, P), and their weights: what is far off does not count."""
    size = np.where(good, np.abs(residual), np.inf)
    middle = np.minimum(good.sum(1) // 2, size.shape[1] - 1)
    if len(size) == 1:
        error = 1.4826 * np.partition(size, middle[0], 1)[:, middle[0]]
    else:
        error = 1.4826 * np.sort(size, 1)[np.arange(len(size)), middle]
    size /= (thresholds.EDGE_OUTLIER * np.maximum(error, thresholds.MIN_EDGE_OUTLIER / 3))[:, None]
    np.minimum(size, 1, out=size)
    return error, (1 - size * size) ** 2


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
