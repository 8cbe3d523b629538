"""Photos of markers by class: effects of light, paper and camera, with ground truth, in two halves.

``photo(name, half, number)`` returns the same image every time. The detector is developed on the half DEVELOPMENT; the
half TEST is used only for the figures in docs/measurements.md.
"""
import math
import zlib
from typing import Any, Dict, NamedTuple

import cv2
import numpy as np

from alvar_core import code, rotations
from alvar_core.camera import default_camera
from unit_support.photo import Creased, Cylinder, Photo, Sheet, band, gradient, shadow, spot, stripes

DEVELOPMENT, TEST = 'development', 'test'
HALVES = {DEVELOPMENT: 0, TEST: 5}  # seeds; change that of the test half after a look at its photos
WIDTH, HEIGHT = 640, 480
SIZE = 0.05  # m
STEEPEST = 80.0  # degrees between a marker's axis and the line of sight
CAMERAS = (default_camera(WIDTH, HEIGHT), default_camera(WIDTH, HEIGHT, distorted=True))
FAMILIES = {'AprilTag 36h11': cv2.aruco.DICT_APRILTAG_36H11, 'AprilTag 25h9': cv2.aruco.DICT_APRILTAG_25H9,
            'ArUco 4x4': cv2.aruco.DICT_4X4_250, 'ArUco 5x5': cv2.aruco.DICT_5X5_250,
            'ArUco 6x6': cv2.aruco.DICT_6X6_250, 'ArUco original': cv2.aruco.DICT_ARUCO_ORIGINAL}


class Shot(NamedTuple):
    """A photo: ``image``, its ``camera``, and the ``frame`` as in frames.json."""

    image: Any
    camera: Any
    frame: Dict[str, Any]


def marker_cells(number):
    """Return the cells (9, 9), bool, True is white, of an ALVAR marker with its border."""
    return np.pad(code.encode(number), code.MARGIN)


def family_cells(family, number):
    """Return the cells, bool, with their border, of a tag of a family of OpenCV."""
    tags = cv2.aruco.getPredefinedDictionary(FAMILIES[family])
    number %= len(tags.bytesList)
    side = tags.markerSize + 2
    return cv2.aruco.generateImageMarker(tags, number, side) > 127


def _sheet(rng, side, tilt, cells, number, camera, **options):
    """Return a Sheet that is ``side`` [px] wide on average and tilted by ``tilt`` [degrees], inside the image."""
    distance = camera.fx * SIZE / (side / math.sqrt(math.cos(math.radians(tilt))))
    options.setdefault('paper', float(rng.uniform(0.11, 0.25)))
    black = float(rng.uniform(15, 45))
    options.setdefault('greys', (black, black + float(rng.uniform(90, 180))))
    position = None
    for _ in range(50):
        at = rng.uniform([0.1, 0.1], [0.9, 0.9]) * [WIDTH, HEIGHT]
        rotation = rotations.facing(math.radians(tilt), *rng.uniform(0, 2 * math.pi, 2).tolist())
        position = np.append(camera.to_rays(camera.to_ideal(at)), 1.0) * distance
        sheet = Sheet(cells, number, SIZE, rotation, position, **options)
        corners = sheet.corners(camera)
        # away from the middle of the image, the angle to the line of sight differs: from behind, print is mirrored
        facing = -float(rotation[:, 2] @ position) / np.linalg.norm(position) > math.cos(math.radians(STEEPEST))
        if facing and (corners > 6).all() and (corners < [WIDTH - 7, HEIGHT - 7]).all():
            return sheet
    raise ValueError(f'a sheet of {side} px does not fit in the image')


class _Recipe(NamedTuple):
    """A marker and the light around it, for the functions that make a Photo of a class of it."""

    rng: Any
    photo: Photo
    middle: Any
    side: float

    def near(self, reach):
        """Return a random pixel, up to ``reach`` sides from the middle along each axis."""
        return self.middle + self.rng.uniform(-reach, reach, 2) * self.side

    def angle(self):
        return float(self.rng.uniform(0, 2 * math.pi))

    def between(self, low, high):
        return float(self.rng.uniform(low, high))


def _hard_shadow(left):
    def make(r):
        r.photo.lights.append(shadow(r.near(0.3), r.angle(), r.between(0.5, 3), left))
    return make


def _soft_shadow(r):
    r.photo.lights.append(shadow(r.near(0.3), r.angle(), r.between(0.15, 0.6) * r.side, 0.2))


def _pole(r):
    wide = r.between(0.15, 0.5) * r.side
    r.photo.lights.append(band(r.near(0.3), r.angle(), wide, r.between(1, 5), r.between(0.2, 0.4)))


def _blinds(r):
    period = r.between(0.3, 0.9) * r.side
    r.photo.lights.append(stripes(r.near(0.5), r.angle(), period, r.between(0.35, 0.6), r.between(1, 5),
                                  r.between(0.18, 0.35)))


def _gradient(r):
    r.photo.lights.append(gradient(r.middle, r.angle(), 1.6 * r.side, r.between(0.15, 0.4)))


def _glare(r):
    r.photo.glare = spot(r.near(0.4), r.between(0.15, 0.5) * r.side, r.between(50, 160))


def _exposure(r):
    black, white = r.photo.sheets[0].greys
    r.photo.gain = r.between(290, 420) / white if r.rng.uniform() < 0.5 else r.between(25, 50) / white
    r.photo.noise = r.between(1, 2)


def _laminate(r):
    """Reflect a lamp in a shiny cover: a saturated stripe across the marker."""
    at, angle, wide, grey = r.near(0.4), r.angle(), r.between(0.04, 0.12) * r.side, r.between(150, 300)

    def glare(x, y):
        across = (x - at[0]) * np.cos(angle) + (y - at[1]) * np.sin(angle)
        return grey * np.exp(-0.5 * (across / wide) ** 2)
    r.photo.glare = glare


def _tape(r):
    """Stick shiny tape along one side: a bright patch with hard edges over the rim and half of the margin."""
    corners = r.photo.sheets[0].corners(r.photo.camera)
    k, grey = int(r.rng.integers(4)), r.between(50, 130)
    a, along = corners[k], (corners[(k + 1) % 4] - corners[k]) / np.linalg.norm(corners[(k + 1) % 4] - corners[k])
    low, high, wide = r.between(0.0, 0.4) * r.side, r.between(0.6, 1.0) * r.side, r.between(0.08, 0.15) * r.side

    def glare(x, y):
        u, v = (x - a[0]) * along[0] + (y - a[1]) * along[1], (y - a[1]) * along[0] - (x - a[0]) * along[1]
        return grey * ((u > low) & (u < high) & (np.abs(v) < wide))
    r.photo.glare = glare


def _faded(r):
    """Print with a toner that is nearly empty: little contrast, and blotches."""
    white = r.between(170, 210)
    r.photo.sheets[0].greys = (white * r.between(0.6, 0.75), white)
    blotches = cv2.resize(r.rng.normal(1, 0.05, (24, 32)).astype(np.float32), (WIDTH, HEIGHT),
                          interpolation=cv2.INTER_CUBIC)

    def light(x, y):
        rows, columns = (np.clip(np.round(v), 0, end - 1).astype(int) for v, end in ((y, HEIGHT), (x, WIDTH)))
        return blotches[rows, columns]
    r.photo.lights.append(light)


def _backlight(r):
    """Hang the sheet before a bright window: it is in its own shade, and stray light lies on one side."""
    r.photo.table, r.photo.clutter, r.photo.noise = 250.0, 0, r.between(1, 2)
    black = r.between(6, 12)
    r.photo.sheets[0].greys = (black, black + r.between(25, 50))
    r.photo.glare = spot(r.near(1.0), r.between(0.7, 1.5) * r.side, r.between(20, 80))


def _flush(r):
    """Cut the paper off at one side of the square, before something dark."""
    corners = r.photo.sheets[0].corners(r.photo.camera)
    k, left = int(r.rng.integers(4)), r.between(0.2, 0.5)
    a, along = corners[k], (corners[(k + 1) % 4] - corners[k]) / np.linalg.norm(corners[(k + 1) % 4] - corners[k])

    def light(x, y):  # corners run clockwise, so that the left of a side is outside
        return np.where((y - a[1]) * along[0] - (x - a[0]) * along[1] < 0, left, 1.0)
    r.photo.lights.append(light)


def _bent(radius):
    def make(r):
        r.photo.sheets[0].surface = Cylinder(radius * (1 if r.rng.uniform() < 0.7 else -1), r.angle())
    return make


def _creased(r):
    fold = math.radians(r.between(8, 15)) * (1 if r.rng.uniform() < 0.5 else -1)
    r.photo.sheets[0].surface = Creased(fold, r.angle(), r.between(0.05, 0.3) * SIZE)


def _thin_margin(r):
    r.photo.sheets[0].paper, r.photo.table, r.photo.clutter = 0.03, r.between(10, 35), 0


def _motion(r):
    length, angle = r.between(2, 0.06 * r.side + 2), r.angle()
    r.photo.motion = (length * math.cos(angle), length * math.sin(angle))


def _jpeg(r):
    r.photo.jpeg = int(r.between(15, 45))


def _frame_edge(r):
    """Move the marker so that the edge of the image cuts its margin, but not its square."""
    sheet = r.photo.sheets[0]
    corners = sheet.corners(r.photo.camera)
    gap = np.concatenate([corners.min(0), [WIDTH - 1, HEIGHT - 1] - corners.max(0)])
    axis = int(gap.argmin())
    move = (gap[axis] - r.between(1.5, 5)) * (-1 if axis < 2 else 1)
    sheet.position = sheet.position.copy()
    sheet.position[axis % 2] += move * sheet.position[2] / r.photo.camera.fx
    left = sheet.corners(r.photo.camera)
    short = 1.5 - min(left.min(), (np.array([WIDTH - 1, HEIGHT - 1]) - left).min())
    if short > 0:
        sheet.position[axis % 2] += short * (1 if axis < 2 else -1) * sheet.position[2] / r.photo.camera.fx


def _occluded(r):
    corners = r.photo.sheets[0].corners(r.photo.camera)
    k = int(r.rng.integers(4))
    edge = corners[k] + r.between(0.2, 0.8) * (corners[(k + 1) % 4] - corners[k])
    inward = (r.middle - edge) * r.between(-0.1, 0.2)
    r.photo.covers.append((*(edge + inward).tolist(), r.between(0.06, 0.12) * r.side, r.between(10, 240)))


class Kind(NamedTuple):
    """A class: a function that changes the Photo, the ranges of the side [px] and of the tilt [degrees]."""

    make: Any = None
    side: Any = (50, 130)
    tilt: Any = (0, 45)


KINDS = {
    'even': Kind(),
    'shadow 0.5': Kind(_hard_shadow(0.5)), 'shadow 0.35': Kind(_hard_shadow(0.35)),
    'shadow 0.2': Kind(_hard_shadow(0.2)), 'soft shadow': Kind(_soft_shadow), 'pole': Kind(_pole),
    'blinds': Kind(_blinds), 'gradient': Kind(_gradient), 'glare': Kind(_glare), 'exposure': Kind(_exposure),
    'bent 20 cm': Kind(_bent(0.2)), 'bent 10 cm': Kind(_bent(0.1)), 'bent 6 cm': Kind(_bent(0.06)),
    'creased': Kind(_creased), 'thin margin': Kind(_thin_margin), '13 to 20 px': Kind(None, (13, 20), (0, 30)),
    '10 to 13.5 px': Kind(None, (10, 13.5), (0, 30)), 'laminate': Kind(_laminate), 'tape': Kind(_tape),
    'faded toner': Kind(_faded), 'backlight': Kind(_backlight), 'flush paper': Kind(_flush),
    '20 to 25 px': Kind(None, (20, 25), (0, 30)), 'tilt': Kind(None, (50, 130), (55, 72)), 'motion': Kind(_motion),
    'jpeg': Kind(_jpeg), 'frame edge': Kind(_frame_edge), 'occluded': Kind(_occluded),
}
LOOK_ALIKES = 'look-alikes'


def _generator(name, half, number):
    return np.random.default_rng([zlib.crc32(name.encode()), HALVES[half], number])


def photo(name, half, number, cells_of=marker_cells):
    """Return the Shot ``number`` of a class in a half; ``cells_of`` (id) gives the cells, those of ALVAR by default."""
    rng = _generator(name, half, number)
    if name == LOOK_ALIKES:
        return _look_alikes(rng)
    kind, camera, marker = KINDS[name], CAMERAS[int(rng.integers(2))], int(rng.integers(256))
    side = math.exp(rng.uniform(*np.log(kind.side)))
    made = Photo(camera, (WIDTH, HEIGHT), [], blur=float(rng.uniform(0.4, 0.9)), noise=float(rng.uniform(1, 3)))
    sheet = _sheet(rng, side, float(rng.uniform(*kind.tilt)), cells_of(marker), marker, camera)
    made.sheets.append(sheet)
    middle = sheet.corners(camera).mean(0)
    if kind.make:
        kind.make(_Recipe(rng, made, middle, side))
    return Shot(made.render(rng), camera, _frame(f'{name} {number}', made))


def crowd(width, height, columns, rows, number):
    """Return the Shot ``number`` of many markers in columns and rows, each tilted by up to 30 degrees."""
    rng, camera = np.random.default_rng([columns, rows, number]), default_camera(width, height)
    made = Photo(camera, (width, height), [], blur=float(rng.uniform(0.4, 0.8)), noise=float(rng.uniform(1, 3)),
                 dense=True)
    wide, high = width / columns, height / rows
    for place, marker in enumerate(rng.permutation(256)[:columns * rows].tolist()):
        at = np.array([place % columns + 0.5, place // columns + 0.5]) * [wide, high]
        side, black = min(wide, high) * float(rng.uniform(0.5, 0.6)), float(rng.uniform(15, 45))
        ray = np.append(camera.to_rays(at), 1.0)
        tilt, *turns = rng.uniform(0, [math.radians(30), 2 * math.pi, 2 * math.pi]).tolist()
        rotation = rotations.facing(tilt, *turns)
        if -float(rotation[:, 2] @ ray) / np.linalg.norm(ray) < 0.5:  # off the middle, some would lie flat
            rotation = rotations.facing(0.1, *turns)
        made.sheets.append(Sheet(marker_cells(marker), marker, SIZE, rotation, ray * camera.fx * SIZE / side,
                                 paper=0.12, greys=(black, black + float(rng.uniform(90, 180)))))
    return Shot(made.render(rng), camera, _frame(f'{columns} x {rows} {number}', made))


def _look_alikes(rng):
    """Return a Shot of twelve squares that are not ALVAR markers, of six families, some in bad light."""
    camera = CAMERAS[int(rng.integers(2))]
    made = Photo(camera, (WIDTH, HEIGHT), [], blur=float(rng.uniform(0.4, 0.9)), noise=float(rng.uniform(1, 3)))
    families = sorted(FAMILIES)
    for place in range(12):
        cells = family_cells(families[place % len(families)], int(rng.integers(1000)))
        at = (np.array([place % 4, place // 4]) + rng.uniform(0.45, 0.55, 2)) * [WIDTH / 4, HEIGHT / 3]
        side, tilt = float(rng.uniform(40, 90)), float(rng.uniform(0, 50))
        rotation = rotations.facing(math.radians(tilt), *rng.uniform(0, 2 * math.pi, 2).tolist())
        position = np.append(camera.to_rays(camera.to_ideal(at)), 1.0) * camera.fx * SIZE / side
        made.sheets.append(Sheet(cells, None, SIZE, rotation, position, paper=float(rng.uniform(0.11, 0.2))))
        if place % 6 == 0:
            recipe = _Recipe(rng, made, at, side)
            light = (_hard_shadow(0.35), _soft_shadow, _blinds, _glare, _pole)[int(rng.integers(5))]
            light(recipe)
    return Shot(made.render(rng), camera, _frame(LOOK_ALIKES, made))


def _frame(name, made):
    markers = [{'id': sheet.id, 'position': sheet.position.tolist(), 'corners': sheet.corners(made.camera).tolist(),
                'orientation': rotations.quaternion_from_matrix(sheet.rotation).tolist(),
                'distance_m': float(np.linalg.norm(sheet.position)), 'ignore': False}
               for sheet in made.sheets if sheet.id is not None]
    return {'name': name, 'markers': markers, 'marker_size_m': SIZE}
