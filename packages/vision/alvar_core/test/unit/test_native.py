"""The compiled steps: loading, refused input, and the same results as a few lines of numpy or OpenCV."""
import json
import math
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

from alvar_core import code, drawing, native, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import candidates, homography, pose, thresholds
from alvar_core.detection.acceptance import Appearance
from alvar_core.detection.alignment import Aligner, covariance
from alvar_core.detection.corners import CornerEstimator
from alvar_core.detection.detector import Detector
from alvar_core.detection.edge_alignment import edge_points, fit_plane
from alvar_core.detection.local_contrast import LocalDecoder
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import CoarseDecoder, Reader, black_cells, words_of_numbers
from unit_support import REPOSITORY, marker_classes

pytestmark = pytest.mark.slow

HALF = 4.5  # cells
FIND = '''
import json, sys
from unit_support import marker_classes
from alvar_core import native
from alvar_core.detection.detector import Detector
detector, found = Detector(marker_classes.SIZE), []
for name in sys.argv[1:]:
    shot = marker_classes.photo(name, marker_classes.DEVELOPMENT, 0)
    found += [[name, each.id, *each.corners.ravel()] for each in detector.detect(shot.image, shot.camera)]
print(json.dumps([native.steps.__name__, found]))
'''


@pytest.fixture(name='square')
def a_square():
    """Return an image, and the corners (4, 2) of a marker in it that are off by up to 1 px."""
    shot = marker_classes.photo('even', marker_classes.DEVELOPMENT, 0)
    corners = np.array(shot.frame['markers'][0]['corners'])
    return shot, corners + np.random.default_rng(1).uniform(-1, 1, (4, 2))


def found_by(*names, **environment):
    path = os.pathsep.join([str(REPOSITORY / 'test'), os.environ.get('PYTHONPATH', '')])
    out = subprocess.run([sys.executable, '-c', FIND, *names], env={**os.environ, 'PYTHONPATH': path, **environment},
                         stdout=subprocess.PIPE, text=True, check=True, timeout=120).stdout
    return json.loads(out)


@pytest.mark.nightly
def test_processors_without_avx2_find_the_same():
    names = 'even', 'blinds', 'bent 10 cm', '13 to 20 px'
    (_, ours), (plain, others) = found_by(*names), found_by(*names, OPENCV_CPU_DISABLE='AVX2')
    assert plain == 'alvar_core._native'
    assert [each[:2] for each in ours] == [each[:2] for each in others] and len(ours) >= len(names)
    assert all(np.abs(np.subtract(one[2:], other[2:])).max() < 0.02 for one, other in zip(ours, others))  # px


def test_missing_steps_say_what_to_type(monkeypatch):
    def missing(name):
        raise ImportError(f'No module named {name!r}')
    monkeypatch.setattr(native.importlib, 'import_module', missing)
    with pytest.raises(ImportError, match=r"No module named 'alvar_core\._native'.*type: \./run build"):
        native._load()


def test_thresholds_are_read_by_name():
    with pytest.raises(AttributeError, match='MIN_OUTLINE_SIDE'):
        native.steps.Thresholds(object())


GREY = np.zeros((20, 30), np.uint8)


@pytest.mark.parametrize('step, arguments, message', [
    ('refined', {'smooth': GREY, 'quads': np.zeros((2, 4))}, r'quads has the shape \(2, 4\)'),
    ('refined', {'smooth': GREY[:, ::2], 'quads': np.zeros((1, 4, 2))}, 'rows of uint8'),
    ('outlines', {'smooth': GREY, 'mean': GREY[1:], 'offset': 1, 'shrink': 1.0, 'parted': False}, 'differ in size'),
    ('distinct', {'quads': np.zeros((2, 4, 2)), 'score': np.zeros(2), 'which': [2]}, 'no quad'),
    ('squares', {'parts': np.zeros((5, 2))}, 'parts has the shape'),
])
def test_arrays_of_other_shapes_are_refused(step, arguments, message):
    with pytest.raises((ValueError, IndexError), match=message):
        getattr(native.steps, step)(**arguments, limit=native.limit)


def test_sides_of_a_quad_are_moved_and_a_quad_without_sides_is_left_out(square):
    shot, corners = square
    flat = np.array([[5, 5], [60, 5], [60, 60], [5, 60]], float)
    smooth = cv2.GaussianBlur(shot.image, (3, 3), 0)
    smooth[:80, :80] = 128
    right = np.array(shot.frame['markers'][0]['corners'])
    quads = np.array([corners + 5 * (corners - right), flat])  # up to 6 px off
    before = quads.copy()
    found, = candidates.refined(smooth, quads)
    assert np.abs(found - right).max() < 1.5 < np.abs(before[0] - right).max()  # px; places across a side are 2.3 apart
    assert np.array_equal(quads, before)


def square_near(quads, quad):
    """Return how far the corners of ``quad`` are from those of the nearest of ``quads``, whichever comes first."""
    turned = np.array([np.roll(quad, k, 0) for k in range(4)])
    return np.abs(np.asarray(quads)[:, None] - turned).max((2, 3)).min() if len(quads) else math.inf


def test_outlines_of_shapes():
    image = np.full((200, 240), 200, np.uint8)
    cv2.rectangle(image, (20, 20), (120, 120), 40, -1)
    cv2.rectangle(image, (40, 40), (100, 100), 200, -1)  # a hole
    cv2.rectangle(image, (55, 55), (85, 85), 40, -1)  # and its contents
    image[150, 150] = 40  # a single pixel
    cv2.line(image, (0, 160), (239, 180), 40, 2)  # to the edge of the image
    for each in (image, image.T.copy()):
        quads = candidates.candidates(each)
        for low, high in (20, 120), (55, 85):
            assert square_near(quads, np.array([[low, low], [high, low], [high, high], [low, high]])) < 2.5  # px
    assert len(candidates.candidates(np.full_like(image, 9))) == 0


def test_many_outlines():
    image = np.full((960, 1280), 220, np.uint8)
    for y in range(10, 950, 30):
        for x in range(10, 1270, 30):
            cv2.rectangle(image, (x, y), (x + 18, y + 18), 30, -1)
    parts = []
    squares = len(range(10, 950, 30)) * len(range(10, 1270, 30))
    assert len(candidates.candidates(image, thresholds.PASSES[:1], parts=parts)) == squares > 1300
    assert len(parts[0]) == 4 * squares


def test_of_quads_at_one_place_the_best_is_kept():
    quad = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], float)
    quads = np.array([quad, np.roll(quad, 1, 0) + 3, quad + 15, quad + 3])
    assert candidates.distinct(quads, np.array([1.0, 3, 2, 9]), np.array([0, 1, 2])) == [1, 2]


def test_coarse_decoding(square):
    shot, corners = square
    quads = np.array([corners + 200, corners, corners[::-1], corners * 0])
    match = CoarseDecoder(5, 2).match(shot.image, quads)
    at = match.kept.tolist().index(1)
    assert match.word[at] % 256 == shot.frame['markers'][0]['id'] and match.fit[at] > 0.9
    square_corners = HALF * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    assert homography.apply(match.h[at:at + 1], square_corners)[0] == pytest.approx(corners)


def test_how_cells_cover_places():
    line, sigma = np.linspace(-4, 4, 9), 0.6

    def below(x):
        return 0.5 * (1 + math.erf(x / sigma / math.sqrt(2)))
    expected = [[below(x + 2.5 - cell) - below(x + 1.5 - cell) for cell in range(5)] for x in line]
    found = native.steps.coverage(line=line, cells=5, variance=[sigma ** 2])[0]
    assert found == pytest.approx(np.array(expected), abs=1e-4)


def aligned(shot, corners):
    """Return the Alignment of the marker of a shot with its drawing, the PreparedImage, and the black cells."""
    image = PreparedImage(shot.image, shot.camera)
    h = homography.from_square(shot.camera.to_ideal(corners)[None], HALF)
    black = black_cells(code.encode(shot.frame['markers'][0]['id']), 2)[None]
    turned = np.array([np.rot90(black[0], k) for k in range(4)])
    states = [Aligner(9, 3).run(image.pyramid, shot.camera, h, each[None], np.ones(1), np.zeros(1, int), 6)
              for each in turned]
    best = min(range(4), key=lambda k: states[k].noise[0])
    return states[best], image, turned[best:best + 1]


def test_features_and_reading(square):
    state, _, _ = aligned(*square)
    aligner = Aligner(9, 3)
    features, = Appearance(aligner, 5, 2).features(state, np.zeros(1))
    v, t = (each[0] - each[0] @ aligner.share for each in (state.values, state.template))
    assert features.likeness == pytest.approx((v * t) @ aligner.share / np.sqrt(
        (v * v) @ aligner.share * ((t * t) @ aligner.share)), abs=1e-4)
    assert features.likeness > 0.9 and features.bad_inside == features.bad_rim == 0
    reading, = Reader(aligner.grid, 5, 2).read(state.clipped([0]), covariance(state.h, state.blur), state.noise)
    assert reading.content.value == square[0].frame['markers'][0]['id'] and reading.fit > 0.9


def test_corners_without_information(square):
    """A singular matrix says nothing: both poses are then as good."""
    state, image, black = aligned(*square)
    state.normal[:] = np.nan
    estimator, aligner = CornerEstimator(9), Aligner(9, 3)
    corners, information = estimator.measure(image, aligner, state, estimator.start(state), black, np.array([0.95]))
    assert not np.nan_to_num(information).any()
    solutions = pose.solve(corners, [0.1], square[0].camera, np.nan_to_num(information))[0]
    assert pose.ambiguity(solutions)[1] or len(solutions) < 2


def test_poses_are_near_those_of_opencv_and_fit_the_corners_better():
    rng, camera = np.random.default_rng(3), default_camera()
    points = drawing.UNIT_CORNERS * 0.05
    for _ in range(100):
        depth = rng.uniform(0.2, 3)
        place = np.array([*rng.uniform(-0.3, 0.3, 2) * depth, depth])
        seen = points @ rotations.facing(rng.uniform(0, 1.3), *rng.uniform(0, 6, 2)).T + place
        corners = seen[:, :2] / seen[:, 2:] * camera.focal + camera.centre + rng.normal(0, 0.05, (4, 2))
        best = pose.solve(corners[None], [0.05], camera)[0][0]
        _, turns, shifts, errors = cv2.solvePnPGeneric(points, corners, camera.matrix, None,
                                                       flags=cv2.SOLVEPNP_IPPE_SQUARE)
        near = min(range(len(turns)), key=lambda k: np.abs(cv2.Rodrigues(turns[k])[0] - best.rotation).max())
        assert rotations.angle_between(best.rotation, cv2.Rodrigues(turns[near])[0]) < 0.2  # rad
        projected = cv2.projectPoints(points, turns[near], shifts[near], camera.matrix, None)[0][:, 0]
        assert best.error <= np.sqrt(((projected - corners) ** 2).sum() / 4) + 1e-9


@pytest.mark.parametrize('corners', [np.zeros((4, 2)), np.full((4, 2), np.nan), np.full((4, 2), np.inf),
                                     [[0, 0], [1, 0], [2, 0], [3, 0]]])
def test_corners_that_are_no_square_have_no_pose_that_is_not_finite(corners):
    with np.errstate(all='ignore'):
        for solution in pose.solve(np.array([corners], float), [0.05], default_camera())[0]:
            assert np.isfinite(solution.rotation).all() and np.isfinite(solution.position).all()


def test_edges_that_are_not_there():
    points = edge_points(black_cells(words_of_numbers()[7], 2), np.array([-0.25, 0.25]))
    grey, camera = np.full((480, 640), 90, np.uint8), default_camera()
    for h in (np.array([[8.0, 0, 320], [0, 8, 240], [0, 0, 1]]), np.full((3, 3), np.nan), np.zeros((3, 3))):
        assert fit_plane(grey, camera, h, points, np.ones(8), 2.0, 4) is None


def test_places_far_outside_the_image_and_places_that_are_not_finite():
    grey = np.random.default_rng(2).integers(0, 256, (16, 16)).astype(np.uint8)
    decoder = LocalDecoder(2)
    far = [[-1e9, -1e9], [1e9, -1e9], [1e9, 1e9], [-1e9, 1e9]]
    for quad in (far, *([[number] * 2] * 4 for number in (np.nan, np.inf, 0.0))):
        quads = np.array([quad], float)
        decoder.match(grey, homography.from_square(quads, HALF))
        candidates.refined(grey, quads)
        assert Detector(0.1).examine(PreparedImage(grey, default_camera()), quads) == []
