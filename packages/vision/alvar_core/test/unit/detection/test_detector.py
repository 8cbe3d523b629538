"""Detection in rendered pictures of known truth, in pictures without markers, and of bad input."""

import numpy as np
import pytest

from alvar_core import code, drawing, rotations
from alvar_core.camera import Camera, CameraError, default_camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.prepared_image import ImageError
from rostest_support.marker_scenes import Placed, Scene, image_of
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

SIZE = 0.1
CORNER_TOLERANCE = 0.35   # px
POSITION_TOLERANCE = 0.004  # of the distance
ROTATION_TOLERANCE = np.radians(2.5)


def scene(seed, placed, camera=None, **how):
    rng = np.random.default_rng(seed)
    camera = camera or default_camera()
    picture = image_of(rng, camera, placed, Scene(**how))
    return picture, camera


def one(marker_id=42, tilt=30, azimuth=40, roll=20, position=(0, 0, 0.6), **more):
    rotation = rotations.facing(*np.radians([tilt, azimuth, roll]))
    return Placed(marker_id, SIZE, rotation, np.array(position, float), **more)


def check(detection, placed):
    assert detection.id == placed.id
    assert np.abs(detection.corners - placed.corners).max() < CORNER_TOLERANCE
    distance = np.linalg.norm(placed.position)
    assert np.linalg.norm(detection.position - placed.position) < POSITION_TOLERANCE * distance
    assert rotations.angle_between(detection.rotation, placed.rotation) < ROTATION_TOLERANCE


@pytest.mark.parametrize('roll', [0, 135, 270, *nightly(45, 90, 180, 225, 315)])
def test_id_corners_and_pose_at_every_roll(roll):
    placed = one(marker_id=roll % 256, roll=roll)
    picture, camera = scene(roll, [placed])
    found = Detector(SIZE).detect(picture, camera)
    assert len(found) == 1
    check(found[0], placed)
    assert found[0].confidence > 0.9 and not found[0].ambiguous and found[0].error < 0.3


@pytest.mark.parametrize('distorted', [False, True])
def test_lens_distortion_is_used(distorted):
    camera = default_camera(distorted=distorted)
    placed = one(position=(0.22, 0.14, 0.6))
    picture, _ = scene(5, [placed], camera)
    found = Detector(SIZE).detect(picture, camera)
    assert len(found) == 1
    check(found[0], placed)


def test_several_markers_and_one_of_its_own_size():
    placed = [one(1, position=(-0.2, 0, 0.7)), one(2, position=(0, 0, 0.7)), one(3, position=(0.2, 0, 0.7))]
    placed[1].size = 0.08
    picture, camera = scene(8, placed)
    found = {d.id: d for d in Detector(SIZE, sizes={2: 0.08}).detect(picture, camera)}
    assert sorted(found) == [1, 2, 3]
    for marker in placed:
        check(found[marker.id], marker)


@pytest.mark.parametrize('cover', ['bar', 'blob'])
def test_most_partly_covered_markers_are_found_and_none_is_another(cover):
    right = wrong = 0
    for seed in range(12):
        placed = one(marker_id=seed * 17, tilt=20, azimuth=30 * seed, position=(0, 0, 0.7), cover=cover)
        picture, camera = scene(100 + seed, [placed])
        ids = [d.id for d in Detector(SIZE).detect(picture, camera)]
        right += placed.id in ids
        wrong += sum(i != placed.id for i in ids)
    assert wrong == 0 and right >= 8


def test_mirrored_picture_has_no_marker_of_the_same_pose_and_inverted_has_none():
    placed = one(77)
    picture, camera = scene(9, [placed])
    assert Detector(SIZE).detect(255 - picture, camera) == []
    assert 77 not in [d.id for d in Detector(SIZE).detect(np.ascontiguousarray(picture[:, ::-1]), camera)]


@pytest.mark.parametrize('value', [1000, 65535, 'hi'])
def test_larger_resolutions_and_text(value):
    resolution = len(code.encode(value))
    placed = one(value)
    picture, camera = scene(11, [placed])
    found = Detector(SIZE, resolution=resolution).detect(picture, camera)
    assert len(found) == 1
    check(found[0], placed)


def test_no_opencv_threads_are_needed_and_colour_is_taken():
    placed = one(9)
    picture, camera = scene(12, [placed])
    colour = np.repeat(picture[:, :, None], 3, 2)
    assert [d.id for d in Detector(SIZE).detect(colour, camera)] == [9]
    assert [d.id for d in Detector(SIZE).detect(picture.astype(np.uint16) * 256, camera)] == [9]


@pytest.mark.parametrize('seed, cells', [(20, 3), (21, 3), (22, 1), (23, 1)])
def test_marker_of_another_margin_is_none(seed, cells):
    picture, camera = scene(seed, [one(seed * 9, tilt=20)])
    blank = np.full_like(picture, 160)
    side = 120
    tag = drawing.marker_image(seed * 9, side, margin=cells)
    blank[200:200 + side, 260:260 + side] = np.where(tag > 0, 200, 30)
    blank[180:200, 240:400] = blank[320:340, 240:400] = blank[180:340, 240:260] = blank[180:340, 380:400] = 200
    assert Detector(SIZE).detect(blank, camera) == []
    assert [d.id for d in Detector(SIZE, margin=cells).detect(blank, camera)] == [seed * 9]


GREY = np.full((480, 640), 128, np.uint8)
K = [525, 0, 319.5, 0, 525, 239.5, 0, 0, 1]


@pytest.mark.parametrize('picture, text', [
    (None, 'got NoneType'), (np.zeros((0, 0), np.uint8), r'got \(0, 0\)'), (np.zeros((4, 4), np.uint8), '16x16'),
    (np.zeros(640, np.uint8), '16x16'), (np.zeros((480, 640), np.float32), 'got float32'),
    (np.zeros((480, 640, 2), np.uint8), 'got 2'), (np.zeros((480, 640, 0), np.uint8), 'got 0'),
    (np.zeros((480, 640), bool), 'got bool'), (GREY.tolist(), 'got list'),
])
def test_unusable_pictures_are_refused(picture, text):
    with pytest.raises(ImageError, match=text):
        Detector(SIZE).detect(picture, default_camera())


def test_picture_of_another_size_than_the_cameras_is_refused():
    camera = Camera(K, size=(640, 480))
    assert Detector(SIZE).detect(GREY, camera) == []
    with pytest.raises(ImageError, match='320x240 pixels, but the camera is calibrated for 640x480'):
        Detector(SIZE).detect(GREY[::2, ::2], camera)


@pytest.mark.parametrize('camera', [None, K, {'K': K}])
def test_what_is_no_camera_is_refused(camera):
    with pytest.raises(CameraError, match='a Camera is needed'):
        Detector(SIZE).detect(GREY, camera)


@pytest.mark.parametrize('matrix, text', [
    ([0] * 9, 'calibrated'), (K[:8] + [float('nan')], 'nan'), ([float('inf')] + K[1:], 'inf'), ([-525] + K[1:], '-525'),
    (K[:8], '8 numbers'), (None, '1 numbers'), (['a'] * 9, 'numbers are needed'), (K[:6] + [0, 0, 0], 'last row'),
])
def test_unusable_camera_matrices_are_refused(matrix, text):
    with pytest.raises(CameraError, match=text):
        Camera(matrix)


@pytest.mark.parametrize('distortion', [[float('nan')] * 5, [0.1] * 9, ['a']])
def test_unusable_distortion_is_refused(distortion):
    with pytest.raises(CameraError, match='distortion D'):
        Camera(K, distortion)


@pytest.mark.parametrize('distortion', [[50], [-300], [0, 4000], [0, 0, 0, 0, -1e5], [1e300] * 8])
def test_distortion_that_no_lens_has_is_refused(distortion):
    with pytest.raises(CameraError, match=r'distortion D is .* no lens has this'):
        Camera(K, distortion)


@pytest.mark.parametrize('distortion', [
    [-0.35, 0.15, 0.001, -0.001, 0], [0.3, -0.1], [-0.5, 0.3, 0, 0, -0.1], [0.4, -2.6, 0, 0, 1.5, 0.3, -2.4, 1.4]])
def test_distortion_of_lenses_is_not(distortion):
    assert Camera(K, distortion).distorted


@pytest.mark.parametrize('arguments, text', [
    ((0,), 'marker size 0 m'), ((-1,), 'above 0'), ((float('nan'),), 'nan'), ((float('inf'),), 'inf'),
    ((None,), 'None'), (('0.1',), "'0.1'"), ((0.1, 6), 'resolution 6'), ((0.1, 3), 'from 5'), ((0.1, None), 'None'),
    ((0.1, 5.5), '5.5'),
    ((0.1, 5, 0), 'margin 0'), ((0.1, 5, 1.5), '1.5'), ((0.1, 5, float('nan')), 'nan'), ((0.1, 5, None), 'None'),
    ((0.1, 5, 2, {7: -0.1}), 'size -0.1'),
])
def test_impossible_settings_are_refused(arguments, text):
    with pytest.raises(ValueError, match=text):
        Detector(*arguments)


def test_impossible_size_set_later_is_refused_and_changes_nothing():
    found = Detector(SIZE)
    with pytest.raises(ValueError, match='marker size 0 m'):
        found.size = 0
    assert found.size == SIZE


@pytest.mark.parametrize('grey', [0, 128, 255])
def test_plain_pictures(grey):
    assert Detector(SIZE).detect(np.full((480, 640), grey, np.uint8), default_camera()) == []
