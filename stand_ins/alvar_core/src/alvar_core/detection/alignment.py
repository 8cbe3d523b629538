"""Photometric alignment: the drawn marker, blurred, is laid over the picture until the greys agree.

All marker coordinates here are cells: x right, y down as the marker is drawn, origin in its centre.  A homography H
takes them to ideal pixels (camera.py).  Everything works on a batch of M markers at once.
"""
import functools

import cv2
import numpy as np

from alvar_core.detection import homography

# tanh(a z + b z^3 + c z^5) is twice the step of a normal distribution, less one: to 4e-5 (the form after Page, 1977)
NORMAL_STEP = np.float32([0.7977178, 0.03679826, -0.000315808])
ALL_STEPS = 2  # steps that every marker gets; further ones only if it has not settled
SPARE = 0.25  # of the contrast: greys further beyond black and white are no noise but something else
BOX_VARIANCE = 0.25  # px^2: pixel area and bilinear reading


class Pyramid:
    """A grey picture (uint8) at full, half and quarter size, in one array so that one remap reads all of them."""

    LEVELS = 3

    def __init__(self, grey, atlas=None):
        height, width = grey.shape
        boxes, self.table = _atlas_of(width, height, self.LEVELS)
        self.atlas = np.empty((height + height // 2, width), np.uint8) if atlas is None else atlas
        self.atlas[:height], finer = grey, grey
        for x, y, wide, high in boxes[1:]:
            finer = cv2.resize(finer, (wide, high), dst=self.atlas[y:y + high, x:x + wide],
                               interpolation=cv2.INTER_AREA)

    def read(self, x, y, level):
        """Grey values (float32) at real pixels x, y (M, P float32) of the full picture, read at `level` (M,)."""
        scale, x_offset, y_offset, left, top, right, bottom = self.table[level].T[:, :, None]
        x, y = x * scale, y * scale
        for along, offset, low, high in (x, x_offset, left, right), (y, y_offset, top, bottom):
            along += offset
            np.maximum(along, low, out=along)
            np.minimum(along, high, out=along)
        return cv2.remap(self.atlas, x, y, cv2.INTER_LINEAR).astype(np.float32)


@functools.lru_cache(maxsize=8)
def _atlas_of(width, height, levels):
    """Of each level of a Pyramid: its box (x, y, width, height); scale, offset, lowest and highest place by x and y."""
    sizes = np.array([[width >> level, height >> level] for level in range(levels)])
    base = np.array([[0, 0], [0, height], [width - sizes[2, 0], height]])
    scale = 0.5 ** np.arange(levels)[:, None]
    table = np.hstack([scale, base + 0.5 * scale - 0.5, base, base + sizes - 1]).astype(np.float32)
    return np.hstack([base, sizes]).tolist(), table


def pixels_per_cell(h):
    """(M, 2, 2): derivative of ideal pixels by cells in the marker's centre."""
    w = h[:, 2, 2][:, None, None]
    centre = h[:, :2, 2:] / w
    return (h[:, :2, :2] - centre * h[:, 2:3, :2]) / w


class Grid:
    """Sample places over a marker of `cells` cells a side: `per_cell` a cell, `inset` samples of its surroundings."""

    def __init__(self, cells, per_cell, inset=2):
        half = cells / 2 + inset / per_cell
        count = cells * per_cell + 2 * inset
        self.cells, self.per_cell, self.count = cells, per_cell, count
        self.body = slice(inset, inset + cells * per_cell)
        self.line = ((np.arange(count) + 0.5) / count * 2 - 1) * half
        self.x = np.tile(self.line, count).astype(np.float32)
        self.y = np.repeat(self.line, count).astype(np.float32)
        self.to_edges = (self.line[:, None] - (np.arange(cells + 1) - cells / 2)).astype(np.float32)
        self.homogeneous = np.stack([self.x, self.y, np.ones_like(self.x)])
        self.reach = np.maximum(np.abs(self.x), np.abs(self.y)) - cells / 2

    def places(self, h, camera):
        """Real pixels (x, y), each (M, P), of the sample places."""
        p = h.astype(np.float32) @ self.homogeneous
        p[:, :2] /= p[:, 2:]
        return camera.to_real(p[:, 0], p[:, 1])

    def profiles(self, variance):
        """For blur variance (M,), cells: coverage of the columns of cells, its first two derivatives: (M, 3, S, n)."""
        s = (1 / np.sqrt(variance)).astype(np.float32)[:, None, None]
        z = self.to_edges * s
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


def covariance(h, blur_variance):
    """Blur of the picture (variance in px^2, (M,)) as covariance in cells: sxx, syy, sxy, each (M,)."""
    p = pixels_per_cell(h)
    square = p.transpose(0, 2, 1) @ p  # the inverse of this, in closed form
    xx, yy, xy = square[:, 0, 0], square[:, 1, 1], square[:, 0, 1]
    scale = blur_variance / (xx * yy - xy * xy)
    return yy * scale, xx * scale, -xy * scale


def draw(grid, black, cov):
    """Blurred template and derivatives (T, Tx, Ty, D), each (M, P): T 0 black to 1 white; D by the blur variance."""
    sxx, syy, sxy = (np.asarray(v, np.float32)[:, None, None] for v in cov)
    m, n = len(black), grid.count
    profiles = grid.profiles(np.concatenate(cov[:2])).reshape(2 * m, 3 * n, -1)
    x, y = profiles[:m].transpose(0, 2, 1), profiles[m:]
    b = ((y @ black) @ x).reshape(m, 3, n, 3, n)  # derivatives by y, by x
    txy = b[:, 1, :, 1] * sxy
    tlap = b[:, 0, :, 2] * (0.5 * sxx) + b[:, 2, :, 0] * (0.5 * syy) + txy
    template = [1 - b[:, 0, :, 0] - txy, -b[:, 0, :, 1], -b[:, 1, :, 0], -tlap]
    return [t.reshape(m, -1) for t in template]


class Alignment:
    """What an Aligner knows of M markers: h (M, 3, 3), blur, level, contrast, noise, values, model, gain, weights"""

    def __init__(self, h, blur, level, weights):
        self.h, self.blur, self.level, self.weights = h.copy(), blur.copy(), level, weights
        self.gain = self.dark = self.values = self.model = self.template = self.normal = None

    def take(self, keep):
        """The same for some of the markers, given by indices in rising order."""
        if len(keep) == len(self.h):
            return self
        out = Alignment.__new__(Alignment)
        out.__dict__ = {k: v[keep] for k, v in self.__dict__.items()}
        return out

    def put(self, where, part):
        """Replace some of the markers."""
        for name, value in part.__dict__.items():
            self.__dict__[name][where] = value

    def clipped(self, which):
        """Values (K, P) of some, what is far brighter than paper or darker than print there brought nearer to them."""
        gain, dark = self.gain[which], self.dark[which]
        spare = SPARE * gain
        return np.clip(self.values[which], dark - spare, dark + gain + spare)

    def spread(self):
        """Covariance (M, 8, 8), for noise 1, of small changes of h (homography.small); light and blur are not known."""
        return np.linalg.inv(_with_ridge(self.normal))[:, :8, :8]


class Aligner:
    """Batch Gauss-Newton over homography, light (gain and offset with slopes) and blur, robust against what covers.

    inner: only the outermost `inner` cells of the black square count (None: all of it).
    """

    SETTLED = 0.1  # cells: the largest move of a corner by any one parameter, then it is done

    def __init__(self, cells, per_cell=4, inner=None):
        self.grid = g = Grid(cells, per_cell)
        self.fixed_weight = np.interp(g.reach, [0, 0.05, 0.25, 0.5], [1, 0.7, 0.7, 0.25]).astype(np.float32)
        if inner is not None:
            self.fixed_weight *= g.reach > -inner
        self.share = self.fixed_weight / self.fixed_weight.sum()
        self.inside = np.flatnonzero(self.fixed_weight > 0)[::3]
        self.u, self.v = g.x / (cells / 2), g.y / (cells / 2)
        half = cells / 2
        self.reach_of_steps = np.array([1, half, half, 1, half, half, half * half, half * half])
        self.plane = np.stack([np.ones_like(g.x), g.x, g.y])
        self.light = np.stack([np.ones_like(g.x), self.u, self.v])

    def run(self, pyramid, camera, h, black, blur, level, iterations, redraw=(1,)):
        """Return the Alignment from start h (M, 3, 3), black (M, n, n), blur (M,) px^2 at the level, level (M,)."""
        state = Alignment(h, blur, level, self.fixed_weight[None].repeat(len(h), 0))
        black = black.astype(np.float32)
        moved = np.full(len(h), np.inf)
        for i in range(iterations):
            if i == 0 or i in redraw:
                drawn = draw(self.grid, black, covariance(state.h, state.blur * 4.0 ** level))
            cut = 4.0 if i == 0 else 3.0
            rest = np.flatnonzero(moved > self.SETTLED)
            if i < ALL_STEPS or len(rest) == len(h):
                moved = self._iterate(state, pyramid, camera, drawn, cut)
            elif len(rest):
                part = state.take(rest)
                moved[rest] = self._iterate(part, pyramid, camera, [d[rest] for d in drawn], cut)
                state.put(rest, part)
        return state

    def _iterate(self, state, pyramid, camera, drawn, cut):
        values = pyramid.read(*self.grid.places(state.h, camera), state.level)
        if state.gain is None:
            state.gain = self._first_gain(values, drawn[0])
        basis = self._basis(*drawn, state.gain, values)
        product = ((basis[:, :-1] * state.weights[:, None]) @ basis.transpose(0, 2, 1)).astype(np.float64)
        state.normal = product[:, :, :-1]
        theta = np.linalg.solve(_with_ridge(state.normal), product[:, :, -1:])[:, :, 0]
        state.values, state.template = values, drawn[0]
        state.model = (theta[:, None].astype(np.float32) @ basis[:, :-1])[:, 0]
        self._light(state, theta)
        step = _within(-theta[:, :8], -0.6, 0.6)
        state.h = state.h @ homography.small(step)
        state.h /= state.h[:, 2:, 2:]
        state.weights = self._robust(values - state.model, state, cut)
        return np.abs(step * self.reach_of_steps).max(1)

    def _basis(self, template, tx, ty, tlap, gain, values):
        """(M, 16, P): derivatives by the homography (8), the light (white: 8, 9, 10; black: 11, 12, 13), the blur (14);
        the values."""
        out = np.empty((len(template), 16, template.shape[1]), np.float32)
        np.multiply((tx * gain)[:, None], self.plane, out=out[:, 0:3])
        np.multiply((ty * gain)[:, None], self.plane, out=out[:, 3:6])
        np.multiply((out[:, 1] + out[:, 5])[:, None], self.plane[1:], out=out[:, 6:8])
        np.multiply(template[:, None], self.light, out=out[:, 8:11])
        out[:, 11:14], out[:, 14], out[:, 15] = self.light, tlap, values
        return out

    def _first_gain(self, values, template):
        """Grey levels (M, 1) from black to white."""
        v, t = values - (values @ self.share)[:, None], template - (template @ self.share)[:, None]
        return np.maximum(((t * v) @ self.share) / ((t * t) @ self.share + 1e-6), 2.0)[:, None]

    def _light(self, state, theta):
        state.contrast = theta[:, 8]
        level = np.maximum(theta[:, 8:9], 1.0).astype(np.float32)
        state.gain = _within(theta[:, 8:11].astype(np.float32) @ self.light, 0.3 * level, 2 * level)
        state.dark = theta[:, 11:14].astype(np.float32) @ self.light
        state.blur = _within(state.blur * (1 + _within(theta[:, 14] / level[:, 0], -0.5, 0.8)), 0.25, 6.0)

    def _robust(self, residual, state, cut):
        size = np.abs(residual.take(self.inside, 1))
        middle = size.shape[1] // 2
        state.noise = 1.4826 * np.partition(size, middle, 1)[:, middle]
        limit = cut * np.maximum(state.noise, 0.05 * np.maximum(state.contrast, 4.0))
        t = residual * (1 / limit).astype(np.float32)[:, None]
        np.minimum(t * t, 1, out=t)
        t -= 1
        t *= t
        t *= self.fixed_weight
        return t


def _with_ridge(normal):
    """Normal equations (M, n, n) that can be solved whatever the picture shows."""
    out, n = normal.copy(), normal.shape[1]
    diagonal = out.reshape(len(out), -1)[:, ::n + 1]
    diagonal *= 1 + 1e-6
    diagonal += 1e-9
    return out


def _within(values, low, high):
    """As numpy.clip, which takes its time."""
    values = np.maximum(values, low)
    return np.minimum(values, high, out=values)
