"""Learn a bundle: where its markers are, from images that each show some of them.

The markers are found one after the other, beginning at the master. Each image that shows a marker beside known
ones gives up to four poses of it, because small markers are ambiguous; the one that fits most images is chosen. Then
the poses of all markers and of the camera in all images are fitted to all corners at once, each weighted by its error.
Markers that contradict the others in an image count little there.

Bundle frame: that of the master. Camera frame: optical. Lengths in metres, angles in radians, images in pixels.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Mapping, NamedTuple, Sequence

import numpy as np

from alvar_core import drawing
from alvar_core.arrays import Floats, Integers
from alvar_core.bundles import Bundle
from alvar_core.camera import Camera
from alvar_core.code import Value
from alvar_core.detection import bundle_pose, homography, pose, thresholds
from alvar_core.detection.detection import Detection
from alvar_core.rotations import angle_between

MIN_VIEWS = 2  # images in which a marker is seen beside known ones, as in the original
MAX_VIEWS = 200  # images: more of them take long and add little
MOVED = 3.0  # [px] that the corners differ from those of an earlier image: nearer ones show nothing new
CORNER_FLOOR = 0.05  # [px] error of a corner that its covariance does not include: calibration, print
OUTLIER = 3.0  # times the usual error of a marker in an image: from there on it counts less than half
SAME_START = math.radians(8.0)  # candidates for a marker's pose nearer to each other lead to the same
STEPS, SETTLED = 30, 1e-7  # of the fit; relative change of its cost


class TrainingError(ValueError):
    """An image that cannot be used, or too few of them; the text says what to do."""


class View(NamedTuple):
    """The markers of a bundle in one image: ``camera``, and the Detections {id: ...}."""

    camera: Camera
    markers: Mapping[int, Detection]


class Spread(NamedTuple):
    """The standard deviation of a marker's ``position`` [m] and ``rotation`` [rad] in the bundle."""

    position: float
    rotation: float


@dataclass(frozen=True)
class Learnt:
    """The result.

    ``corners`` {id: (4, 3)} [m] as in Bundle, the master first; ``unknown``: ids of the other markers; ``spread``
    {id: Spread}; ``error`` [px]: the median of the rms reprojection errors; ``views``: the number of images used;
    ``notes``: what is missing or doubtful, and what to do.
    """

    corners: Mapping[Value, Floats]
    unknown: tuple[int, ...]
    spread: Mapping[int, Spread]
    error: float
    views: int
    notes: tuple[str, ...] = field(default=())

    def bundle(self, source: str) -> Bundle:
        """Return the Bundle; ``source`` is the name of its file."""
        ids = (*(int(number) for number in self.corners), *self.unknown)
        return Bundle(source, ids[0], ids, self.corners, self.notes)


class Training:
    """Collects Views of the markers ``ids``, each ``size`` [m] wide; the first one is the master. Not thread-safe."""

    def __init__(self, ids: Sequence[int], size: float) -> None:
        self.ids, self.size = tuple(ids), size
        self.views: list[View] = []

    def add(self, detections: Sequence[Detection], camera: Camera) -> View:
        """Keep the View of an image, and return it; raise TrainingError if the image cannot be used."""
        if len(self.views) >= MAX_VIEWS:
            raise TrainingError(f'there are {MAX_VIEWS} images, which is the most; optimize and save, or reset')
        mine = [each for each in detections if each.id in self.ids]
        twice = sorted({str(each.id) for each in mine if sum(other.id == each.id for other in mine) > 1})
        view = View(camera, {int(each.id): each for each in mine if str(each.id) not in twice and not each.bend
                             and not (each.doubtful and not each.ambiguous)})
        if len(view.markers) < 2:
            raise TrainingError(self._too_few(detections, twice))
        if any(_same(view, other) for other in self.views):
            raise TrainingError('it shows the same as an earlier one; move the camera or the object')
        self.views.append(view)
        return view

    def _too_few(self, detections: Sequence[Detection], twice: Sequence[str]) -> str:
        seen = ', '.join(sorted((str(each.id) for each in detections), key=lambda text: (len(text), text))) or 'none'
        reasons = [f'{", ".join(twice)} can be seen twice'] if twice else []
        bent = sorted({int(each.id) for each in detections if each.id in self.ids and each.bend})
        reasons += [f'the paper of {_list(bent)} is bent'] if bent else []
        return (f'two of the markers {_list(self.ids)} must be in it, and it shows {seen}'
                + ''.join(f'; {reason}' for reason in reasons))

    def missing(self) -> list[str]:
        """Return texts that say which markers have not been seen beside the others often enough."""
        known, rest = self._connected()
        texts = []
        seen = {number for view in self.views for number in view.markers}
        unseen = [number for number in self.ids if number not in seen]
        if unseen:
            master = f'{self.ids[0]} (the master, without which nothing can be placed)'
            names = _list(unseen) if self.ids[0] in seen else ', '.join([master, *map(str, unseen[1:])])
            texts.append(f'Not seen in any image, beside another marker of the bundle: {names}.')
        apart = [number for number in rest if number in seen]
        if apart and known[0] in seen:
            texts.append(f'Not seen together with {_list(known)} in at least {MIN_VIEWS} images: {_list(apart)}. '
                         f'Add images that show one of these beside one of those.')
        return texts

    def _connected(self) -> tuple[list[int], list[int]]:
        """Return the ids whose pose follows from the images, the master first, and the others."""
        known = [self.ids[0]]
        while True:
            count = {number: sum(number in view.markers and not known_.isdisjoint(view.markers) for view in self.views)
                     for known_ in [set(known)] for number in self.ids if number not in known_}
            ready = [number for number, views in count.items() if views >= MIN_VIEWS]
            if not ready:
                return known, list(count)
            known.append(max(ready, key=lambda number: count[number]))

    def solve(self) -> Learnt:
        """Return the bundle that the Views show; raise TrainingError if only the master can be placed."""
        known, unknown = self._connected()
        if len(known) < 2:
            raise TrainingError(f'{len(self.views)} images are too few. ' + ' '.join(self.missing()))
        placed, ambiguous = _Placed(self.size, self.ids[0]), []
        for number in known[1:]:
            fit, sure = self._grown(placed, number)
            if fit is None:
                unknown.append(number)
                continue
            placed = fit.placed
            if not sure:
                ambiguous.append(number)
        if len(placed.ids) < 2:
            raise TrainingError('the images contradict each other: no second marker fits. Are the markers fixed to '
                                'each other, and is marker_size the width of their black squares?')
        fit = _Fit(placed, self.views, self._view_poses(placed))
        fit.run()
        notes = [*self.missing(), *self._doubts(fit, ambiguous)]
        order = [number for number in self.ids if number in fit.placed.ids]
        found = fit.placed.corners()
        corners: dict[Value, Floats] = {number: found[number] for number in order}
        return Learnt(corners,
                      tuple(number for number in self.ids if number not in order), fit.spread(), fit.error(),
                      len(fit.used), tuple(notes))

    def _view_poses(self, placed: _Placed) -> dict[int, list[pose.Solution]]:
        """Return {index of a View: poses of the bundle in it, best first} of the Views with a marker of ``placed``."""
        bundle = Bundle('', placed.ids[0], tuple(placed.ids), placed.corners())
        found = {}
        for index, view in enumerate(self.views):
            one = bundle_pose.solve(bundle, list(view.markers.values()), view.camera)
            if one is not None:
                found[index] = one.solutions
        return found

    def _grown(self, placed: _Placed, number: int) -> tuple[_Fit | None, bool]:
        """Return the best _Fit with one more marker, and whether its pose is clearly better than all others."""
        poses = self._view_poses(placed)
        fits = []
        for rotation, position in self._candidates(poses, number):
            fit = _Fit(placed.with_marker(number, rotation, position), self.views, poses)
            if number in fit.placed.ids:
                fits.append((fit.run(), fit))
        if not fits:
            return None, False
        fits.sort(key=lambda each: each[0])
        best = fits[0][1]
        others = [cost for cost, fit in fits[1:]
                  if angle_between(fit.placed.rotations[-1], best.placed.rotations[-1]) > SAME_START]
        return best, not others or min(others) - fits[0][0] > thresholds.AMBIGUOUS_CHI2

    def _candidates(self, poses: Mapping[int, Sequence[pose.Solution]], number: int) -> list[tuple[Floats, Floats]]:
        """Return up to two poses of a marker in the bundle, those that agree with most Views."""
        views = [(self.views[index], solutions) for index, solutions in poses.items()
                 if number in self.views[index].markers]
        rotations, positions = [], []
        for view, solutions in views:
            for of_bundle in solutions:
                for own in view.markers[number].solutions:
                    rotations.append(of_bundle.rotation.T @ own.rotation)
                    positions.append(of_bundle.rotation.T @ (own.position - of_bundle.position))
        if not rotations:
            return []
        turns, places = np.array(rotations), np.array(positions)
        agreement = sum(self._agreement(turns, places, view, solutions, number) for view, solutions in views)
        best: list[int] = []
        for index in np.argsort(-np.asarray(agreement), kind='stable').tolist():
            if all(angle_between(turns[index], turns[other]) > SAME_START for other in best):
                best.append(index)
            if len(best) == 2:
                break
        return [(turns[index], places[index]) for index in best]

    def _agreement(self, turns: Floats, places: Floats, view: View, solutions: Sequence[pose.Solution],
                   number: int) -> Floats:
        """Return how well poses (B, 3, 3), (B, 3) of a marker fit a View, 0 to 1 (B,)."""
        ideal = view.camera.to_ideal(view.markers[number].corners)
        limit = max(thresholds.AGREES_PX, thresholds.AGREES_SHARE * float(homography.mean_side(ideal[None])[0]))
        points = drawing.object_corners(self.size) @ turns.transpose(0, 2, 1) + places[:, None]
        fits = [np.zeros(len(turns))]
        for one in solutions:
            with np.errstate(all='ignore'):
                error = pose.reprojection_error(points @ one.rotation.T, np.tile(one.position, (len(turns), 1)),
                                                ideal[None], view.camera)
                fits.append(np.nan_to_num(1 / (1 + (error ** 2).mean(1) * 2 / limit ** 2)))
        best: Floats = np.max(fits, axis=0)
        return best

    @staticmethod
    def _doubts(fit: _Fit, ambiguous: Sequence[int]) -> list[str]:
        texts = []
        if ambiguous:
            texts.append(f'The tilt of {_list(ambiguous)} is not certain; add images that show them from nearer and '
                         'from the side.')
        odd = fit.odd()
        if odd:
            texts.append(f'{_list(odd)} contradict the others in many images. Do they move, are there two of one '
                         'number, or are they of another size?')
        return texts


class _Placed:
    """The poses of markers, ``size`` [m] wide, in the bundle.

    ``ids``, ``rotations`` (M, 3, 3), ``positions`` (M, 3) [m].
    """

    def __init__(self, size: float, master: int) -> None:
        self.size, self.ids = size, [master]
        self.rotations: Floats = np.eye(3)[None]
        self.positions: Floats = np.zeros((1, 3))

    def with_marker(self, number: int, rotation: Floats, position: Floats) -> _Placed:
        """Return these and one more."""
        more = _Placed(self.size, self.ids[0])
        more.ids = [*self.ids, number]
        more.rotations = np.concatenate([self.rotations, rotation[None]])
        more.positions = np.concatenate([self.positions, position[None]])
        return more

    def corners(self) -> dict[Value, Floats]:
        """Return {id: (4, 3)} [m]."""
        points = drawing.object_corners(self.size) @ self.rotations.transpose(0, 2, 1) + self.positions[:, None]
        corners: dict[Value, Floats] = {}
        corners.update(zip(self.ids, points))
        return corners


class _Fit:
    """The fit of V poses of the bundle and M poses of its markers to N markers in images.

    All corners are converted to the camera of the first View. Poses change by small rotations, followed by
    translations: those of the bundle in the camera's frame, those of a marker in the bundle's.
    """

    def __init__(self, placed: _Placed, views: Sequence[View],
                 poses: Mapping[int, Sequence[pose.Solution]]) -> None:
        self.placed, self._camera = placed, views[0].camera
        index = {number: place for place, number in enumerate(placed.ids)}
        seen = {key: [number for number in views[key].markers if number in index] for key in poses}
        self.used = [key for key in poses if len(seen[key]) > 1]  # a single marker says nothing about the others
        pairs = [(row, number) for row, key in enumerate(self.used) for number in seen[key]]
        self._view: Integers = np.array([row for row, _ in pairs], int)
        self._marker: Integers = np.array([index[number] for _, number in pairs], int)
        self._corners, self._information = np.zeros((len(pairs), 4, 2)), np.zeros((len(pairs), 8, 8))
        for k, (row, number) in enumerate(pairs):
            self._corners[k], self._information[k] = self._converted(views[self.used[row]], number)
        # Of two poses of the bundle in an image the one that fits its new marker, too, is the start.
        starts = [self._better(views[key], poses[key], seen[key]) for key in self.used]
        self.rotations = np.array([one.rotation for one in starts]).reshape(-1, 3, 3)
        self.positions = np.array([one.position for one in starts]).reshape(-1, 3)
        self._scale = 8.0  # chi2 of a usual marker in an image

    def _converted(self, view: View, number: int) -> tuple[Floats, Floats]:
        one, camera = view.markers[number], view.camera
        rays = camera.to_rays(camera.to_ideal(one.corners))
        scale = np.tile(self._camera.focal / camera.focal, 4)
        covariance = np.eye(8) * CORNER_FLOOR ** 2 + (np.eye(8) * thresholds.DEFAULT_CORNER_ERROR ** 2
                                                      if one.information is None else np.linalg.inv(one.information))
        return rays * self._camera.focal + self._camera.centre, np.linalg.inv(covariance * np.outer(scale, scale))

    def _better(self, view: View, solutions: Sequence[pose.Solution], seen: Sequence[int]) -> pose.Solution:
        corners = self.placed.corners()
        points = np.concatenate([corners[number] for number in seen])
        ideal = np.concatenate([view.camera.to_ideal(view.markers[number].corners) for number in seen])

        def misfit(one: pose.Solution) -> float:
            error = pose.reprojection_error((points @ one.rotation.T)[None], one.position[None], ideal[None],
                                            view.camera)
            return float(np.median(np.abs(error)))
        return min(solutions, key=misfit)

    def run(self) -> float:
        """Fit, and return the cost: chi2 in units of the usual error, in which contradicting markers count little."""
        if not len(self._view):
            return math.inf
        with np.errstate(all='ignore'):
            self._scale = max(8.0, float(np.median(self._chi2())))
            damping, cost = 1e-3, self._cost()
            for _ in range(STEPS):
                before = self.rotations, self.positions, self.placed.rotations, self.placed.positions
                self._step(damping)
                after = self._cost()
                if not after < cost:
                    self.rotations, self.positions, self.placed.rotations, self.placed.positions = before
                    if damping > 1e4:
                        break
                    damping *= 10.0
                    continue
                settled = cost - after < SETTLED * (cost + 1.0)
                cost, damping = after, max(damping * 0.1, 1e-9)
                if settled:
                    break
            self._scale = max(8.0, float(np.median(self._chi2())))
        return cost

    def _turned(self) -> tuple[Floats, Floats]:
        """Return the corners (N, 4, 3) in their marker after its rotation, and in the camera before its shift."""
        own = drawing.object_corners(self.placed.size) @ self.placed.rotations[self._marker].transpose(0, 2, 1)
        points = own + self.placed.positions[self._marker][:, None]
        return own, points @ self.rotations[self._view].transpose(0, 2, 1)

    def _chi2(self) -> Floats:
        residual = pose.reprojection_error(self._turned()[1], self.positions[self._view], self._corners, self._camera)
        found: Floats = np.einsum('ni,nij,nj->n', residual, self._information, residual)
        return found

    def _cost(self) -> float:
        limit = OUTLIER ** 2
        total = float((limit * np.log1p(self._chi2() / self._scale / limit)).sum() * 8.0)
        return total if math.isfinite(total) else math.inf

    def _equations(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Return the normal equations.

        They are those of the views (V, 6, 6), of the markers (6M, 6M), of both (V, 6, 6M), and the gradients (V, 6),
        (6M,).
        """
        own, turned = self._turned()
        residual, by_view = pose.reprojection(turned, self.positions[self._view], self._corners, self._camera)
        by_point = (by_view[:, :, 3:] @ self.rotations[self._view]).reshape(len(own), 4, 2, 3)
        crossed = np.cross(np.eye(3), own[:, :, None]).transpose(0, 1, 3, 2)  # columns: axis x corner
        by_marker = np.concatenate([by_point @ crossed, by_point], -1).reshape(len(own), 8, 6)
        chi2 = np.einsum('ni,nij,nj->n', residual, self._information, residual)
        weights = 1 / (1 + chi2 / self._scale / OUTLIER ** 2) * 8.0 / self._scale
        weighted = self._information * weights[:, None, None]
        count, markers = len(self.used), len(self.placed.ids)
        h_view, g_view = np.zeros((count, 6, 6)), np.zeros((count, 6))
        h_marker, g_marker = np.zeros((markers, 6, 6)), np.zeros((markers, 6))
        mixed = np.zeros((count, markers, 6, 6))
        view_t, marker_t = by_view.transpose(0, 2, 1) @ weighted, by_marker.transpose(0, 2, 1) @ weighted
        np.add.at(h_view, self._view, view_t @ by_view)
        np.add.at(g_view, self._view, (view_t @ residual[..., None])[..., 0])
        np.add.at(h_marker, self._marker, marker_t @ by_marker)
        np.add.at(g_marker, self._marker, (marker_t @ residual[..., None])[..., 0])
        np.add.at(mixed, (self._view, self._marker), view_t @ by_marker)
        square = np.zeros((markers, 6, markers, 6))
        square[np.arange(markers), :, np.arange(markers)] = h_marker
        return (h_view, square.reshape(6 * markers, -1), mixed.transpose(0, 2, 1, 3).reshape(count, 6, -1), g_view,
                g_marker.ravel())

    def _step(self, damping: float) -> None:
        h_view, h_marker, mixed, g_view, g_marker = self._equations()
        h_view = h_view + np.eye(6) * (damping * h_view.diagonal(0, 1, 2)[:, None] + 1e-12)
        h_marker = h_marker + np.diag(damping * np.diag(h_marker) + 1e-12)
        try:
            inverse = np.linalg.inv(h_view)
            reduced = (h_marker - np.einsum('vij,vik,vkl->jl', mixed, inverse, mixed, optimize=True))[6:, 6:]
            right = (g_marker - np.einsum('vij,vik,vk->j', mixed, inverse, g_view, optimize=True))[6:]
            of_markers = np.concatenate([np.zeros(6), -np.linalg.solve(reduced, right)])  # the master stays
        except np.linalg.LinAlgError:
            return
        of_views = -(inverse @ (g_view + mixed @ of_markers)[..., None])[..., 0]
        of_markers = of_markers.reshape(-1, 6)
        self.rotations = pose.turned_by(of_views[:, :3], self.rotations)
        self.positions = self.positions + of_views[:, 3:]
        self.placed.rotations = pose.turned_by(of_markers[:, :3], self.placed.rotations)
        self.placed.positions = self.placed.positions + of_markers[:, 3:]

    def spread(self) -> dict[int, Spread]:
        """Return {id: Spread} of the markers."""
        h_view, h_marker, mixed, _, _ = self._equations()
        inverse = np.linalg.pinv(h_view)
        reduced = (h_marker - np.einsum('vij,vik,vkl->jl', mixed, inverse, mixed, optimize=True))[6:, 6:]
        variances = np.concatenate([np.zeros(6), np.diag(np.linalg.pinv(reduced)).clip(0)]).reshape(-1, 2, 3).sum(2)
        return {number: Spread(math.sqrt(shift), math.sqrt(turn))
                for number, (turn, shift) in zip(self.placed.ids, variances.tolist())}

    def _errors(self) -> Floats:
        residual = pose.reprojection_error(self._turned()[1], self.positions[self._view], self._corners, self._camera)
        errors: Floats = np.sqrt((residual ** 2).mean(1) * 2)
        return errors

    def error(self) -> float:
        """Return the median of the rms reprojection errors [px]."""
        return float(np.median(self._errors()))

    def odd(self) -> list[int]:
        """Return the ids of markers that contradict the others in more than a third of their images."""
        limit = np.maximum(thresholds.AGREES_PX, thresholds.AGREES_SHARE * homography.mean_side(self._corners))
        wrong = self._errors() > limit
        return [number for place, number in enumerate(self.placed.ids) if wrong[self._marker == place].mean() > 1 / 3]


def _same(view: View, other: View) -> bool:
    """Return whether two Views show the same markers at the same pixels."""
    return view.markers.keys() == other.markers.keys() and all(
        float(np.abs(view.markers[number].corners - other.markers[number].corners).max()) < MOVED
        for number in view.markers)


def _list(numbers: Sequence[int]) -> str:
    return ', '.join(map(str, sorted(numbers)))
