"""Improve the poses of markers with the points of a depth camera: a plane is fitted to the points on each marker.

An image measures the direction to a marker very well, and its distance well if the marker is large. It measures the
tilt of a small or frontal marker badly, and sometimes cannot tell two tilts apart. Points measure the plane of the
marker. Both are weighted by their errors, and one pose is fitted to both.

A plane is three numbers q: of each of its points p, q @ p = 1. So 1 / z = q @ (x / z, y / z, 1) is linear in the ray,
and the noise of stereo and structured-light cameras, which measure 1 / z, is the same at all distances.

Camera frame: optical (x right, y down, z forward). Lengths in metres, angles in radians, images in pixels.
"""
from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol, Sequence

import cv2
import numpy as np

from alvar_core import drawing
from alvar_core.arrays import Bools, Floats
from alvar_core.camera import Camera
from alvar_core.detection import pose, thresholds
from alvar_core.detection.detection import Detection
from alvar_core.detection.pose import Solution

NOISE = 0.002  # [m] standard deviation of a depth at 1 m; it grows with the square of the distance (Kinect: 0.002)
DEPTH_RESOLUTION = 0.0005  # [m] and is never less than this
SCALE_ERROR = 0.005  # of the distance: systematic, the same for all points
TILT_ERROR = math.radians(0.5)  # of the plane: systematic
CORRELATED = 16.0  # pixels that share one error, because depth cameras compare windows
EDGE = 1.5  # [px] from the marker's outline: points there may belong to what is behind it
MIN_POINTS, MIN_SHARE = 20, 0.3  # points with a depth on the marker; share of its pixels
MIN_AGREE = 0.6  # share of these that lie on one plane
MAX_USED = 600  # points; of more, every n-th is used
MAX_SPREAD = 10.0  # times the expected noise: points that differ more from their plane are not one
STARTS, FITS = 40, 5  # planes through three points, of which the best is improved some times
OUTLIER = 4.5  # standard deviations (Tukey's weights)
LEAST_INCIDENCE = 0.1  # cosine of the angle at which the plane is seen: flatter ones are no measurement
MAX_SURPLUS = 60.0  # chi2 that the plane may add: beyond, image and points contradict each other
SAG_RMS = 0.298  # rms of the distances of a parabola from the nearest plane, as a share of its height
FLAT_CHI2, SEEN_CHI2 = 16.0, 50.0  # of a curved surface: points on a flat one (3 parameters); expected, if it is bent
LEAST_MISFIT = 0.1  # of the expected one: it has only two degrees of freedom
STEPS, SETTLED = 12, 1e-9  # of the fit of a pose; relative change of chi2

NO_DEPTH, NO_PLANE, BENT = 'no depth', 'no plane', 'bent'
BOTH, CLOUD = 'both', 'cloud'


class Points(Protocol):
    """Points that are ordered like the pixels of an image."""

    def window(self, top: int, bottom: int, left: int, right: int) -> Floats:
        """Return the points (rows, columns, 3) [m] in the camera's frame; where there is none, not finite or z <= 0."""


class Plane(NamedTuple):
    """A plane: ``q`` (3,) [1/m] with its ``information`` (3, 3) [m^2], the inverse covariance.

    ``curved`` is chi2 by which a curved surface would fit better (3 more parameters); ``sharpness`` [1/m] is the square
    root of chi2 for points that are off by 1 m: what is smaller than a few times its inverse is not seen.
    """

    q: Floats
    information: Floats
    curved: float = 0.0
    sharpness: float = 0.0


class Observation(NamedTuple):
    """A marker with corners ``points`` (4, 3) [m] in the frame of the object that it belongs to.

    ``corners`` (4, 2) [ideal px]; ``information`` (8, 8) [1/px^2]; ``plane``: that of its points, or None.
    """

    points: Floats
    corners: Floats
    information: Floats
    plane: Plane | None


@dataclass(frozen=True)
class Measured:
    """A Detection after the use of points.

    ``source``: BOTH, CLOUD (they contradict each other, and the points count), or why only the image counts: NO_DEPTH,
    NO_PLANE, BENT (the image has measured how much; its corners are not those of a flat marker). ``plane`` is that of
    its points; ``size`` [m]: the side that the points show, if they contradict.
    """

    detection: Detection
    source: str
    plane: Plane | None = None
    size: float = 0.0


def plane_on(points: Points, corners: Floats, shape: tuple[int, ...], noise: float = NOISE) -> Plane | str:
    """Return the Plane of the points inside ``corners`` (4, 2) [real px] of an image of this shape (height, width).

    ``noise`` [m] is the standard deviation of a depth at 1 m. Return NO_DEPTH or NO_PLANE if the points show none.
    """
    inside = _inside(points, corners, shape)
    valid = _valid(inside)
    if valid.sum() < MIN_POINTS or valid.mean() < MIN_SHARE:
        return NO_DEPTH
    chosen = inside[valid].astype(np.float64)
    chosen = chosen[::max(1, -(-len(chosen) // MAX_USED))]
    rays = chosen / chosen[:, 2:]
    inverse = 1.0 / chosen[:, 2]
    sigma = np.maximum(noise * chosen[:, 2] ** 2, DEPTH_RESOLUTION) * inverse ** 2
    q = _start(rays, inverse, sigma)
    if q is None:
        return NO_PLANE
    spread, weights = 1.0, np.ones(len(rays))
    for _ in range(FITS):
        residual = (inverse - rays @ q) / sigma
        spread = max(1.0, 1.4826 * float(np.median(np.abs(residual))))
        weights = np.clip(1 - (residual / (OUTLIER * spread)) ** 2, 0, None) ** 2
        weighted = rays * (weights / sigma ** 2)[:, None]
        normal = weighted.T @ rays
        try:
            q = np.linalg.solve(normal, weighted.T @ inverse)
        except np.linalg.LinAlgError:
            return NO_PLANE
    middle = rays.mean(0)
    cosine = float(q @ middle / (np.linalg.norm(q) * np.linalg.norm(middle)))
    if spread > MAX_SPREAD or (weights > 0.1).mean() < MIN_AGREE or not cosine > LEAST_INCIDENCE:
        return NO_PLANE
    independent = valid.sum() / len(rays) / CORRELATED / spread ** 2
    covariance = np.linalg.pinv(normal * independent) + _systematic(q, middle)
    depths = sigma * chosen[:, 2] ** 2  # [m] standard deviations
    return Plane(q, np.linalg.inv(covariance), independent * _curved(rays, (inverse - rays @ q) / sigma, weights),
                 math.sqrt(independent * float((weights / depths ** 2).sum())))


def _curved(rays: Floats, residual: Floats, weights: Floats) -> float:
    """Return by how much a quadratic surface reduces the sum of the squared residuals (N,) of a plane."""
    x, y = ((rays[:, :2] - rays[:, :2].mean(0)) / rays[:, :2].std(0)).T
    root = np.sqrt(weights)
    matrix = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], 1) * root[:, None]
    left = root * residual - matrix @ np.linalg.lstsq(matrix, root * residual, rcond=None)[0]
    return max(0.0, float(weights @ residual ** 2 - left @ left))


def points_on(points: Points, corners: Floats, shape: tuple[int, ...]) -> Floats:
    """Return the points (N, 3) [m] that plane_on() uses."""
    inside = _inside(points, corners, shape)
    chosen: Floats = inside[_valid(inside)]
    return chosen[::max(1, -(-len(chosen) // MAX_USED))]


def _valid(points: Floats) -> Bools:
    """Return which points (N,) exist."""
    valid: Bools = np.isfinite(points).all(1) & (np.nan_to_num(points[:, 2]) > 0)
    return valid


def _inside(points: Points, corners: Floats, shape: tuple[int, ...]) -> Floats:
    """Return the points (N, 3) of the pixels inside the outline, except those near to it."""
    low = np.floor(np.clip(corners.min(0), 0, [shape[1], shape[0]])).astype(int)
    high = np.ceil(np.clip(corners.max(0) + 1, 0, [shape[1], shape[0]])).astype(int)
    if (high - low < 3).any():
        return np.zeros((0, 3))
    window = points.window(low[1], high[1], low[0], high[0])
    mask = np.zeros(window.shape[:2], np.uint8)
    cv2.fillConvexPoly(mask, np.round((corners - low) * 16).astype(np.int32), 1, cv2.LINE_8, 4)
    padded = cv2.copyMakeBorder(mask, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=0)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, 3)[1:-1, 1:-1]
    chosen: Floats = window[away > EDGE]
    return chosen


def _start(rays: Floats, inverse: Floats, sigma: Floats) -> Floats | None:
    """Return the best of some planes through three points, by the median of the distances from it; None if all fail."""
    rng = np.random.default_rng(len(rays))  # the same points give the same plane
    triples = rng.integers(0, len(rays), (STARTS, 3))
    matrices = rays[triples]
    usable = np.abs(np.linalg.det(matrices)) > 1e-12
    if not usable.any():
        return None
    planes = np.linalg.solve(matrices[usable], inverse[triples[usable]][..., None])[..., 0]
    errors = np.median(np.abs(inverse - planes @ rays.T) / sigma, axis=1)
    best: Floats = planes[int(np.argmin(errors))]
    return best


def _systematic(q: Floats, middle: Floats) -> Floats:
    """Return the covariance (3, 3) of the systematic errors of a plane that is seen along the ray ``middle``."""
    across = np.eye(3) - np.outer(middle, middle) / (middle @ middle)
    covariance: Floats = SCALE_ERROR ** 2 * np.outer(q, q) + TILT_ERROR ** 2 * float(q @ q) * across
    return covariance + 1e-12 * np.eye(3)


def measured(detection: Detection, size: float, camera: Camera, plane: Plane | str) -> Measured:
    """Return a Detection of a marker, ``size`` [m] wide, with the pose that fits image and plane.

    Where they agree, the pose is not doubtful. The corners count the more, the better they fit a square.
    """
    if isinstance(plane, str):
        return Measured(detection, plane)
    if detection.bend and not _disproved(detection.bend, size, plane):
        return Measured(detection, BENT)
    observation = observed(detection, drawing.object_corners(size), camera, plane)
    starts = detection.solutions or [Solution(detection.rotation, detection.position, detection.error, 0.0)]
    if detection.bend:  # the poses of a cylinder are not those of a square
        starts = [*pose.solve(observation.corners[None], [size], camera, observation.information[None])[0], *starts]
    misfit = min(_chi2([observation._replace(plane=None)], each.rotation, each.position, camera) for each in starts)
    if not misfit < math.inf:
        return _by_points(detection, observation, plane, camera)
    observation = observation._replace(
        information=_rated(observation.information, misfit / pose.DEGREES_OF_FREEDOM))
    alone = observation._replace(plane=None)
    found = sorted((fitted([observation], each.rotation, each.position, camera) for each in starts),
                   key=lambda s: s.chi2)
    best = found[0]
    image = min(_chi2([alone], each.rotation, each.position, camera) for each in starts)
    if best.chi2 - image > MAX_SURPLUS or not np.isfinite(best.chi2):
        return _by_points(detection, observation, plane, camera)
    share, ambiguous = pose.ambiguity(found, pose.DEGREES_OF_FREEDOM + 3)
    return Measured(replace(detection, rotation=best.rotation, position=best.position, error=best.error,
                            solutions=found[:2], ambiguity=share, ambiguous=ambiguous, doubtful=False, bend=0.0,
                            information=observation.information), BOTH, plane)


def _rated(information: Floats, misfit: float) -> Floats:
    """Return the information of corners whose chi2 as a square is ``misfit`` times the expected one.

    Those that fit badly count less. The detector never trusts corners more than to CORNER_MODEL_ERROR; of those that
    fit well, this part of their errors is smaller.
    """
    if misfit >= 1:
        return information / misfit
    covariance = np.linalg.inv(information)
    spare = min(thresholds.CORNER_MODEL_ERROR ** 2, float(np.linalg.eigvalsh(covariance)[0]))
    rated: Floats = np.linalg.inv(covariance - np.eye(8) * spare * (1 - max(misfit, LEAST_MISFIT)))
    return rated


def _disproved(bend: float, size: float, plane: Plane) -> bool:
    """Return whether a paper that turns by ``bend`` [rad] over ``size`` [m] would be seen in the points, and is not."""
    sag = size * abs(bend) / 8 * SAG_RMS
    return plane.curved < FLAT_CHI2 and (sag * plane.sharpness) ** 2 > SEEN_CHI2


def observed(detection: Detection, points: Floats, camera: Camera, plane: Plane | None) -> Observation:
    """Return the Observation of a Detection whose corners are ``points`` (4, 3) [m] of an object."""
    information = detection.information
    if information is None:
        information = np.eye(8) / thresholds.DEFAULT_CORNER_ERROR ** 2
    return Observation(points, camera.to_ideal(detection.corners), information, plane)


def _by_points(detection: Detection, observation: Observation, plane: Plane, camera: Camera) -> Measured:
    """Return the Detection with the pose that the points show, whatever the size of the marker is."""
    rotation, position, size = pose_on(plane, camera.to_rays(observation.corners))
    only = Solution(rotation, position, detection.error, 0.0)
    return Measured(replace(detection, rotation=rotation, position=position, solutions=[only], ambiguity=0.0,
                            ambiguous=False, confidence=0.5 * detection.confidence), CLOUD, plane, size)


def pose_on(plane: Plane, rays: Floats) -> tuple[Floats, Floats, float]:
    """Return rotation (3, 3), position (3,) [m] and side [m] of a marker on a plane, its corners along rays (4, 2)."""
    along = np.column_stack([rays, np.ones(4)])
    corners = along / (along @ plane.q)[:, None]
    z = -plane.q / np.linalg.norm(plane.q)
    x = corners[1] + corners[2] - corners[0] - corners[3]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    side = float(np.mean(np.linalg.norm(np.roll(corners, -1, 0) - corners, axis=1)))
    return np.stack([x, np.cross(z, x), z], 1), corners.mean(0), side


def fitted(observations: Sequence[Observation], rotation: Floats, position: Floats, camera: Camera) -> Solution:
    """Return the pose of an object that fits all observations of its markers best, from a start value on."""
    chi2, normal, gradient, error = _equations(observations, rotation, position, camera)
    damping = 1e-6
    for _ in range(STEPS):
        try:
            step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), gradient)
        except np.linalg.LinAlgError:
            break
        turned, moved = pose.turned_by(step[None, :3], rotation[None])[0], position + step[3:]
        after = _equations(observations, turned, moved, camera)
        if not after[0] < chi2:
            if damping > 1e3:
                break
            damping *= 30.0
            continue
        settled = chi2 - after[0] < SETTLED * (chi2 + 1.0)
        rotation, position, damping = turned, moved, damping * 0.2
        chi2, normal, gradient, error = after
        if settled:
            break
    return Solution(rotation, position, error, chi2)


def _chi2(observations: Sequence[Observation], rotation: Floats, position: Floats, camera: Camera) -> float:
    return _equations(observations, rotation, position, camera)[0]


def _equations(observations: Sequence[Observation], rotation: Floats, position: Floats,
               camera: Camera) -> tuple[float, Floats, Floats, float]:
    """Return chi2, normal matrix (6, 6), gradient (6,) and rms reprojection error [px] of a pose.

    They are those of a small rotation, followed by a translation; chi2 is inf if a marker is behind the camera.
    """
    chi2, squares, normal, gradient = 0.0, 0.0, np.zeros((6, 6)), np.zeros(6)
    for one in observations:
        turned = one.points @ rotation.T
        if not (turned[:, 2] + position[2] > 1e-6).all():
            return math.inf, normal, gradient, math.inf
        residual, jacobian = pose.reprojection(turned[None], position[None], one.corners[None], camera)
        parts = [(residual[0], jacobian[0], one.information)]
        squares += float(residual[0] @ residual[0])
        if one.plane is not None:
            parts.append((*_plane_equations(turned, position, one.plane), one.plane.information))
        for r, j, information in parts:
            weighted = j.T @ information
            chi2 += float(r @ information @ r)
            normal += weighted @ j
            gradient += weighted @ r
    return chi2, normal, gradient, math.sqrt(squares / (4 * len(observations)))


def _plane_equations(turned: Floats, position: Floats, plane: Plane) -> tuple[Floats, Floats]:
    """Return the difference (3,) of the marker's plane from the measured one, and its derivative (3, 6)."""
    normal = np.cross(turned[1] - turned[2], turned[3] - turned[2])
    normal = normal / np.linalg.norm(normal)
    distance = float(normal @ (turned.mean(0) + position))
    if abs(distance) < 1e-9:
        return np.full(3, 1e6), np.zeros((3, 6))
    # A turn t changes the normal by t x n and the distance by t . (n x position), a shift s the distance by n . s.
    by_turn = np.array([[0, normal[2], -normal[1]], [-normal[2], 0, normal[0]], [normal[1], -normal[0], 0]])
    of_distance = np.concatenate([np.cross(normal, position), normal])
    jacobian = np.concatenate([by_turn, np.zeros((3, 3))], 1) / distance
    return normal / distance - plane.q, jacobian - np.outer(normal, of_distance) / distance ** 2
