"""Compute one pose of a bundle from the corners of all its markers, without markers that contradict the others.

Camera frame: optical (x right, y down, z forward). Lengths in metres, angles in radians, images in pixels.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Iterable, Sequence

import numpy as np

from alvar_core import bundles
from alvar_core.arrays import Bools, Floats
from alvar_core.bundles import Bundle
from alvar_core.camera import Camera
from alvar_core.detection import homography, pose, thresholds
from alvar_core.detection.detection import Detection
from alvar_core.rotations import angle_between, quaternion_from_matrix


@dataclass
class BundlePose:
    """A bundle in the camera's frame.

    ``rotation`` (3, 3), ``position`` (3,) [m]; ``confidence``, 0 to 1, is that of its best marker; ``ambiguity``,
    ``ambiguous`` and ``solutions`` are those of Detection. ``error`` [px] is the rms reprojection error. ``used`` and
    ``rejected`` are the ids of the markers in the image that agree with the pose, and of those that do not.
    """

    bundle: Bundle
    rotation: Floats
    position: Floats
    confidence: float
    ambiguity: float
    ambiguous: bool
    error: float
    used: tuple[int | str, ...]
    rejected: tuple[int | str, ...]
    solutions: list[pose.Solution]

    @property
    def quaternion(self) -> Floats:
        """Return the orientation x y z w in the camera's optical frame."""
        return quaternion_from_matrix(self.rotation)


class BundleTracker:
    """Computes poses of bundles over frames; the last frame decides ambiguous poses. Not thread-safe."""

    def __init__(self, known: Iterable[Bundle]) -> None:
        """``known`` are the Bundles to search for."""
        self.known = list(known)
        self._last: dict[int, tuple[Floats, int]] = {}  # index in known: the last rotation, frames since

    def update(self, detections: Sequence[Detection], camera: Camera) -> list[BundlePose]:
        """Return the BundlePoses of the bundles with a marker in the next image, in the order of ``known``."""
        found = []
        for number, bundle in enumerate(self.known):
            rotation, age = self._last.get(number, (None, 0))
            one = solve(bundle, detections, camera, rotation)
            if one is not None:
                found.append(one)
                self._last[number] = one.rotation, 0
            elif age < thresholds.BUNDLE_MEMORY and rotation is not None:
                self._last[number] = rotation, age + 1
            else:
                self._last.pop(number, None)
        return found


def solve(bundle: Bundle, detections: Sequence[Detection], camera: Camera,
          last_rotation: Floats | None = None) -> BundlePose | None:
    """Return the BundlePose of a bundle; None if no pose fits, or none of its markers is among the Detections.

    ``last_rotation`` is that of the previous image; if the image does not decide between two poses, the one nearer to
    it is chosen.
    """
    seen = [d for d in detections if d.id in bundle.corners]
    if not seen:
        return None
    problem = _BundleProblem(bundle, seen, camera)
    with np.errstate(all='ignore'):
        rotations, positions = problem.refine_softly(*problem.hypotheses())
        errors = problem.errors(rotations, positions)
        best = int(np.argmax(problem.agreement(errors)))
        agree = errors[best] < problem.limit
        if not agree.any():
            return None
        solutions = problem.solutions(rotations, positions, agree)
    if not solutions:
        return None
    return _settled(bundle, seen, agree, solutions, last_rotation)


def _settled(bundle: Bundle, seen: Sequence[Detection], agree: Bools, solutions: list[pose.Solution],
             last_rotation: Floats | None) -> BundlePose:
    used = [d for d, good in zip(seen, agree) if good]
    share, ambiguous = pose.ambiguity(solutions, max(pose.DEGREES_OF_FREEDOM, 8 * len(used) - 6))
    if ambiguous and last_rotation is not None:
        last = last_rotation
        solutions = sorted(solutions, key=lambda s: angle_between(last, s.rotation))
    best, rejected = solutions[0], tuple(d.id for d, good in zip(seen, agree) if not good)
    return BundlePose(bundle, best.rotation, best.position, max(d.confidence for d in used), share, ambiguous,
                      best.error, tuple(d.id for d in used), rejected, solutions)


class _BundleProblem:
    """K markers of a bundle in an image. Poses of the bundle are in batches: (B, 3, 3) and (B, 3).

    ``limit`` (K,) [px] is the largest rms error of a marker that agrees with a pose.
    """

    def __init__(self, bundle: Bundle, seen: Sequence[Detection], camera: Camera) -> None:
        self._camera, self._seen = camera, seen
        self._places = [bundle.corners[d.id] for d in seen]
        self._points = np.concatenate(self._places)[None]  # (1, 4K, 3) m
        ideal = camera.to_ideal(np.array([d.corners for d in seen]))
        self._corners = ideal.reshape(1, -1, 2)
        self._side = homography.mean_side(ideal)
        self.limit = np.maximum(thresholds.AGREES_PX, thresholds.AGREES_SHARE * self._side)
        ids = list(bundle.corners)
        order = np.array([ids.index(d.id) for d in seen])
        self._trust = 1 + thresholds.FIRST_TRUST * (1 - order / len(ids))  # prefers the first marker of the file
        self._information = np.array([_information(d, s) for d, s in zip(seen, self._side)])

    def hypotheses(self) -> tuple[Floats, Floats]:
        """Return the poses of the bundle that follow from both solutions of each marker; at most MAX_HYPOTHESES."""
        rotations, positions = [], []
        for detection, place in zip(self._seen, self._places):
            turn, centre = bundles.marker_pose(place)
            poses = [(s.rotation, s.position) for s in detection.solutions]
            for rotation, position in poses or [(detection.rotation, detection.position)]:
                rotations.append(rotation @ turn.T)
                positions.append(position - rotations[-1] @ centre)
        return self._best(np.array(rotations), np.array(positions))

    def _best(self, rotations: Floats, positions: Floats) -> tuple[Floats, Floats]:
        relative = self.errors(rotations, positions) / (thresholds.SOFT_SHARES[0] * self._side)
        best = np.argsort(-(1 / (1 + relative ** 2)).sum(1), kind='stable')[:thresholds.MAX_HYPOTHESES]
        return rotations[best], positions[best]

    def _turned(self, rotations: Floats) -> Floats:
        return self._points @ rotations.transpose(0, 2, 1)

    def _residuals(self, rotations: Floats, positions: Floats) -> Floats:
        """Return the reprojection errors (B, 8K) [px]."""
        return pose.reprojection_error(self._turned(rotations), positions, self._corners, self._camera)

    def errors(self, rotations: Floats, positions: Floats) -> Floats:
        """Return the rms reprojection error (B, K) [px] of each marker; inf if a corner lies behind the camera."""
        residual = self._residuals(rotations, positions).reshape(len(rotations), -1, 8)
        error = np.sqrt((residual ** 2).mean(2) * 2)
        depth = (self._turned(rotations) + positions[:, None])[..., 2].reshape(len(rotations), -1, 4)
        return np.where((depth > 0).all(2) & np.isfinite(error), error, np.inf)

    def agreement(self, errors: Floats) -> Floats:
        """Return a score (B,) of how many markers agree, and how well."""
        return np.where(errors < self.limit, 1 - (errors / self.limit) ** 2, 0) @ self._trust

    def refine_softly(self, rotations: Floats, positions: Floats) -> tuple[Floats, Floats]:
        """Return the poses unchanged, and after steps in which markers that do not fit count less and less (2B)."""
        first = rotations, positions
        for share in thresholds.SOFT_SHARES:
            scale = np.maximum(thresholds.AGREES_PX, share * self._side)
            weights = 1 / (1 + (self.errors(rotations, positions) / scale) ** 2) ** 2
            rotations, positions = self._step(rotations, positions, weights)
        return np.concatenate([first[0], rotations]), np.concatenate([first[1], positions])

    def _step(self, rotations: Floats, positions: Floats, weights: Floats) -> tuple[Floats, Floats]:
        """Return the poses after a Gauss-Newton step with weights (B, K); poses without a valid step do not change."""
        residual, jacobian = pose.reprojection(self._turned(rotations), positions, self._corners, self._camera)
        blocks = jacobian.reshape(len(residual), -1, 8, 6)
        weighted = np.einsum('bkij,kil,bk->bklj', blocks, self._information, weights).reshape(jacobian.shape)
        transposed = weighted.transpose(0, 2, 1)
        normal = transposed @ jacobian
        normal = normal + np.eye(6) * (1e-6 * np.einsum('bii->bi', normal) + 1e-12)[:, None]
        good = np.isfinite(normal).all((1, 2)) & np.isfinite(residual).all(1) & (weights.max(1) > 1e-3)
        rotations, positions = rotations.copy(), positions.copy()
        step = -np.linalg.solve(normal[good], transposed[good] @ residual[good][:, :, None])[:, :, 0]
        rotations[good] = pose.turned_by(step[:, :3], rotations[good])
        positions[good] = positions[good] + step[:, 3:]
        return rotations, positions

    def solutions(self, rotations: Floats, positions: Floats, agree: Bools) -> list[pose.Solution]:
        """Return the one or two distinct poses, best first, that fit all agreeing markers."""
        weights = np.broadcast_to(agree.astype(float), (len(rotations), len(agree)))
        for _ in range(thresholds.FINAL_STEPS):
            rotations, positions = self._step(rotations, positions, weights)
        errors = self.errors(rotations, positions)[:, agree]
        residual = self._residuals(rotations, positions).reshape(len(rotations), -1, 8)[:, agree]
        chi2 = np.einsum('bki,kij,bkj->b', residual, self._information[agree], residual)
        chi2[~np.isfinite(errors).all(1)] = np.inf
        found: list[pose.Solution] = []
        for b in np.argsort(chi2):
            if not np.isfinite(chi2[b]) or len(found) == 2:
                break
            if all(angle_between(rotations[b], s.rotation) >= thresholds.SAME_ROTATION for s in found):
                rms = float(np.sqrt((errors[b] ** 2).mean()))
                found.append(pose.Solution(rotations[b], positions[b], rms, float(chi2[b])))
        return found


def _information(detection: Detection, side: float) -> Floats:
    """Return the inverse covariance (8, 8) [1/px^2] of a marker's corners, with the errors of the bundle file."""
    known = detection.information
    covariance = np.eye(8) * thresholds.DEFAULT_CORNER_ERROR ** 2 if known is None else np.linalg.inv(known)
    return np.linalg.inv(covariance + np.eye(8) * (thresholds.PLACE_ERROR * side) ** 2)
