"""One pose of a bundle from the corners of all its markers in a picture; one that contradicts the others is left out.

Camera frame: optical (x right, y down, z forward).  Lengths in metres, angles in radians, pictures in pixels.
"""
from dataclasses import dataclass

import cv2
import numpy as np

from alvar_core import bundles
from alvar_core.detection import homography, pose
from alvar_core.rotations import angle_between, quaternion_from_matrix

# Agreement: a marker whose corners lie this near (rms) to where the bundle's pose puts them, px or parts of its side.
AGREES_PX, AGREES_SHARE = 1.0, 0.05
SOFT_SHARES = (0.6, 0.3, 0.15, 0.08, 0.05, 0.05)  # parts of the side: the same while the pose is found, step by step
FILE_ERROR = 0.002  # parts of the side: how exactly the places of the markers are known at best
FINAL_STEPS = 4
MOST_HYPOTHESES = 8
MEMORY_FRAMES = 10


@dataclass
class BundlePose:
    """A bundle in the camera's frame.

    rotation (3, 3), position (3,) m; confidence 0..1 of its best marker; ambiguity 0..0.5, ambiguous and solutions as
    of detector.Detection; error: rms reprojection error, px; used, rejected: ids of the markers in the picture that
    agree with the pose, and of those that do not.
    """

    bundle: object
    rotation: np.ndarray
    position: np.ndarray
    confidence: float
    ambiguity: float
    ambiguous: bool
    error: float
    used: tuple
    rejected: tuple
    solutions: list

    @property
    def quaternion(self):
        """Orientation x y z w in the camera's optical frame."""
        return quaternion_from_matrix(self.rotation)


class BundleTracker:
    """Poses of bundles over frames: what one picture leaves ambiguous is settled by the last one.  One thread."""

    def __init__(self, known):
        """known: the Bundles."""
        self.known = list(known)
        self._last = {}

    def update(self, detections, camera):
        """Return the BundlePoses of the next picture, of bundles with a marker in it, in the order of `known`."""
        found = []
        for number, bundle in enumerate(self.known):
            rotation, age = self._last.get(number, (None, 0))
            one = solve(bundle, detections, camera, rotation)
            if one is not None:
                found.append(one)
                self._last[number] = one.rotation, 0
            elif age < MEMORY_FRAMES and rotation is not None:
                self._last[number] = rotation, age + 1
            else:
                self._last.pop(number, None)
        return found


def solve(bundle, detections, camera, last_rotation=None):
    """Return the BundlePose of a bundle, None if none of its markers is among the Detections of a picture.

    last_rotation: of the picture before; of two poses that the picture alone does not tell apart the one nearer to it
    is taken.
    """
    seen = [d for d in detections if d.id in bundle.corners]
    if not seen:
        return None
    view = _View(bundle, seen, camera)
    with np.errstate(all='ignore'):
        rotations, positions = view.refine_softly(*view.hypotheses())
        errors = view.errors(rotations, positions)
        best = int(np.argmax(view.agreement(errors)))
        agree = errors[best] < view.limit
        if not agree.any():
            return None
        solutions = view.solutions(rotations, positions, agree)
    if not solutions:
        return None
    return _settled(bundle, seen, agree, solutions, last_rotation)


def _settled(bundle, seen, agree, solutions, last_rotation):
    used = [d for d, good in zip(seen, agree) if good]
    share, ambiguous = pose.ambiguity(solutions, max(pose.DEGREES_OF_FREEDOM, 8 * len(used) - 6))
    if ambiguous and last_rotation is not None:
        solutions = sorted(solutions, key=lambda s: angle_between(last_rotation, s.rotation))
    best, rejected = solutions[0], tuple(d.id for d, good in zip(seen, agree) if not good)
    return BundlePose(bundle, best.rotation, best.position, max(d.confidence for d in used), share, ambiguous,
                      best.error, tuple(d.id for d in used), rejected, solutions)


class _View:
    """K markers of a bundle as seen in a picture.  Poses of it come in batches: (B, 3, 3) and (B, 3)."""

    def __init__(self, bundle, seen, camera):
        self.camera, self.seen = camera, seen
        self.places = [bundle.corners[d.id] for d in seen]
        self.points = np.concatenate(self.places)[None]
        ideal = camera.to_ideal(np.array([d.corners for d in seen]))
        self.corners = ideal.reshape(1, -1, 2)
        self.side = np.sqrt(np.abs(homography.area(ideal)))
        self.limit = np.maximum(AGREES_PX, AGREES_SHARE * self.side)
        order = [list(bundle.corners).index(d.id) for d in seen]
        self.trust = 1 + 0.1 * (1 - np.array(order) / len(bundle.corners))  # of two that disagree the first of the file
        self.information = np.array([_information(d, s) for d, s in zip(seen, self.side)])

    def hypotheses(self):
        """The bundle's pose after each marker alone, from both of its solutions; of many the MOST_HYPOTHESES best."""
        rotations, positions = [], []
        for detection, place in zip(self.seen, self.places):
            turn, centre = bundles.marker_pose(place)
            for solution in detection.solutions or [detection]:
                rotations.append(solution.rotation @ turn.T)
                positions.append(solution.position - rotations[-1] @ centre)
        rotations, positions = np.array(rotations), np.array(positions)
        good = (1 / (1 + (self.errors(rotations, positions) / (SOFT_SHARES[0] * self.side)) ** 2)).sum(1)
        best = np.argsort(-good, kind='stable')[:MOST_HYPOTHESES]
        return rotations[best], positions[best]

    def _residuals(self, rotations, positions):
        """Reprojection errors (B, 8K) px and their derivatives (B, 8K, 6) by a small turn and a shift."""
        turned = self.points @ rotations.transpose(0, 2, 1)
        p, camera = turned + positions[:, None], self.camera
        uv = p[..., :2] / p[..., 2:]
        residual = uv * [camera.fx, camera.fy] + [camera.cx, camera.cy] - self.corners
        by_place = np.zeros(p.shape[:2] + (2, 3))
        by_place[..., 0, 0], by_place[..., 1, 1], by_place[..., 2] = 1, 1, -uv
        by_place *= np.array([[camera.fx], [camera.fy]]) / p[..., 2, None, None]
        by_turn = np.cross(turned[..., None, :], by_place)  # d(turned) = turn x turned
        jacobian = np.concatenate([by_turn, by_place], -1)
        return residual.reshape(len(p), -1), jacobian.reshape(len(p), -1, 6)

    def errors(self, rotations, positions):
        """rms reprojection error (B, K) px of each marker; infinite where a corner lies behind the camera."""
        residual, _ = self._residuals(rotations, positions)
        error = np.sqrt((residual.reshape(len(residual), -1, 8) ** 2).mean(2) * 2)
        depth = (self.points @ rotations.transpose(0, 2, 1) + positions[:, None])[..., 2].reshape(len(residual), -1, 4)
        return np.where((depth > 0).all(2) & np.isfinite(error), error, np.inf)

    def agreement(self, errors):
        """How many markers agree, exact agreement counting more (B,)."""
        return np.where(errors < self.limit, 1 - (errors / self.limit) ** 2, 0) @ self.trust

    def refine_softly(self, rotations, positions):
        """The poses as they are, and after steps that let markers that do not fit count less and less (2B)."""
        first = rotations, positions
        for share in SOFT_SHARES:
            scale = np.maximum(AGREES_PX, share * self.side)
            weights = 1 / (1 + (self.errors(rotations, positions) / scale) ** 2) ** 2
            rotations, positions = self._step(rotations, positions, weights)
        return np.concatenate([first[0], rotations]), np.concatenate([first[1], positions])

    def _step(self, rotations, positions, weights):
        """One Gauss-Newton step with weights (B, K) of the markers; where it leads nowhere, none."""
        residual, jacobian = self._residuals(rotations, positions)
        blocks = jacobian.reshape(len(residual), -1, 8, 6)
        weighted = np.einsum('bkij,kil,bk->bklj', blocks, self.information, weights).reshape(jacobian.shape)
        turned = weighted.transpose(0, 2, 1)
        normal = turned @ jacobian
        normal = normal + np.eye(6) * (1e-6 * np.einsum('bii->bi', normal) + 1e-12)[:, None]
        good = np.isfinite(normal).all((1, 2)) & np.isfinite(residual).all(1) & (weights.max(1) > 1e-3)
        rotations, positions = rotations.copy(), positions.copy()
        step = -np.linalg.solve(normal[good], turned[good] @ residual[good][:, :, None])[:, :, 0]
        turns = np.array([cv2.Rodrigues(turn)[0] for turn in step[:, :3]]).reshape(-1, 3, 3)
        rotations[good] = turns @ rotations[good]
        positions[good] = positions[good] + step[:, 3:]
        return rotations, positions

    def solutions(self, rotations, positions, agree):
        """The one or two distinct poses (pose.Solution, best first) that all agreeing markers allow."""
        weights = np.broadcast_to(agree.astype(float), (len(rotations), len(agree)))
        for _ in range(FINAL_STEPS):
            rotations, positions = self._step(rotations, positions, weights)
        errors = self.errors(rotations, positions)[:, agree]
        residual = self._residuals(rotations, positions)[0].reshape(len(rotations), -1, 8)[:, agree]
        chi2 = np.einsum('bki,kij,bkj->b', residual, self.information[agree], residual)
        chi2[~np.isfinite(errors).all(1)] = np.inf
        found = []
        for b in np.argsort(chi2):
            if not np.isfinite(chi2[b]) or len(found) == 2:
                break
            if all(angle_between(rotations[b], s.rotation) >= pose.SAME_ROTATION for s in found):
                rms = float(np.sqrt((errors[b] ** 2).mean()))
                found.append(pose.Solution(rotations[b], positions[b], rms, float(chi2[b])))
        return found


def _information(detection, side):
    """Inverse covariance (8, 8) of a marker's corners, 1/px^2: as detected, and what the bundle's file is off."""
    known = detection.features.get('information')
    covariance = np.eye(8) * pose.DEFAULT_CORNER_SIGMA ** 2 if known is None else np.linalg.inv(known)
    return np.linalg.inv(covariance + np.eye(8) * (FILE_ERROR * side) ** 2)
