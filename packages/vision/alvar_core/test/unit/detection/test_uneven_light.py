"""Markers across which the light changes: local contrasts, squares of broken outlines, edges; found and exact."""
import math

import cv2
import numpy as np
import pytest

from alvar_core import code
from alvar_core.camera import default_camera
from alvar_core.detection import broken_outlines, candidates, homography, striped_light
from alvar_core.detection.detector import Detector
from alvar_core.detection.edge_alignment import edge_points
from alvar_core.detection.local_contrast import LocalDecoder, steps_of
from alvar_core.detection.reading import black_cells
from alvar_core.detection.tracker import Tracker
from rostest_support.marker_scenes import Scene, image_of, random_markers
from unit_support import marker_classes, marker_score
from unit_support.cases import nightly

pytestmark = pytest.mark.slow


def test_steps_of_two_by_two_cells():
    # black white      a step up in the first row, down in the second, down in the second column
    # white black      and up in the first
    white = np.array([[False, True], [True, False]])
    assert steps_of(white).tolist() == [1, -1, 1, -1]


def test_edge_points_lie_between_black_and_white():
    points = edge_points(np.array([[True, False], [True, True]]), np.array([0.0]))
    pairs = {(tuple(at), tuple(out)) for at, out in zip(points.middle.tolist(), points.outward.tolist())}
    assert ((0.0, -0.5), (1.0, 0.0)) in pairs  # black left of white
    assert ((0.5, 0.0), (0.0, -1.0)) in pairs  # black below white
    assert ((-1.0, 0.5), (-1.0, 0.0)) in pairs  # the paper around is white
    assert len(pairs) == 8


@pytest.mark.parametrize('left', [1.0, 0.5, 0.15])
def test_code_is_read_whatever_light_is_left_in_half_of_it(left):
    white = np.pad(np.pad(code.encode(77), 2), 2, constant_values=True)
    image = np.kron(np.where(white, 180.0, 30.0), np.ones((10, 10)))
    image[:, 72:] *= left
    h = homography.from_square(np.array([[[19.5, 19.5], [109.5, 19.5], [109.5, 109.5], [19.5, 109.5]]]), 4.5)
    match = LocalDecoder(2).match(image.astype(np.uint8), h)
    assert match.word[0] == 77 and match.fit[0] > 0.75 and match.score_gap[0] > 0.05
    assert match.rim[0] > 0.9 and match.plain[0] > 0.8


def test_square_is_found_from_parts_of_its_sides():
    # the sides of the square from 100 to 200, with 40 px missing in the upper one and half of the left one
    parts = np.array([[[105, 100], [130, 100]], [[170, 100], [195, 100]], [[200, 105], [200, 195]],
                      [[195, 200], [105, 200]], [[100, 150], [100, 195]][::-1],
                      [[20, 300], [400, 310]], [[400, 320], [20, 310]]], float)
    quads = broken_outlines.squares(parts)
    square = np.array([[100, 100], [200, 100], [200, 200], [100, 200]])
    off = [min(np.abs(np.roll(quad, turn, 0) - square).max() for turn in range(4)) for quad in quads]
    assert min(off) < 1e-6
    assert (homography.area(quads) > 0).all()
    assert len(broken_outlines.squares(parts[:2])) == 0


def test_parts_that_form_no_square_give_no_warning():
    random = np.random.default_rng(414)  # two corners with sides of 0 px in sum
    parts = 20.0 * random.integers(0, 8, (random.integers(3, 30), 2, 2))
    with np.errstate(divide='raise', invalid='raise'):
        broken_outlines.squares(parts[np.ptp(parts, 1).max(1) > 0])


def test_parts_are_kept_that_are_dark_on_their_right():
    image = np.full((60, 60), 100, np.uint8)
    image[30:] = 40
    edge = np.array([[10, 29.5], [50, 29.5]])  # to the right in the image: dark on the right
    parts = np.array([edge, edge[::-1], edge - [0, 15]])
    assert broken_outlines.distinct_parts(image, parts).tolist() == [edge.tolist()]


def scored(name, count):
    return marker_score.scored((marker_classes.photo(name, marker_classes.DEVELOPMENT, number)
                                for number in range(count)), marker_score.detector_of(marker_classes.SIZE))


@pytest.mark.parametrize('name', ['shadow 0.2', 'pole', *nightly('shadow 0.5', 'shadow 0.35', 'soft shadow')])
def test_markers_in_a_shadow_are_found_and_exact(name):
    score = scored(name, 5)
    assert score.recall >= 80 and np.median(score.corners()) < 0.25  # px
    assert max(score.rotations(sure=True)) < 3.0  # degrees
    assert score.wrong == score.false == score.flips == 0


@pytest.mark.parametrize('name, number', [
    ('pole', 1), ('pole', 28),  # other squares beside it have as good a rim
    ('tilt', 4), ('tilt', 25),  # the longest side is four to five times the shortest
])
def test_marker_that_was_missed_is_found(name, number, monkeypatch):
    monkeypatch.setitem(marker_classes.HALVES, 'others', 10)
    shot = marker_classes.photo(name, 'others', number)
    found = Detector(marker_classes.SIZE).detect(shot.image, shot.camera)
    assert [each.id for each in found] == [shot.frame['markers'][0]['id']]


def test_markers_behind_blinds_are_found_and_exact():
    score = scored('blinds', 8)
    assert score.recall >= 90 and np.median(score.corners()) < 0.25  # px
    assert max(score.rotations(sure=True)) < 3.0  # degrees
    assert score.wrong == score.false == score.flips == 0


def test_markers_in_the_glare_of_a_lamp_are_exact():
    score = scored('glare', 16)
    assert score.recall >= 80 and np.median(score.corners()) < 0.15 and max(score.corners()) < 1.0  # px
    assert max(score.rotations(sure=True)) < 3.0 and sum(score.flags()) <= 1  # degrees
    assert score.wrong == score.false == 0


def test_markers_under_a_lamp_reflected_in_laminate_are_found_and_exact():
    score = scored('laminate', 12)
    assert score.recall >= 50 and np.median(score.corners()) < 0.15  # px
    assert max(score.rotations(sure=True)) < 3.0  # degrees
    assert score.wrong == score.false == 0


def striped(angle, left=0.25):
    """Return an image of a dark disc behind stripes at an angle [rad], and their light."""
    y, x = np.mgrid[:240, :320].astype(float)
    light = np.where((y * np.cos(angle) - x * np.sin(angle)) % 24 < 10, left, 1.0)
    image = np.where(np.hypot(x - 160, y - 120) < 30, 40, 200) * light
    return cv2.GaussianBlur(image.astype(np.uint8), (5, 5), 0), light


@pytest.mark.parametrize('angle', [-1.2, 0.0, 0.4, math.pi / 2])
def test_stripes_are_recognized_by_the_parts_of_outlines_and_taken_out(angle):
    image, light = striped(angle)
    parts = []
    candidates.candidates(image, parts=parts)
    found = striped_light.stripe_angle(parts[0], math.hypot(*image.shape))
    assert abs(math.remainder(found - angle, math.pi)) < 0.01
    even = striped_light.without_stripes(image, found)
    y, x = np.mgrid[:240, :320]
    far = np.hypot(x - 160, y - 120)
    assert (even[far < 25] < 80).mean() > 0.97 and (even[(far > 35) & (far < 80)] > 150).mean() > 0.97


def test_squares_and_few_edges_are_no_stripes():
    square = np.array([[0, 0], [90, 20], [70, 110], [-20, 90]], float)
    sides = np.stack([square, np.roll(square, -1, 0)], 1)
    assert striped_light.stripe_angle(np.concatenate([sides + [x, 5] for x in range(0, 500, 5)]), 800.0) is None
    assert striped_light.stripe_angle(sides[:1], 800.0) is None
    assert striped_light.stripe_angle(sides[:0], 800.0) is None


def test_markers_with_a_thin_margin_on_a_dark_table_are_found_exact_and_without_a_flag():
    score = scored('thin margin', 20)
    assert score.recall == 100 and score.wrong == score.false == 0
    assert np.median(score.corners()) < 0.2 and np.percentile(score.corners(), 90) < 0.6  # px
    assert sum(score.flags()) <= 1


@pytest.mark.parametrize('contrast, cell', [(17, 3.5), *nightly((20, 2.6), (30, 2.3))])
def test_faint_small_marker_on_a_table_as_dark_as_its_print_is_found(contrast, cell):
    camera, side = default_camera(320, 240), round(11 * cell)  # px; a white margin of one cell
    for number in range(0, 256, 50):
        white = np.pad(np.pad(code.encode(number), 2), 1, constant_values=True)
        printed = np.kron(30 + contrast * white.astype(np.float32), np.ones((12, 12), np.float32))
        image = np.full((240, 320), 30, np.float32)
        image[100:100 + side, 140:140 + side] = cv2.resize(printed, (side, side), interpolation=cv2.INTER_AREA)
        image = cv2.GaussianBlur(image, (0, 0), 0.8).astype(np.uint8)
        assert [each.id for each in Detector(0.1).detect(image, camera)] == [number]


def test_most_markers_of_13_to_20_px_are_found():
    score = scored('13 to 20 px', 10)
    assert score.recall >= 70 and score.wrong == score.false == 0


@pytest.mark.nightly
def test_few_right_poses_of_small_markers_have_a_flag_and_no_wrong_one_has_none():
    for name, most in ('13 to 20 px', 0.4), ('20 to 25 px', 0.15):
        score = scored(name, 40)
        assert np.mean(score.flags(good_only=True)) < most
        assert max(score.rotations(sure=True)) < 5.0  # degrees


def test_no_look_alike_is_a_marker():
    assert scored(marker_classes.LOOK_ALIKES, 3).false == 0


def test_reading_does_not_depend_on_the_rotation_of_the_marker():
    for turns in range(4):
        word = turns * 256 + 5
        decoder = LocalDecoder(2)
        black = black_cells(decoder.words[word], 2)
        image = np.kron(np.where(np.pad(~black, 2, constant_values=True), 200.0, 20.0), np.ones((8, 8)))
        h = homography.from_square(np.array([[[15.5, 15.5], [87.5, 15.5], [87.5, 87.5], [15.5, 87.5]]]), 4.5)
        assert decoder.match(image.astype(np.uint8), h).word[0] == word


@pytest.mark.parametrize('name, number, speed', [
    ('shadow 0.35', 0, 2), ('blinds', 0, 1), *nightly(('blinds', 1, 1), ('blinds', 2, 1), ('blinds', 3, 1))])
def test_tracker_keeps_a_marker(name, number, speed):
    """It moves by ``speed`` px in each image."""
    shot = marker_classes.photo(name, marker_classes.DEVELOPMENT, number)
    tracker, marker = Tracker(Detector(marker_classes.SIZE)), shot.frame['markers'][0]['id']
    found = [[each.id for each in tracker.update(np.roll(shot.image, speed * step, 1), shot.camera)]
             for step in range(6)]
    assert found == [[marker]] * 6


def test_tracker_finds_a_new_marker_in_a_shadow_within_full_every_frames():
    shot = marker_classes.photo('shadow 0.2', marker_classes.DEVELOPMENT, 1)
    for frames_without in (1, 2, 3):
        tracker = Tracker(Detector(marker_classes.SIZE))
        for _ in range(frames_without):
            assert tracker.update(np.full_like(shot.image, 120), shot.camera) == []
        seen = [tracker.update(shot.image, shot.camera) for _ in range(tracker.full_every)]
        assert [each.id for each in seen[-1]] == [shot.frame['markers'][0]['id']]


@pytest.mark.parametrize('margin, seed', [(3, 405), (1, 404), *nightly((3, 407), (3, 409), (3, 419))])
def test_markers_with_another_margin_are_not_found(margin, seed):
    rng, camera = np.random.default_rng(seed), default_camera(distorted=True)
    blur, noise = rng.uniform([0.4, 1], [1.1, 4]).tolist()
    scene = Scene(blur=blur, noise=noise, shadow=seed % 3 == 0, clutter=3)
    placed = random_markers(rng, camera, scene, 4, side=(35, 130), size=0.1, cover=0.15)
    image = image_of(rng, camera, placed, scene, margin)
    assert not Detector(0.1).detect(image, camera)
    assert Detector(0.1, margin=margin).detect(image, camera)
