"""Photometric alignment: fit the blurred drawing of a marker to the image until the greys agree.

All marker coordinates here are in cells: x right, y down as the marker is drawn, origin in its centre. A homography H
maps them to ideal pixels (camera.py). All functions work on a batch of M markers, with P samples of each.
"""
from __future__ import annotations

import ctypes
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, Sequence

import numpy as np

from alvar_core import native
from alvar_core.arrays import Bools, Floats, Integers
from alvar_core.camera import Camera
from alvar_core.detection import homography, thresholds
from alvar_core.detection.pyramid import Pyramid

# tanh(a z + b z^3 + c z^5) is 2 F(z) - 1 for the normal distribution F, to within 4e-5 (the form is that of Page, 1977)
NORMAL_STEP = np.array([0.7977178, 0.03679826, -0.000315808], np.float32)
# Weight of a sample by its distance [cells] outside the edge: 1 inside the marker, less on the paper
DISTANCES, WEIGHTS = [0, 0.05, 0.25, 0.5], [1, 0.7, 0.7, 0.25]
HOMOGRAPHY, WHITE, BLACK, BLUR = slice(0, 8), slice(8, 11), slice(11, 14), 14  # the 15 parameters of an alignment
PARAMETERS = 15


class Covariance(NamedTuple):
    """The blur of M markers as covariance [cells^2], each field (M,)."""

    xx: Floats
    yy: Floats
    xy: Floats

    def take(self, keep: Sequence[int] | Integers) -> Covariance:
        """Return the covariance of some of the markers."""
        return Covariance(self.xx[keep], self.yy[keep], self.xy[keep])


class Drawing(NamedTuple):
    """Blurred drawings of M markers (M, P), 0 black to 1 white, and their derivatives by x, y and blur variance."""

    template: Floats
    by_x: Floats
    by_y: Floats
    by_blur: Floats

    def take(self, keep: Integers) -> Drawing:
        """Return the drawings of some of the markers."""
        return Drawing(*(part[keep] for part in self))


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
        self._to_edges = (self.line[:, None] - (np.arange(cells + 1) - cells / 2)).astype(np.float32)
        self._homogeneous = np.stack([self.x, self.y, np.ones_like(self.x)])

    def places(self, h: Floats, camera: Camera) -> tuple[Floats, Floats]:
        """Return the real pixels x, y of the sample points, each (M, P)."""
        p = h.astype(np.float32) @ self._homogeneous
        p[:, :2] /= p[:, 2:]
        return camera.to_real(p[:, 0], p[:, 1])

    def profiles(self, variance: Floats) -> Floats:
        """Return how much each column of cells covers each column of samples, and the first two derivatives of that.

        The result is (M, 3, count, cells); ``variance`` (M,) [cells^2] is that of the blur.
        """
        s = (1 / np.sqrt(variance)).astype(np.float32)[:, None, None]
        z = self._to_edges * s
        zz = np.minimum(z * z, np.float32(30))
        a, b, c = NORMAL_STEP
        steps = np.empty((len(s), 3, self.count, self.cells + 1), np.float32)
        np.tanh(z * (a + zz * (b + zz * c)), out=steps[:, 0])
        steps[:, 0] *= 0.5
        density = np.exp(-0.5 * zz)
        density *= s * np.float32(0.3989423)
        steps[:, 1] = density
        steps[:, 2] = density * z * -s
        return steps[..., :-1] - steps[..., 1:]


def covariance(h: Floats, blur_variance: Floats) -> Covariance:
    """Return the blur of the image, given as variance (M,) [px^2], as a covariance in cells."""
    p = pixels_per_cell(h)
    square = p.transpose(0, 2, 1) @ p  # the inverse of this, in closed form
    xx, yy, xy = square[:, 0, 0], square[:, 1, 1], square[:, 0, 1]
    scale = blur_variance / (xx * yy - xy * xy)
    return Covariance(yy * scale, xx * scale, -xy * scale)


def draw(grid: Grid, black: Floats, blur: Covariance) -> Drawing:
    """Return the blurred drawings of markers with ``black`` cells (M, n, n), 0 or 1."""
    sxx, syy, sxy = (np.asarray(v, np.float32)[:, None, None] for v in blur)
    m, n = len(black), grid.count
    profiles = grid.profiles(np.concatenate([blur.xx, blur.yy])).reshape(2 * m, 3 * n, -1)
    x, y = profiles[:m].transpose(0, 2, 1), profiles[m:]
    b = ((y @ black) @ x).reshape(m, 3, n, 3, n)  # derivatives by y, by x
    txy = b[:, 1, :, 1] * sxy
    tlap = b[:, 0, :, 2] * (0.5 * sxx) + b[:, 2, :, 0] * (0.5 * syy) + txy
    template = [1 - b[:, 0, :, 0] - txy, -b[:, 0, :, 1], -b[:, 1, :, 0], -tlap]
    return Drawing(*(t.reshape(m, -1) for t in template))


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

    def take(self, keep: Integers) -> Alignment:
        """Return the alignment of some of the markers, given by indices in ascending order."""
        if len(keep) == len(self.h):
            return self
        return replace(self, **{field.name: getattr(self, field.name)[keep] for field in fields(self)})

    def put(self, where: Integers, part: Alignment) -> None:
        """Replace some of the markers."""
        for field in fields(self):
            getattr(self, field.name)[where] = getattr(part, field.name)

    def clipped(self, which: Sequence[int]) -> Floats:
        """Return the values (K, P) of some markers, limited to a range slightly wider than black to white."""
        gain, dark = self.gain[which], self.dark[which]
        spare = thresholds.CONTRAST_SPARE * gain
        return np.clip(self.values[which], dark - spare, dark + gain + spare)

    def spread(self) -> Floats:
        """Return the covariance (M, 8, 8) of small changes of h (homography.small) for noise 1.

        Light and blur are unknowns, too.
        """
        return np.linalg.inv(_with_ridge(self.normal))[:, HOMOGRAPHY, HOMOGRAPHY]


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
        self._line = g.line.astype(np.float32)
        self._noise_samples = np.flatnonzero(self.fixed_weight > 0)[::3]
        half = cells / 2
        self._reach_of_parameters = np.array([1, half, half, 1, half, half, half * half, half * half])
        ones = np.ones_like(g.x)
        self._plane = np.stack([ones, g.x, g.y])
        self._light = np.stack([ones, g.x / half, g.y / half])

    def run(self, pyramid: Pyramid, camera: Camera, h: Floats, black: Bools, blur: Floats, level: Integers,
            steps: int, redraw: Sequence[int] = (1,)) -> Alignment:
        """Return the Alignment after some steps.

        Start values are ``h`` (M, 3, 3), ``black`` cells (M, n, n), the variance ``blur`` (M,) [px^2 at the level] and
        ``level`` (M,). Before the steps in ``redraw``, counted from 0, the drawings are computed again with the blur
        and perspective found so far.
        """
        compiled = native.library_for(camera)
        if compiled:
            return self._run_compiled(*compiled, pyramid, h, black, blur, level, steps, redraw)
        cells = black.astype(np.float32)
        drawing = draw(self.grid, cells, covariance(h, blur * 4.0 ** level))
        values = pyramid.read(*self.grid.places(h, camera), level)
        weights = self.fixed_weight[None].repeat(len(h), 0)
        gain = self._first_gain(values, drawing.template)
        state = self._solved(values, drawing, h, blur, level, weights, gain, thresholds.FIRST_OUTLIER)
        for step in range(1, steps):
            if step in redraw:
                drawing = draw(self.grid, cells, covariance(state.h, state.blur * 4.0 ** level))
            unsettled = np.flatnonzero(state.moved > thresholds.SETTLED)
            if step < thresholds.STEPS_OF_ALL or len(unsettled) == len(h):
                state = self._step(state, pyramid, camera, drawing)
            elif len(unsettled):
                part = self._step(state.take(unsettled), pyramid, camera, drawing.take(unsettled))
                state.put(unsettled, part)
        return state

    def _run_compiled(self, library: ctypes.CDLL, lens: Floats, pyramid: Pyramid, h: Floats, black: Bools, blur: Floats,
                      level: Integers, steps: int, redraw: Sequence[int]) -> Alignment:
        """Do the same as ``run`` with the compiled step of native/alignment.cpp."""
        markers, cells = black.shape[:2]
        h, blur = np.array(h, np.float64, order='C'), np.array(blur, np.float64)
        level = np.ascontiguousarray(level, np.int64)
        samples = np.empty((6, markers, len(self.grid.x)), np.float32)
        numbers, normal = np.zeros((3, markers)), np.zeros((markers, PARAMETERS, PARAMETERS))
        atlas, table = pyramid.memory
        line, weight, normal_step, limits = self.compiled_arrays()
        black, place = np.ascontiguousarray(black), native.address
        library.alvar_align(
            markers, *native.image(atlas), place(table), place(lens), cells,
            self.grid.count, place(line), place(weight), place(normal_step), place(limits), steps,
            sum(1 << step for step in redraw), place(black), place(level), place(h), place(blur), place(samples),
            place(numbers), place(normal))
        values, template, model, gain, dark, weights = samples
        contrast, noise, moved = numbers
        return Alignment(h, blur, level, values, template, model, gain, dark, contrast, weights, noise, normal, moved)

    def compiled_arrays(self) -> tuple[Floats, ...]:
        """Return what native/alignment.cpp needs: samples in a row [cells], their weights, NORMAL_STEP, limits."""
        return self._line, self.fixed_weight, NORMAL_STEP, np.array([
            thresholds.FIRST_OUTLIER, thresholds.OUTLIER, thresholds.MIN_START_GAIN, *thresholds.GAIN_LIMITS,
            thresholds.MAX_STEP, *thresholds.BLUR_STEP_LIMITS, *thresholds.BLUR_LIMITS, thresholds.MIN_OUTLIER_NOISE,
            thresholds.MIN_OUTLIER_CONTRAST, thresholds.SETTLED, thresholds.STEPS_OF_ALL])

    def _step(self, last: Alignment, pyramid: Pyramid, camera: Camera, drawing: Drawing) -> Alignment:
        values = pyramid.read(*self.grid.places(last.h, camera), last.level)
        return self._solved(values, drawing, last.h, last.blur, last.level, last.weights, last.gain, thresholds.OUTLIER)

    def _solved(self, values: Floats, drawing: Drawing, h: Floats, blur: Floats, level: Integers, weights: Floats,
                gain: Floats, outlier: float) -> Alignment:
        """Return the Alignment after a Gauss-Newton step; ``values`` were read at ``h``."""
        basis = self._basis(drawing, gain, values)
        product = ((basis[:, :-1] * weights[:, None]) @ basis.transpose(0, 2, 1)).astype(np.float64)
        normal = product[:, :, :-1]
        theta = np.linalg.solve(_with_ridge(normal), product[:, :, -1:])[:, :, 0]
        model = (theta[:, None].astype(np.float32) @ basis[:, :-1])[:, 0]
        contrast = theta[:, WHITE.start]
        level_of_grey = np.maximum(contrast[:, None], 1.0).astype(np.float32)
        low, high = thresholds.GAIN_LIMITS
        gain = _within(theta[:, WHITE].astype(np.float32) @ self._light, low * level_of_grey, high * level_of_grey)
        dark = theta[:, BLACK].astype(np.float32) @ self._light
        change = _within(theta[:, BLUR] / level_of_grey[:, 0], *thresholds.BLUR_STEP_LIMITS)
        blur = _within(blur * (1 + change), *thresholds.BLUR_LIMITS)
        step = _within(-theta[:, HOMOGRAPHY], -thresholds.MAX_STEP, thresholds.MAX_STEP)
        h = h @ homography.small(step)
        h /= h[:, 2:, 2:]
        residual = values - model
        noise = self._noise(residual)
        moved = np.abs(step * self._reach_of_parameters).max(1)
        return Alignment(h, blur, level, values, drawing.template, model, gain, dark, contrast,
                         self._robust(residual, noise, contrast, outlier), noise, normal, moved)

    def _basis(self, drawing: Drawing, gain: Floats, values: Floats) -> Floats:
        """Return (M, 16, P): the derivatives by the parameters (HOMOGRAPHY, WHITE, BLACK, BLUR), then the values."""
        out = np.empty((len(values), PARAMETERS + 1, values.shape[1]), np.float32)
        np.multiply((drawing.by_x * gain)[:, None], self._plane, out=out[:, 0:3])
        np.multiply((drawing.by_y * gain)[:, None], self._plane, out=out[:, 3:6])
        np.multiply((out[:, 1] + out[:, 5])[:, None], self._plane[1:], out=out[:, 6:8])
        np.multiply(drawing.template[:, None], self._light, out=out[:, WHITE])
        out[:, BLACK], out[:, BLUR], out[:, PARAMETERS] = self._light, drawing.by_blur, values
        return out

    def _first_gain(self, values: Floats, template: Floats) -> Floats:
        """Return a first estimate (M, 1) [greys] of white minus black."""
        v, t = values - (values @ self.share)[:, None], template - (template @ self.share)[:, None]
        gain: Floats = ((t * v) @ self.share) / ((t * t) @ self.share + 1e-6)
        return np.maximum(gain, thresholds.MIN_START_GAIN)[:, None]

    def _noise(self, residual: Floats) -> Floats:
        """Return the standard deviation (M,) of residuals (M, P), estimated from the median of their sizes."""
        size = np.abs(residual.take(self._noise_samples, 1))
        middle = size.shape[1] // 2
        return 1.4826 * np.partition(size, middle, 1)[:, middle]

    def _robust(self, residual: Floats, noise: Floats, contrast: Floats, outlier: float) -> Floats:
        """Return Tukey's weights (M, P) of the samples: 0 from ``outlier`` times the noise on."""
        least = thresholds.MIN_OUTLIER_NOISE * np.maximum(contrast, thresholds.MIN_OUTLIER_CONTRAST)
        limit = outlier * np.maximum(noise, least)
        t: Floats = residual * (1 / limit).astype(np.float32)[:, None]
        np.minimum(t * t, 1, out=t)
        t -= 1
        t *= t
        t *= self.fixed_weight
        return t


def _with_ridge(normal: Floats) -> Floats:
    """Return normal equations (M, n, n) with a small ridge, so that they can be solved for every image."""
    out, n = normal.copy(), normal.shape[1]
    diagonal = out.reshape(len(out), -1)[:, ::n + 1]
    diagonal *= 1 + 1e-6
    diagonal += 1e-9
    return out


def _within(values: Floats, low: Floats | float, high: Floats | float) -> Floats:
    """Do the same as numpy.clip, without its checks, which take longer than the clipping."""
    values = np.maximum(values, low)
    return np.minimum(values, high, out=values)
