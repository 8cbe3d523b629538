"""The marker detector: picture, camera, marker size in; ids, corners, poses out.  Every picture stands on its own."""
import math
from numbers import Real

import numpy as np

from alvar_core import code
from alvar_core.camera import Camera, CameraError
from alvar_core.detection import alignment, candidates, edge_refiner, homography, pose, reading
from alvar_core.detection.acceptance import accepted
from alvar_core.detection.detection import Detection, best_of_overlapping
from alvar_core.detection.prepared_image import PictureError, View, grey_picture

PER_CELL = 3  # samples along a cell
MARGINS = range(1, 11)  # cells
# First look: NEAR_FIT of the cells with a code word is worth an alignment, MAX_EXAMINED of them a picture.
NEAR_FIT, MAX_EXAMINED = 0.64, 16
# After alignment: below these, or with a blur above (cells), it is dropped; a new reading needs READ_FIT to go on.
MIN_LIKENESS, MAX_BLUR_CELLS, READ_FIT = 0.65, 0.85, 0.72
MIN_AREA, MAX_ERROR = 200.0, 0.05  # px^2; rms reprojection error of the best pose in parts of the side
EDGES_SIDE, MAX_MOVE = 36.0, 0.2  # px, from where on edges are measured; cells that they may move a corner
COARSE_ERROR = 0.05  # px of a corner, times the square of the px between two samples of the alignment
NEXT_LEVEL = (4 * 2 ** 0.5, 8 * 2 ** 0.5)  # px of a cell: larger ones are read at half, at a quarter of the size
READ_NOISE = 2 / 3  # of a picture's noise is left in values between its pixels
SURE_DETAIL = 0.93  # no doubt about the margin
SURE_FIT, SURE_GAP = 0.93, 0.12  # a first look that need not be repeated


def checked_size(size):
    """A marker's size, metres, as float; ValueError if no marker can have it."""
    if isinstance(size, (bool, str)) or not isinstance(size, Real) or not 0 < size < math.inf:
        raise ValueError(f'marker size {size!r} m: a length above 0 is needed')
    return float(size)


def checked_margin(margin):
    """A margin, cells, as int; ValueError if no marker has it."""
    if isinstance(margin, bool) or not isinstance(margin, Real) or margin not in MARGINS:
        raise ValueError(f'marker margin {margin!r}: a whole number of cells from {MARGINS[0]} to {MARGINS[-1]} '
                         'is needed')
    return int(margin)


class Detector:
    """Finds ALVAR markers of one resolution and margin.

    size: width of the black square, metres; sizes: {id: metres} for others; resolution and margin in cells.
    Not thread safe: one thread uses a Detector at a time.
    """

    STEPS, RIM_STEPS = 5, 8

    def __init__(self, size, resolution=5, margin=2, sizes=None):
        self.workspace = candidates.Workspace()
        self.size, self.sizes = size, {value: checked_size(each) for value, each in (sizes or {}).items()}
        self.resolution, self.margin = code.check_resolution(resolution), checked_margin(margin)
        self.cells = self.resolution + 2 * self.margin
        self.glance = reading.Glance(self.resolution, self.margin)
        self.ring = alignment.Aligner(self.cells, PER_CELL, inner=min(1.6, self.margin * 0.8))
        self.full = alignment.Aligner(self.cells, PER_CELL)
        self.edges = edge_refiner.Edges(self.cells)
        self.reader = reading.Reader(self.full.grid, self.resolution, self.margin)
        if self.glance.seen is not None:
            self.black_words = reading.black_cells(self.glance.seen, self.margin)
        g = self.full.grid
        self.detail = np.flatnonzero(g.reach < -self.margin + 0.5)
        x, y = g.x[self.detail], g.y[self.detail]
        self.smooth_basis = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], 1))[0]
        half = self.cells / 2
        ring = (g.reach > 0) & (g.reach < 1 / PER_CELL)
        sides = [ring & beyond for beyond in (g.x < -half, g.x > half, g.y < -half, g.y > half)]
        column, row = (np.floor(v + half) for v in (g.x, g.y))
        cells = [(row == y) & (column == x) for y in range(self.cells) for x in range(self.cells)]
        means = np.array(cells + sides)
        self.means = (means / means.sum(1, keepdims=True)).T.astype(np.float32)  # of the cells, then just outside
        self.data = np.pad(np.ones((self.resolution, self.resolution), bool), self.margin).ravel()
        self.square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        self.square_h = np.concatenate([self.square, np.ones((4, 1))], 1)[:, :, None]
        self.square_steps = np.array([(homography.small(np.eye(8)) @ p - p)[..., 0].T for p in self.square_h])

    @property
    def size(self):
        """Width of the black square, metres, of every marker that is not in `sizes`; may be set."""
        return self._size

    @size.setter
    def size(self, size):
        self._size = checked_size(size)

    def detect(self, picture, camera):
        """Return the Detections in a picture.  camera: Camera (camera.py).  Raises PictureError, CameraError."""
        view = self.view(picture, camera)
        return self.examine(view, candidates.candidates(view.smooth, workspace=self.workspace))

    def view(self, picture, camera):
        """The picture prepared for examine(); it is valid until the next one of this detector."""
        return View(picture, camera, self.workspace)

    def examine(self, view, quads):
        """Return the Detections among candidate quads (N, 4, 2), real px, clockwise."""
        quads = candidates.refined(view.smooth, quads)
        if not len(quads):
            return []
        look = self.glance.look(view.smooth, quads)
        quads = quads[look.kept]
        near = np.flatnonzero(look.fit > NEAR_FIT)
        chosen = candidates.distinct(quads, look.fit + 0.5 * look.gap, near)[:MAX_EXAMINED]
        if not chosen:
            return []
        return best_of_overlapping(self._align(view, quads[chosen], look, chosen))

    def _align(self, view, quads, look, chosen):
        cell = np.sqrt(np.abs(homography.area(quads))) / self.cells
        h = look.h[chosen]
        if view.camera.distorted:
            h = homography.from_square(view.camera.to_ideal(quads), self.cells / 2)
        level = np.searchsorted(NEXT_LEVEL, cell)
        start = np.maximum(1.0, (0.12 * cell / 2.0 ** level) ** 2)
        if self.glance.seen is None:
            return self._finish(view, *self._by_rim(view, h, start, level, cell))
        looks = list(zip(look.word[chosen], look.fit[chosen], look.gap[chosen]))
        return self._finish(view, h, self.black_words[look.word[chosen]], start, level, looks)

    def _by_rim(self, view, h, blur, level, cell):
        """Align by the rim alone and read the cells: (h, black, blur, level) of those that could be read."""
        all_black = np.ones((len(h), self.cells, self.cells), bool)
        start = np.maximum(1.0, (0.3 * cell / 2.0 ** level) ** 2)
        rim = self.ring.run(view.pyramid, view.camera, h, all_black, start, level, self.RIM_STEPS, redraw=(1, 3, 5))
        both, twice = np.concatenate([rim.h, h]), np.concatenate([level, level])
        blur = np.concatenate([rim.blur, blur])
        values = view.pyramid.read(*self.full.grid.places(both, view.camera), twice)
        shares = self._shares(values)
        readings = self.reader.read_cells(shares, alignment.covariance(both, blur * 4.0 ** twice))
        read = [max((m, m + len(h)), key=lambda k: readings[k].fit if readings[k] else 0.0) for m in range(len(h))]
        read = [k for k in read if readings[k] is not None and readings[k].fit > READ_FIT]
        black = [reading.black_cells(readings[k].white, self.margin) for k in read]
        return both[read], np.array(black, bool), blur[read], twice[read]

    def _shares(self, values):
        """Grey values (M, P) as 0 (the rim's black) to 1 (the brightest cells)."""
        reach = self.full.grid.reach
        dark = np.median(values[:, (reach < -0.2) & (reach > 0.5 - self.margin)], 1, keepdims=True)
        white = np.percentile(values[:, reach < -self.margin], 97, axis=1, keepdims=True)
        return ((values - dark) / np.maximum(white - dark, 4.0)).astype(np.float32)

    def _finish(self, view, h, black, blur, level, looks=None):
        """Align with the drawings, read, accept; what reads differently the first time (looks) gets another try."""
        if not len(h):
            return []
        state = self.full.run(view.pyramid, view.camera, h, black, blur, level, self.STEPS)
        state.own = np.minimum(state.noise, READ_NOISE * view.noise / 2.0 ** level)
        good, likeness, cov, corners = self._promising(state)
        if not len(good):
            return []
        state, black = state.take(good), black[good]
        readings = self._read(state, cov, likeness, looks and [looks[m] for m in good])
        inner = slice(self.margin, self.margin + self.resolution)
        features = self._features(state, likeness)
        found, changed = [], []
        for m, r in enumerate(readings):
            if r is not None and (black[m, inner, inner] != r.white).all():
                features[m].update(fit=r.fit, gap=r.gap)
                if accepted(features[m]) and not self._of_other_margin(view, corners[m], features[m]):
                    found.append((m, r, features[m]))
            elif r is not None and r.fit > READ_FIT:
                changed.append(m)
        out = self._poses(view, state, corners, found)
        if changed and looks:
            black = np.array([reading.black_cells(readings[m].white, self.margin) for m in changed])
            out += self._finish(view, state.h[changed], black, state.blur[changed], state.level[changed])
        return out

    def _promising(self, state):
        """Indices of the aligned ones that may be markers, and their likeness, blur covariance and corners."""
        likeness, corners = self._likeness(state), homography.apply(state.h, self.square)
        cov = alignment.covariance(state.h, state.blur * 4.0 ** state.level)
        with np.errstate(invalid='ignore'):
            good = (np.isfinite(corners).all((1, 2)) & (homography.area(corners) > MIN_AREA)
                    & (likeness > MIN_LIKENESS) & (np.sqrt((cov[0] + cov[1]) / 2) < MAX_BLUR_CELLS))
        good = np.flatnonzero(good)
        return good, likeness[good], [c[good] for c in cov], corners[good]

    def _read(self, state, cov, likeness, looks):
        """A Reading (or None) for each marker; where the first look was sure already, that one stands."""
        readings = [None] * len(likeness)
        for m, (word, fit, gap) in enumerate(looks or ()):
            if fit > SURE_FIT and gap > SURE_GAP and likeness[m] > SURE_FIT:
                readings[m] = self.reader.of_word(word, fit, gap)
        rest = [m for m, r in enumerate(readings) if r is None]
        if rest:
            cov = [c[rest] for c in cov]
            if self.resolution == 5:
                again = self.reader.read(state.clipped(rest), cov, state.own[rest])
            else:
                again = self.reader.read_cells(self._shares(state.values[rest]), cov)
            for m, r in zip(rest, again):
                readings[m] = r
        return readings

    def _of_other_margin(self, view, corners, features):
        """Whether the cells look more like a code when the margin is taken for a cell narrower or wider."""
        if features['detail'] > SURE_DETAIL or self.glance.seen is None:
            return False
        real = np.stack(view.camera.to_real(corners[:, 0], corners[:, 1]), -1)
        fits = [self.glance.fit(view.smooth, real, self.cells / (self.cells + more)) for more in (0, -2, 2)]
        return max(fits[1:]) > fits[0]

    def _likeness(self, state):
        """Normalised correlation (M,) of the picture, but for its noise, with the drawn marker; light's slopes too."""
        share = self.full.share
        v = state.values - (state.values @ share)[:, None]
        t = state.template - (state.template @ share)[:, None]
        with np.errstate(invalid='ignore'):
            energy = reading.without_noise((v * v) @ share, state.own ** 2)
            return ((v * t) @ share) / np.sqrt(energy * ((t * t) @ share) + 1e-6)

    def _detail(self, state):
        """Correlation (M,) of the data cells with their drawing, without noise and what is smooth (squares of x, y)."""
        both = np.concatenate([state.values, state.template]).take(self.detail, 1)
        both -= (both @ self.smooth_basis) @ self.smooth_basis.T
        v, t = both[:len(state.h)], both[len(state.h):]
        energy = reading.without_noise((v * v).sum(1), len(self.detail) * state.own ** 2)
        return (v * t).sum(1) / np.sqrt(energy * (t * t).sum(1) + 1e-6)

    def _features(self, state, likeness):
        """For each marker what accept.accepted() asks for, but for what was read: a list of dictionaries."""
        means = ((state.values - state.model) / state.gain) @ self.means
        bad = np.abs(means[:, :-4]) > 0.4
        inside = bad[:, self.data].sum(1)
        columns = dict(likeness=likeness, outside=means[:, -4:].min(1), detail=self._detail(state),
                       bad_inside=inside, bad_rim=bad.sum(1) - inside,
                       kept=state.weights.sum(1) / self.full.fixed_weight.sum(),
                       contrast=state.contrast, noise=state.noise, blur=state.blur)
        return [dict(zip(columns, row)) for row in zip(*(column.tolist() for column in columns.values()))]

    def _poses(self, view, state, corners, found):
        if not found:
            return []
        accepted = [m for m, _, _ in found]
        readings, features = [r for _, r, _ in found], [f for _, _, f in found]
        corners, information = self._measured(view, state.take(accepted), corners[accepted])
        order = np.array([[(k + r.content.turns) % 4 for k in range(4)] for r in readings])
        eight = (2 * order[:, :, None] + [0, 1]).reshape(-1, 8)
        corners = np.take_along_axis(corners, order[:, :, None], 1)
        information = information[np.arange(len(found))[:, None, None], eight[:, :, None], eight[:, None]]
        for f, i in zip(features, information):
            f['information'] = i
        sizes = [self.sizes.get(r.content.value, self.size) for r in readings]
        real = np.stack(view.camera.to_real(corners[..., 0], corners[..., 1]), -1)
        out = []
        sides = np.sqrt(homography.area(real))
        for m, solutions in enumerate(pose.solve(corners, sizes, view.camera, information)):
            if solutions and solutions[0].error < MAX_ERROR * sides[m]:
                share, ambiguous = pose.ambiguity(solutions)
                best = solutions[0]
                out.append(Detection(readings[m].content.value, real[m], best.rotation, best.position,
                                     features[m]['likeness'], share, ambiguous, best.error, solutions, features[m]))
        return out

    def _measured(self, view, state, corners):
        """Corners (M, 4, 2), ideal px, and their information (M, 8, 8): of the alignment, and of the edges if large."""
        noise = np.maximum(state.noise, 1.0)[:, None, None]
        side = np.sqrt(homography.area(corners))
        coarse = COARSE_ERROR * (side / self.cells / PER_CELL) ** 2
        covariance = self._corner_spread(state) * (1.5 * noise ** 2)
        covariance += _floor(np.maximum(pose.MODEL_ERROR * 2.0 ** state.level, coarse))
        large = np.flatnonzero(side > EDGES_SIDE)
        if len(large):
            sigma = np.sqrt(state.blur[large]) * 2.0 ** state.level[large]
            sharp, of_edges, good = self.edges.refine(view.pyramid, view.camera, state.h[large], sigma)
            moved = sharp - corners[large]
            good &= np.abs(moved).max((1, 2)) < MAX_MOVE * side[large] / self.cells
            large, moved = large[good], moved[good].reshape(-1, 8, 1)
            before = covariance[large]
            share = before @ np.linalg.inv(before + of_edges[good])  # what counts of the edges
            corners[large] += (share @ moved).reshape(-1, 4, 2)
            covariance[large] = before - share @ before + _floor(np.full(len(large), pose.MODEL_ERROR))
        return corners, np.linalg.inv(covariance)

    def _corner_spread(self, state):
        """Covariance (M, 8, 8) of the corners, ideal px, for noise 1."""
        h = state.h[:, None]
        p = h @ self.square_h  # (M, 4, 3, 1)
        jacobian = (h[:, :, :2] - p[:, :, :2] / p[:, :, 2:] * h[:, :, 2:]) / p[:, :, 2:] @ self.square_steps
        jacobian = jacobian.reshape(-1, 8, 8)
        return jacobian @ state.spread() @ jacobian.transpose(0, 2, 1)


def _floor(sigma):
    """Covariance (M, 8, 8) of corners that are wrong by sigma (M,) px each."""
    return np.eye(8) * sigma[:, None, None] ** 2


__all__ = ['Camera', 'CameraError', 'Detection', 'Detector', 'PictureError', 'View', 'grey_picture']
