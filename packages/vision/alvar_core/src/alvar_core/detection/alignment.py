"""Photometric alignment: fit the blurred drawing of a marker to the image until the greys agree.

All marker coordinates here are in cells: x right, y down as the marker is drawn, origin in its centre. A homography H
maps them to ideal pixels (camera.py). All functions work on a batch of M markers, with P samples of each.
"""
from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Sequence

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats, Integers
from alvar_core.camera import Camera
from alvar_core.detection import thresholds
from alvar_core.detection.pyramid import Pyramid

# Weight of a sample by its distance [cells] outside the edge: 1 inside the marker, less on the paper
DISTANCES, WEIGHTS = [0, 0.05, 0.25, 0.5], [1, 0.7, 0.7, 0.25]


class Covariance(NamedTuple):
    """The blur of M markers as covariance [cells^2], each field (M,)."""

    xx: Floats
    yy: Floats
    xy: Floats

    def take(self, keep: Sequence[int] | Integers) -> Covariance:
        """Return the covariance of some of the markers."""
        return Covariance(self.xx[keep], self.yy[keep], self.xy[keep])


def pixels_per_cell(h: Floats) -> Floats:
    """Return the derivative (M, 2, 2) of ideal pixels by cells in the centre of each marker."""
    w = h[:, 2, 2][:, None, None]
    centre = h[:, :2, 2:] / w
    return (h[:, :2, :2] - centre * h[:, 2:3, :2]) / w


class Grid:
    """A square grid of sample points on a marker with ``cells`` cells per side, and around it.

    It has ``per_cell`` samples per cell in each direction, and ``inset`` samples beyond each edge. ``count``: samples
    per row; ``line`` (count,) [cells]: their x or y; ``x``, ``y`` (P,) [cells]: all points; ``reach`` (P,) [cells]:
    distance outside the edge, negative inside.
    """

    def __init__(self, cells: int, per_cell: int, inset: int = 2) -> None:
        half = cells / 2 + inset / per_cell
        self.cells = cells
        self.count = count = cells * per_cell + 2 * inset
        self.line = ((np.arange(count) + 0.5) / count * 2 - 1) * half
        self.x = np.tile(self.line, count).astype(np.float32)
        self.y = np.repeat(self.line, count).astype(np.float32)
        self.reach = np.maximum(np.abs(self.x), np.abs(self.y)) - cells / 2


def covariance(h: Floats, blur_variance: Floats) -> Covariance:
    """Return the blur of the image, given as variance (M,) [px^2], as a covariance in cells."""
    p = pixels_per_cell(h)
    square = p.transpose(0, 2, 1) @ p  # the inverse of this, in closed form
    xx, yy, xy = square[:, 0, 0], square[:, 1, 1], square[:, 0, 1]
    scale = blur_variance / (xx * yy - xy * xy)
    return Covariance(yy * scale, xx * scale, -xy * scale)


@dataclass
class Alignment:
    """M markers after a step of the alignment.

    * ``h`` (M, 3, 3): homography from cells to ideal px
    * ``blur`` (M,): variance [px^2 at the level]; ``level`` (M,): that of the Pyramid
    * ``values`` (M, P) [greys]: the samples; ``template`` (M, P): the drawing, 0 black to 1 white
    * ``model`` (M, P) [greys]: the values that the drawing predicts; ``gain`` (M, P) [greys]: white minus black;
      ``dark`` (M, P) [greys]: black; ``contrast`` (M,) [greys]: mean of the gain
    * ``weights`` (M, P), 0 to 1: low where something covers the marker
    * ``noise`` (M,) [greys]: standard deviation of values minus model
    * ``normal`` (M, 15, 15): normal equations of the parameters
    * ``moved`` (M,) [cells]: largest motion of a corner by any one parameter in this step
    """

    h: Floats
    blur: Floats
    level: Integers
    values: Floats
    template: Floats
    model: Floats
    gain: Floats
    dark: Floats
    contrast: Floats
    weights: Floats
    noise: Floats
    normal: Floats
    moved: Floats

    def take(self, keep: Sequence[int] | Integers) -> Alignment:
        """Return the alignment of some of the markers, given by indices in ascending order."""
        if len(keep) == len(self.h):
            return self
        return replace(self, **{field.name: getattr(self, field.name)[keep] for field in fields(self)})

    def clipped(self, which: Sequence[int]) -> Floats:
        """Return the values (K, P) of some markers, limited to a range slightly wider than black to white."""
        gain, dark = self.gain[which], self.dark[which]
        spare = thresholds.CONTRAST_SPARE * gain
        return np.clip(self.values[which], dark - spare, dark + gain + spare)


class Aligner:
    """Batch Gauss-Newton over homography, light (gain and offset, with gradients) and blur, robust against occlusion.

    ``inner``: use only the outermost ``inner`` cells of the black square (None: all of it). ``fixed_weight`` (P,) are
    weights of the samples, ``share`` the same with sum 1.
    """

    def __init__(self, cells: int, per_cell: int, inner: float | None = None) -> None:
        self.grid = g = Grid(cells, per_cell)
        self.fixed_weight = np.interp(g.reach, DISTANCES, WEIGHTS).astype(np.float32)
        if inner is not None:
            self.fixed_weight *= g.reach > -inner
        self.share = self.fixed_weight / self.fixed_weight.sum()
        self.steps = native.steps.Aligner(cells=cells, line=g.line, weight=self.fixed_weight)

    def run(self, pyramid: Pyramid, camera: Camera, h: Floats, black: Bools, blur: Floats, level: Integers,
            steps: int, redraw: Sequence[int] = (1,)) -> Alignment:
        """Return the Alignment after some steps.

        Start values are ``h`` (M, 3, 3), ``black`` cells (M, n, n), the variance ``blur`` (M,) [px^2 at the level] and
        ``level`` (M,). Before the steps in ``redraw``, counted from 0, the drawings are computed again with the blur
        and perspective found so far.
        """
        return Alignment(**self.steps.run(**pyramid.memory, lens=camera.lens, h=h, black=black, blur=blur, level=level,
                                          steps=steps, redraw=redraw, limit=native.limit))

    def values(self, pyramid: Pyramid, camera: Camera, h: Floats, level: Integers) -> Floats:
        """Return the greys (M, P) at the samples of markers at ``h`` (M, 3, 3), of ``level`` (M,) of the Pyramid."""
        found: Floats = self.steps.sample(**pyramid.memory, lens=camera.lens, h=h, level=level)
        return found
