"""The compiled steps of the detector find what their twins in numpy find."""
import math
import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

import marker_classes
from alvar_core import native
from alvar_core.camera import default_camera
from alvar_core.detection import candidates, homography
from alvar_core.detection.detector import Detector
from alvar_core.detection.edge_alignment import EdgeAligner, Plane, edge_points
from alvar_core.detection.local_contrast import LocalDecoder
from alvar_core.detection.reading import black_cells, words_of_numbers
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


def test_the_environment_switches_the_compiled_steps_off():
    program = 'from alvar_core import native; print(native.library)'
    out = subprocess.run([sys.executable, '-c', program], env={**os.environ, 'ALVAR_CORE_PLAIN': '1'},
                         stdout=subprocess.PIPE, text=True, check=True, timeout=60).stdout
    assert out == 'None\n'
