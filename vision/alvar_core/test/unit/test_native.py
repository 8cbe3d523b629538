"""The compiled steps of the detector find what their twins in numpy find."""
import math
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

import marker_classes
from alvar_core import code, drawing, native, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import broken_outlines, candidates, homography, pose
from alvar_core.detection.acceptance import Appearance
from alvar_core.detection.alignment import Aligner, covariance
from alvar_core.detection.corners import CornerEstimator
from alvar_core.detection.detector import Detector
from alvar_core.detection.edge_alignment import EdgeAligner, Plane, edge_points
from alvar_core.detection.local_contrast import LocalDecoder
from alvar_core.detection.prepared_image import PreparedImage
from alvar_core.detection.reading import CoarseDecoder, Reader, black_cells, words_of_numbers
from alvar_core.fisheye import FisheyeCamera

ROUNDING = 0.06  # px of a corner: cv2.remap rounds places to 1/32 px and greys to whole ones
CLASSES = ['even', 'shadow 0.2', 'soft shadow', 'blinds', 'glare', 'exposure', 'bent 10 cm', '13 to 20 px', 'tilt',
           'motion', 'frame edge', 'occluded']
HALF = 4.5  # cells


def in_numpy(monkeypatch, function, *arguments):
    with monkeypatch.context() as changed:
        changed.setattr(native, 'library', None)
        return function(*arguments)


def shots(name, count=2):
    return [marker_classes.photo(name, marker_classes.DEVELOPMENT, number) for number in range(count)]


@pytest.fixture(name='square')
def a_square():
    """Return an image, and the corners (4, 2) of a marker in it that are off by up to 1 px."""
    shot = shots('even', 1)[0]
    rng = np.random.default_rng(1)
    corners = np.array(shot.frame['markers'][0]['corners'])
    return shot, corners + rng.uniform(-1, 1, (4, 2))


def test_the_workspace_has_the_compiled_steps():
    assert native.library is not None, f'{native.NAME} is not there: type ./run build'


@pytest.mark.parametrize('name', CLASSES)
def test_the_same_markers_are_found(monkeypatch, name):
    for shot in shots(name):
        detector = Detector(marker_classes.SIZE)
        found = {d.id: d for d in detector.detect(shot.image, shot.camera)}
        plain = {d.id: d for d in in_numpy(monkeypatch, detector.detect, shot.image, shot.camera)}
        assert found.keys() == plain.keys()
        for number, one in found.items():
            assert one.ambiguous == plain[number].ambiguous
            assert np.abs(one.corners - plain[number].corners).max() < ROUNDING * max(1, one.side / 50)
            assert math.dist(one.position, plain[number].position) < 0.005 * one.position[2]


def test_the_sides_of_quads(monkeypatch, square):
    shot, corners = square
    flat = np.array([[5, 5], [60, 5], [60, 60], [5, 60]], float)  # what has no sides is left out
    smooth = cv2.GaussianBlur(shot.image, (3, 3), 0)
    smooth[:80, :80] = 128
    quads = np.array([corners, flat])
    ours, plain = candidates.refined(smooth, quads), in_numpy(monkeypatch, candidates.refined, smooth, quads)
    assert len(ours) == len(plain) == 1
    assert np.abs(ours - plain).max() < 0.3  # places across a side are a sixth of the reach apart
    assert np.array_equal(quads, [corners, flat])


def square_near(quads, quad):
    """Return how far the corners of ``quad`` are from those of the nearest of ``quads``, whichever comes first."""
    turned = np.array([np.roll(quad, k, 0) for k in range(4)])
    return np.abs(np.asarray(quads)[:, None] - turned).max((2, 3)).min() if len(quads) else math.inf


@pytest.mark.parametrize('name', ['even', 'blinds', '13 to 20 px', 'occluded'])
def test_quads_and_straight_parts_of_outlines(monkeypatch, name):
    smooth = cv2.GaussianBlur(shots(name, 1)[0].image, (3, 3), 0)
    ours, plain = [], []
    quads = candidates.candidates(smooth, parts=ours)
    others = in_numpy(monkeypatch, lambda: candidates.candidates(smooth, parts=plain))
    near = sum(square_near(others, quad) < 2 for quad in quads)  # polygons may differ by a pixel of the smallest image
    assert len(quads) == pytest.approx(len(others), rel=0.1, abs=2) and near >= 0.9 * len(quads)
    assert len(ours[0]) == pytest.approx(len(plain[0]), rel=0.05, abs=2)
    ends = [np.abs(plain[0] - part).max((1, 2)).min() < 3 for part in ours[0]]
    assert np.mean(ends) > 0.9


def test_outlines_of_shapes(monkeypatch):
    image = np.full((120, 160), 200, np.uint8)
    cv2.rectangle(image, (20, 20), (60, 60), 40, -1)
    cv2.rectangle(image, (30, 30), (50, 50), 200, -1)  # a hole
    cv2.rectangle(image, (36, 36), (44, 44), 40, -1)  # and what is in it
    image[100, 100] = 40  # a single pixel
    cv2.line(image, (0, 110), (159, 119), 40, 2)  # to the edge of the image
    for each in (image, image.T.copy(), np.full_like(image, 9), np.where(np.indices(image.shape).sum(0) % 2, 0, 255)):
        each = each.astype(np.uint8)
        ours = candidates.candidates(each)
        plain = in_numpy(monkeypatch, candidates.candidates, each)
        assert sorted(square_near(plain, quad) < 1.5 for quad in ours) == [True] * len(plain)


def test_more_outlines_than_there_is_room_for(monkeypatch):
    image = np.full((960, 1280), 220, np.uint8)
    for y in range(10, 950, 30):
        for x in range(10, 1270, 30):
            cv2.rectangle(image, (x, y), (x + 18, y + 18), 30, -1)
    ours, plain = [], []
    quads = candidates.candidates(image, parts=ours)
    others = in_numpy(monkeypatch, lambda: candidates.candidates(image, parts=plain))
    assert len(quads) == len(others) > 2 * 1300
    assert len(ours[0]) == len(plain[0]) > 4 * 1300


@pytest.mark.parametrize('name', ['shadow 0.2', 'pole', 'blinds', 'creased'])
def test_squares_of_straight_parts(monkeypatch, name):
    smooth = cv2.GaussianBlur(shots(name, 1)[0].image, (3, 3), 0)
    parts = []
    candidates.candidates(smooth, parts=parts)
    ours, plain = broken_outlines.distinct_parts(smooth, parts[0]), in_numpy(
        monkeypatch, broken_outlines.distinct_parts, smooth, parts[0])
    assert len(ours) == pytest.approx(len(plain), rel=0.02, abs=1) and len(ours) < len(parts[0])
    quads, others = broken_outlines.squares(plain), in_numpy(monkeypatch, broken_outlines.squares, plain)
    assert len(quads) and len(quads) == len(others)
    assert max(square_near(others, quad) for quad in quads) < 1e-6


def test_coarse_decoding(monkeypatch, square):
    shot, corners = square
    decoder = CoarseDecoder(5, 2)
    quads = np.array([corners, corners + 200, corners[::-1], corners * 0])
    ours, plain = decoder.match(shot.image, quads), in_numpy(monkeypatch, decoder.match, shot.image, quads)
    assert ours.kept.tolist() == plain.kept.tolist() and 0 in ours.kept
    assert ours.word.tolist() == plain.word.tolist() and ours.word[0] % 256 == shot.frame['markers'][0]['id']
    for one, other in (ours.h, plain.h), (ours.fit, plain.fit), (ours.gap, plain.gap):
        assert one == pytest.approx(other, abs=0.01)


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


def test_features_and_reading(monkeypatch, square):
    state, _, _ = aligned(*square)
    aligner = Aligner(9, 3)
    appearance, reader = Appearance(aligner, 5, 2), Reader(aligner.grid, 5, 2)
    ours, plain = (call(appearance.features, state, state.noise) for call in both(monkeypatch))
    assert ours[0] == pytest.approx(plain[0], abs=1e-4) and ours[0].likeness > 0.9
    given = state.clipped([0]), covariance(state.h, state.blur), state.noise
    ours, plain = (call(reader.read, *given)[0] for call in both(monkeypatch))
    assert ours.content == plain.content and ours.content.value == square[0].frame['markers'][0]['id']
    assert (ours.fit, ours.gap) == pytest.approx((plain.fit, plain.gap), abs=1e-4)


def both(monkeypatch):
    """Return two ways to call a function: compiled and in numpy."""
    return lambda f, *arguments: f(*arguments), lambda f, *arguments: in_numpy(monkeypatch, f, *arguments)


@pytest.mark.parametrize('name', ['even', '20 to 25 px', 'bent 10 cm', 'tilt'])
def test_corners_and_bows(monkeypatch, name):
    shot = shots(name, 1)[0]
    state, image, black = aligned(shot, np.array(shot.frame['markers'][0]['corners']))
    estimator = CornerEstimator(9)
    start = estimator.start(state)
    (ours, of_ours), (plain, of_plain) = (call(estimator.measure, image, state, start.copy(), black, np.array([0.95]))
                                          for call in both(monkeypatch))
    assert np.abs(ours - plain).max() < ROUNDING
    assert np.diag(np.linalg.inv(of_ours[0])) == pytest.approx(np.diag(np.linalg.inv(of_plain[0])), rel=0.2)
    ours, plain = (call(estimator.bow, image, start) for call in both(monkeypatch))
    assert ours == pytest.approx(plain, abs=0.1)


def test_corners_without_information():
    """A singular matrix says nothing: both poses are then as good."""
    shot = shots('even', 1)[0]
    state, image, black = aligned(shot, np.array(shot.frame['markers'][0]['corners']))
    state.normal[:] = np.nan
    estimator = CornerEstimator(9)
    corners, information = estimator.measure(image, state, estimator.start(state), black, np.array([0.95]))
    assert not np.nan_to_num(information).any()
    solutions = pose.solve(corners, [0.1], shot.camera, np.nan_to_num(information))[0]
    assert pose.ambiguity(solutions)[1] or len(solutions) < 2


def test_poses(monkeypatch):
    rng, camera = np.random.default_rng(3), default_camera()
    for _ in range(200):
        depth = rng.uniform(0.2, 3)
        place = np.array([*rng.uniform(-0.3, 0.3, 2) * depth, depth])
        points = drawing.UNIT_CORNERS * 0.05 @ rotations.facing(rng.uniform(0, 1.3), *rng.uniform(0, 6, 2)).T + place
        corners = points[:, :2] / points[:, 2:] * camera.focal + camera.centre + rng.normal(0, 0.2, (4, 2))
        mixed = rng.normal(size=(8, 8))
        given = corners[None], [0.05], camera, (25 * np.eye(8) + mixed @ mixed.T)[None]
        ours, plain = (call(pose.solve, *given)[0] for call in both(monkeypatch))
        assert len(ours) == len(plain)
        for one, other in zip(ours, plain):
            assert rotations.angle_between(one.rotation, other.rotation) < 1e-6
            assert one.position == pytest.approx(other.position, abs=1e-8 * depth)
            assert (one.error, one.chi2) == pytest.approx((other.error, other.chi2), rel=1e-6)


@pytest.mark.parametrize('corners', [np.zeros((4, 2)), np.full((4, 2), np.nan), np.full((4, 2), np.inf),
                                     [[0, 0], [1, 0], [2, 0], [3, 0]]])
def test_corners_that_are_no_square_have_no_pose_that_is_a_number_that_is_none(corners):
    with np.errstate(all='ignore'):
        for solution in pose.solve(np.array([corners], float), [0.05], default_camera())[0]:
            assert np.isfinite(solution.rotation).all() and np.isfinite(solution.position).all()


def test_local_contrasts(monkeypatch, square):
    shot, corners = square
    decoder = LocalDecoder(2)
    h = homography.from_square(corners[None], HALF)
    ours, plain = decoder.match(shot.image, h), in_numpy(monkeypatch, decoder.match, shot.image, h)
    assert ours.word == plain.word and ours.word % 256 == shot.frame['markers'][0]['id']
    assert ours.fit == pytest.approx(plain.fit, abs=0.02) and ours.contrast == pytest.approx(plain.contrast, abs=0.02)


def test_edges(monkeypatch, square):
    shot, corners = square
    number = shot.frame['markers'][0]['id']
    match = LocalDecoder(2).match(shot.image, homography.from_square(corners[None], HALF))
    assert match.word[0] % 256 == number
    points = edge_points(black_cells(words_of_numbers()[match.word[0]], 2), np.array([-0.25, 0.25]))
    h = homography.from_square(shot.camera.to_ideal(corners)[None], HALF)[0]
    scale = 1e-3 / np.array([1 / HALF, 1, 1, 1 / HALF, 1, 1, HALF, HALF])
    given = (shot.image, shot.camera, Plane(h), np.zeros((1, 8)), points, scale, 2.0, 4)
    ours, plain = EdgeAligner().fit(*given)[0], in_numpy(monkeypatch, EdgeAligner().fit, *given)[0]
    assert (ours.agrees == plain.agrees).mean() > 0.97
    assert ours.error == pytest.approx(plain.error, abs=0.02)
    assert np.abs(ours.parameters - plain.parameters).max() < 5 * np.sqrt(np.diag(plain.covariance)).max()
    assert np.diag(ours.covariance) == pytest.approx(np.diag(plain.covariance), rel=0.5)


def test_edges_that_are_not_there():
    points = edge_points(black_cells(words_of_numbers()[7], 2), np.array([-0.25, 0.25]))
    grey, camera = np.full((480, 640), 90, np.uint8), default_camera()
    for h in (np.array([[8.0, 0, 320], [0, 8, 240], [0, 0, 1]]), np.full((3, 3), np.nan), np.zeros((3, 3))):
        assert EdgeAligner().fit(grey, camera, Plane(h), np.zeros((1, 8)), points, np.ones(8), 2.0, 4) == [None]


def test_places_far_outside_the_image_and_numbers_that_are_none():
    grey = np.random.default_rng(2).integers(0, 256, (16, 16)).astype(np.uint8)
    decoder = LocalDecoder(2)
    far = [[-1e9, -1e9], [1e9, -1e9], [1e9, 1e9], [-1e9, 1e9]]
    for quad in (far, *([[number] * 2] * 4 for number in (np.nan, np.inf, 0.0))):
        with np.errstate(all='ignore'):
            quads = np.array([quad], float)
            decoder.match(grey, homography.from_square(quads, HALF))
            candidates.refined(grey, quads)


def test_a_fisheye_is_left_to_numpy():
    assert native.library_for(FisheyeCamera([300.0, 0, 319.5, 0, 300.0, 239.5, 0, 0, 1], [0.1, 0, 0, 0])) is None
    assert native.library_for(default_camera())[0] is native.library


def test_a_library_with_another_interface_is_left_out(monkeypatch):
    monkeypatch.setattr(native, 'INTERFACE', native.INTERFACE + 1)
    assert native._load() is None
    monkeypatch.setattr(native, 'NAME', 'libm.so.6')  # one that does not know of interfaces
    assert native._load() is None


def test_the_environment_switches_the_compiled_steps_off():
    program = 'from alvar_core import native; print(native.library)'
    out = subprocess.run([sys.executable, '-c', program], env={**os.environ, 'ALVAR_CORE_PLAIN': '1'},
                         stdout=subprocess.PIPE, text=True, check=True, timeout=60).stdout
    assert out == 'None\n'
