"""Make test images of markers with lens distortion, blur, noise, light and covers.

Scenes use the caller's numpy Generator: the same seed gives the same image.
"""
from dataclasses import dataclass, field

import cv2
import numpy as np

from alvar_core import code, drawing, rotations

SUPERSAMPLE = 3




@dataclass
class Placed:
    """A marker in a scene.

    ``id``, ``size`` [m], ``rotation`` (3, 3) and ``position`` (3,) [m] in the camera; ``paper`` [cells]: width of the
    white edge; ``cover``: None, 'bar' or 'blob', which hides a part; ``black``, ``white``: greys of print and paper.
    """

    id: object
    size: float
    rotation: np.ndarray
    position: np.ndarray
    paper: float = 1.0
    cover: str = None
    black: float = 25.0
    white: float = 215.0
    corners: np.ndarray = field(default=None)


@dataclass
class Scene:
    """The properties of an image.

    ``width``, ``height`` [px]; ``blur`` [px], ``noise`` [greys]: standard deviations; ``gradient``: change of the light
    over the image, as a share.
    """

    width: int = 640
    height: int = 480
    blur: float = 0.5
    noise: float = 1.5
    gradient: float = 0.1
    shadow: bool = False
    clutter: int = 0




def _background(rng, scene):
    small = rng.uniform(30, 210, (scene.height // 60 + 2, scene.width // 60 + 2)).astype(np.float32)
    image = cv2.resize(small, (scene.width * SUPERSAMPLE, scene.height * SUPERSAMPLE), interpolation=cv2.INTER_CUBIC)
    image = np.clip(image, 0, 255).astype(np.uint8)
    for _ in range(scene.clutter):
        _one_clutter(rng, image)
    return image


def _one_clutter(rng, image):
    height, width = image.shape
    at = rng.uniform([0, 0], [width, height])
    size, grey = rng.uniform(20, 150) * SUPERSAMPLE, float(rng.uniform(0, 255))
    kind = rng.integers(5)
    if kind == 0:
        angle = rng.uniform(0, np.pi)
        other = at + 4 * size * np.array([np.cos(angle), np.sin(angle)])
        cv2.line(image, tuple(map(int, at)), tuple(map(int, other)), grey, int(rng.uniform(1, 6)) * SUPERSAMPLE)
    elif kind == 1:
        cv2.circle(image, tuple(map(int, at)), int(size / 2), grey, -1)
    elif kind == 2:
        text = ''.join(rng.choice(list('ABCDEFGHKLMNPRSTX0123456789'), 6))
        cv2.putText(image, text, tuple(map(int, at)), 0, float(rng.uniform(1, 4)), grey, 2 * SUPERSAMPLE)
    else:
        _pattern(rng, image, at, size, kind == 3)


def _pattern(rng, image, at, size, random_cells):
    """Draw a look-alike: nested squares, or a square of random cells in a black border, on white paper."""
    count = int(rng.integers(4, 10))
    cells = rng.integers(0, 2, (count, count)) if random_cells else np.indices((count, count)).sum(0) % 2
    rim = int(rng.integers(0, 4))
    tile = np.pad(np.pad(cells, rim), 1, constant_values=1).astype(np.uint8) * 190 + 25
    quad = at + (np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * size / 2) @ cv2.getRotationMatrix2D(
        (0, 0), float(rng.uniform(0, 360)), 1)[:, :2] + rng.uniform(-0.15, 0.15, (4, 2)) * size
    n = len(tile)
    h = cv2.getPerspectiveTransform(np.float32([[0, 0], [n, 0], [n, n], [0, n]]) - 0.5, quad.astype(np.float32))
    shape = image.shape[::-1]
    warped = cv2.warpPerspective(tile, h, shape, flags=cv2.INTER_NEAREST)
    mask = cv2.warpPerspective(np.ones_like(tile), h, shape, flags=cv2.INTER_NEAREST) > 0.5
    image[mask] = warped[mask]


def _window(fine, camera, placed, width):
    """Return slices (rows, columns) of the fine image that contain a square, ``width`` [m], in the marker's plane."""
    rim = np.linspace(-0.5, 0.5, 9) * width
    points = np.array([(x, y, 0) for x in rim for y in rim])
    if ((points @ placed.rotation.T + placed.position)[:, 2] <= 0).any():
        return slice(0, fine.shape[0]), slice(0, fine.shape[1])
    real = (drawing.project(camera, placed.rotation, placed.position, points) + 0.5) * SUPERSAMPLE
    low, high = real.min(0), real.max(0)
    spare = 0.1 * (high - low).max() + 2
    low = np.clip(low - spare, 0, fine.shape[::-1]).astype(int)
    high = np.clip(high + spare, 0, fine.shape[::-1]).astype(int)
    return slice(low[1], high[1]), slice(low[0], high[0])


def _ideal_of(camera, rows, columns):
    y, x = ((np.arange(part.start, part.stop) + 0.5) / SUPERSAMPLE - 0.5 for part in (rows, columns))
    grid = np.stack(np.meshgrid(x, y), -1)
    return camera.to_ideal(grid) if camera.distorted and grid.size else grid


def _paint(rng, image, camera, placed, margin):
    cells = code.encode(placed.id)
    count = len(cells) + 2 * margin
    half = placed.size / 2
    window = _window(image, camera, placed, placed.size * (1 + 2 * placed.paper / count))
    fine, ideal = image[window], _ideal_of(camera, *window)
    h = np.column_stack([placed.rotation[:, 0], placed.rotation[:, 1], placed.position])
    rays = np.concatenate([camera.to_rays(ideal), np.ones(ideal.shape[:2] + (1,))], -1)
    p = rays @ np.linalg.inv(h).T
    with np.errstate(divide='ignore', invalid='ignore'):
        x, y = p[..., 0] / p[..., 2], p[..., 1] / p[..., 2]
    step = placed.size / count
    on_paper = (np.maximum(np.abs(x), np.abs(y)) < half + placed.paper * step) & (p[..., 2] > 0)
    column, row = np.floor((x[on_paper] + half) / step), np.floor((half - y[on_paper]) / step)
    white = np.pad(np.pad(cells, margin), 8, constant_values=True)
    value = white[np.clip(row + 8, 0, count + 15).astype(int), np.clip(column + 8, 0, count + 15).astype(int)]
    fine[on_paper] = np.where(value, placed.white, placed.black)
    if placed.cover:
        _cover(rng, image, placed, camera)


def _cover(rng, fine, placed, camera):
    corners = (placed.corners + 0.5) * SUPERSAMPLE - 0.5
    side = np.sqrt(abs(cv2.contourArea(corners.astype(np.float32))))
    grey = float(rng.choice([rng.uniform(10, 60), rng.uniform(90, 140), rng.uniform(180, 240)]))
    k = int(rng.integers(4))
    edge = corners[k] + rng.uniform(0.25, 0.75) * (corners[(k + 1) % 4] - corners[k])
    centre = corners.mean(0)
    if placed.cover == 'bar':
        inner = edge + rng.uniform(0.25, 0.5) * (centre - edge) * 2 * rng.uniform(0.5, 1)
        outer = edge + (edge - centre) * rng.uniform(0.5, 1.2)
        width = max(2, int(side * rng.uniform(0.06, 0.12)))
        cv2.line(fine, tuple(map(int, inner)), tuple(map(int, outer)), grey, width)
    else:
        at = edge + rng.uniform(-0.1, 0.4) * (centre - edge)
        cv2.circle(fine, tuple(map(int, at)), max(2, int(side * rng.uniform(0.07, 0.13))), grey, -1)


def _light(rng, scene, fine):
    height, width = fine.shape
    angle = rng.uniform(0, 2 * np.pi)
    x, y = np.linspace(-0.5, 0.5, width), np.linspace(-0.5, 0.5, height)[:, None]
    light = 1 - scene.gradient * (0.5 + np.cos(angle) * x + np.sin(angle) * y)
    if scene.shadow:
        angle, offset = rng.uniform(0, 2 * np.pi), rng.uniform(-0.2, 0.2)
        light = light * np.where(np.cos(angle) * x + np.sin(angle) * y > offset, 1.0, rng.uniform(0.5, 0.75))
    return fine * light


def image_of(rng, camera, placed, scene, margin=2):
    """Return the grey image, uint8, of Placed markers seen by a camera; set their corners."""
    fine = _background(rng, scene)
    for marker in placed:
        marker.corners = drawing.project(camera, marker.rotation, marker.position, drawing.object_corners(marker.size))
        _paint(rng, fine, camera, marker, margin)
    fine = _light(rng, scene, fine).astype(np.float32)
    if scene.blur > 0:
        fine = cv2.GaussianBlur(fine, (0, 0), scene.blur * SUPERSAMPLE)
    image = cv2.resize(fine, (scene.width, scene.height), interpolation=cv2.INTER_AREA)
    return np.clip(np.round(image + rng.normal(0, scene.noise, image.shape)), 0, 255).astype(np.uint8)


def random_markers(rng, camera, scene, count, side=(20, 120), max_tilt=60.0, size=0.1, cover=0.0):
    """Return up to ``count`` Placed markers that do not overlap.

    ``side`` [px], lowest and highest; ``max_tilt`` [degrees]; ``size`` [m]; ``cover``: share of covered markers.
    """
    placed = []
    for marker_id in rng.choice(256, 8 * count, replace=False):
        px = np.exp(rng.uniform(*np.log(side)))
        distance = camera.fx * size / px
        at = rng.uniform([0.08, 0.08], [0.92, 0.92]) * [scene.width, scene.height]
        direction = np.append(camera.to_rays(camera.to_ideal(at)), 1.0)
        tilt, azimuth, roll = np.radians(rng.uniform(0, max_tilt)), rng.uniform(0, 2 * np.pi), rng.uniform(0, 2 * np.pi)
        rotation = rotations.facing(tilt, azimuth, roll)
        black = float(rng.uniform(15, 50))
        one = Placed(int(marker_id), size, rotation, direction * distance, float(rng.uniform(0.5, 2.5)),
                     str(rng.choice(['bar', 'blob'])) if rng.uniform() < cover else None, black,
                     black + float(rng.uniform(60, 180)))
        one.corners = drawing.project(camera, rotation, one.position, drawing.object_corners(size * 1.4))
        centre, reach = one.corners.mean(0), np.ptp(one.corners, 0).max() / 2
        inside = (one.corners > 4).all() and (one.corners < [scene.width - 5, scene.height - 5]).all()
        others = [(p.corners.mean(0), np.ptp(p.corners, 0).max() / 2) for p in placed]
        if inside and all(np.abs(centre - c).max() > reach + r for c, r in others):
            placed.append(one)
        if len(placed) == count:
            break
    return placed
