"""The bench of poses from image and points: their errors, compared with the image alone and the points alone.

A marker of 10 cm is rendered at several distances and tilts, in sets that differ in light and in the noise of the
points. Points have the noise of a Kinect or RealSense: a standard deviation that grows with the square of the distance
and is correlated between neighbouring pixels, a scale error, and an error of the calibration between the two cameras.
No node is needed.
"""
import itertools
import time

import cv2
import numpy as np

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import depth
from alvar_core.detection.detector import Detector
from figures import Figure, Target, median, p95
from rostest_support.marker_scenes import Placed, Scene, image_of
from session import Measurement

NEEDS_NODE = False
SIZE = 0.1  # [m] of the marker
DISTANCES, TILTS = (0.5, 1.0, 2.0), (0.0, 15.0, 40.0)  # [m], [degrees]
SETS = {  # noise [greys], blur [px], white minus black [greys]; standard deviation [m] of a depth at 1 m
    'bright': (2.0, 0.6, 160.0, 0.002), 'bright, coarse points': (2.0, 0.6, 160.0, 0.005),
    'noisy': (5.0, 0.8, 120.0, 0.002), 'dim': (8.0, 1.4, 60.0, 0.002), 'dim, fine points': (8.0, 1.4, 60.0, 0.001)}
FULL, QUICK = 5, 1  # markers at each distance and tilt
SMOOTH = 1.2  # [px] over which errors of depths are correlated
SCALE_ERROR, SHIFT = 0.005, 0.3  # of the depth; [px] between image and points
HARDLY_WORSE = 1.25  # times the error of the image alone: in bright light, points only add noise
WALL = 4.0  # [m] behind the markers
HEIGHT, WIDTH = 480, 640
CAMERA = default_camera(WIDTH, HEIGHT)
GRID = np.stack(np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT)), -1).astype(float)
SOURCES = {'image': 'image alone', 'points': 'points alone', 'both': 'both'}


class Points:
    """The points of a depth camera with ``noise`` [m at 1 m] that sees a marker before a wall; see depth.Points."""

    def __init__(self, rng, marker, noise):
        rays = np.concatenate([CAMERA.to_rays(GRID), np.ones((HEIGHT, WIDTH, 1))], -1)
        seen = np.concatenate([CAMERA.to_rays(GRID + rng.normal(0, SHIFT, 2)), np.ones((HEIGHT, WIDTH, 1))], -1)
        normal = marker.rotation[:, 2]
        z = (normal @ marker.position) / (seen @ normal)
        local = (seen * z[..., None] - marker.position) @ marker.rotation
        z = np.where((np.abs(local[..., :2]).max(-1) < 0.65 * marker.size) & (z > 0), z, WALL)
        errors = cv2.GaussianBlur(rng.normal(size=z.shape), (0, 0), SMOOTH)
        z = z * rng.normal(1, SCALE_ERROR) + errors / errors.std() * noise * z * z
        self._points = (rays * z[..., None]).astype(np.float32)

    def window(self, top, bottom, left, right):
        """Return the points of a part of the image."""
        return self._points[top:bottom, left:right].astype(float)


def poses(_subject, scale):
    """Return the errors of the poses by source, and the time that points take for each marker."""
    cv2.setNumThreads(1)
    rng, detector, samples = np.random.default_rng(14), Detector(SIZE), {}
    for name, (noise, blur, contrast, of_points) in SETS.items():
        for distance, tilt in itertools.product(DISTANCES, TILTS * scale):
            marker = _marker(rng, distance, np.radians(tilt), contrast)
            image = image_of(rng, CAMERA, [marker], Scene(width=WIDTH, height=HEIGHT, noise=noise, blur=blur))
            found = [each for each in detector.detect(image, CAMERA) if each.id == marker.id]
            samples.setdefault(f'found_{name}', []).append(100.0 * bool(found))
            if found:
                _measure(samples, found[0], marker, Points(rng, marker, of_points), name, distance)
    for name in SETS:
        samples[f'gain_{name}'] = [p95(samples[f'both_{name}_rotation']) / p95(samples[f'image_{name}_rotation'])]
    return {key: [float(np.mean(values))] if key.startswith('found') else values for key, values in samples.items()}


def _marker(rng, distance, tilt, contrast):
    place = np.array([*rng.uniform(-0.2, 0.2, 2), 1.0]) * distance
    turn = rotations.facing(tilt, rng.uniform(0, 6.28), rng.uniform(0, 6.28))
    marker = Placed(int(rng.integers(256)), SIZE, turn, place, black=30.0, white=30.0 + contrast)
    marker.corners = drawing.project(CAMERA, turn, place, drawing.object_corners(SIZE))
    return marker


def _measure(samples, detection, marker, points, name, distance):
    begun = time.thread_time()
    plane = depth.plane_on(points, detection.corners, (HEIGHT, WIDTH), SETS[name][3])
    both = depth.measured(detection, SIZE, CAMERA, plane).detection
    samples.setdefault('cpu', []).append(1e3 * (time.thread_time() - begun))
    found = {'image': (detection.rotation, detection.position), 'both': (both.rotation, both.position)}
    if isinstance(plane, depth.Plane):
        found['points'] = depth.pose_on(plane, CAMERA.to_rays(CAMERA.to_ideal(detection.corners)))[:2]
    for source, (rotation, position) in found.items():
        samples.setdefault(f'{source}_{name}_position', []).append(
            100.0 * float(np.linalg.norm(position - marker.position)) / distance)
        samples.setdefault(f'{source}_{name}_rotation', []).append(
            float(np.degrees(rotations.angle_between(rotation, marker.rotation))))


MEASUREMENTS = {'poses': Measurement(poses, 'errors of poses from image, points and both', in_process=True)}


def _figures():
    for light in SETS:
        yield Figure(f'{light}: markers found', f'found_{light}', '%')
        for (kind, unit), (key, words) in itertools.product((('position', '%'), ('rotation', 'degrees')),
                                                            SOURCES.items()):
            yield Figure(f'{light}: {kind} error, {words}, median', f'{key}_{light}_{kind}', unit)
            yield Figure(f'{light}: {kind} error, {words}, 95th', f'{key}_{light}_{kind}', unit, p95)
        yield Figure(f'{light}: rotation error, 95th, both against image', f'gain_{light}', 'times', median,
                     Target('below', HARDLY_WORSE))


FIGURES = (*_figures(), Figure('CPU of the points, a marker', 'cpu', 'ms'))
