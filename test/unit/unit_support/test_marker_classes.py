"""The photos by class: geometry of bent sheets, light, ground truth, halves; their scores."""
import copy

import numpy as np
import pytest

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from unit_support import marker_classes, photo
from unit_support.cases import nightly
from unit_support.marker_classes import DEVELOPMENT, KINDS, LOOK_ALIKES, TEST
from unit_support.marker_score import Score, detector_of, score_frame

pytestmark = pytest.mark.slow

CAMERA = default_camera()
SURFACES = [photo.Flat(), photo.Cylinder(0.06, 0.7), photo.Cylinder(-0.1, 2.0), photo.Creased(0.2, 1.0, 0.01)]


def test_arc_of_a_cylinder_is_as_long_as_the_paper():
    # a quarter turn of radius 0.1 m is 0.157 m of paper; its end is 0.1 m aside and 0.1 m back
    end = photo.Cylinder(0.1, 0.0).to_space(np.array(0.05 * np.pi), np.array(0.02))
    assert end == pytest.approx([0.1, 0.02, -0.1])
    assert photo.Cylinder(-0.1, 0.0).to_space(np.array(0.05 * np.pi), np.array(0.0))[2] == pytest.approx(0.1)


def test_crease_turns_what_is_beyond_it():
    # 0.03 m beyond the crease, turned by 90 degrees, is 0.03 m back
    bent = photo.Creased(np.pi / 2, 0.0, 0.01)
    assert bent.to_space(np.array(0.04), np.array(0.0)) == pytest.approx([0.01, 0, -0.03])


@pytest.mark.parametrize('surface', SURFACES, ids=lambda each: type(each).__name__)
def test_rays_meet_the_sheet_where_it_is(surface):
    s, t = np.array([0.0, 0.02, -0.02, 0.01]), np.array([0.0, 0.02, 0.01, -0.02])
    origin = np.array([0.05, -0.03, 0.5])
    rays = surface.to_space(s, t) - origin
    met = surface.to_sheet(origin, rays)
    for k in range(len(s)):
        assert any(good[k] and abs(u[k] - s[k]) < 1e-9 and abs(v[k] - t[k]) < 1e-9 for u, v, _, good in met)


def test_flat_marker_is_drawn_where_its_corners_are():
    rotation, position = rotations.facing(0.5, 1.0, 0.3), np.array([0.02, 0.01, 0.3])
    sheet = photo.Sheet(marker_classes.marker_cells(42), 42, 0.05, rotation, position)
    shot = photo.Photo(CAMERA, (640, 480), [sheet]).render(np.random.default_rng(1))
    found = detector_of(0.05)(shot, CAMERA)
    assert [each['id'] for each in found] == [42]
    assert np.abs(np.subtract(found[0]['corners'], sheet.corners(CAMERA))).max() < 0.15  # px
    assert sheet.corners(CAMERA) == pytest.approx(drawing.project(CAMERA, rotation, position,
                                                                  drawing.object_corners(0.05)))


def test_lights_leave_what_they_say():
    x, y = np.meshgrid(np.arange(-100.0, 101.0), np.zeros(1))
    assert photo.shadow((0, 0), 0.0, 2.0, 0.3)(x, y)[0, [0, 100, 200]] == pytest.approx([0.3, 0.65, 1.0])
    assert photo.band((0, 0), 0.0, 20.0, 2.0, 0.3)(x, y)[0, [0, 100, 200]] == pytest.approx([1.0, 0.3, 1.0])
    dark = photo.stripes((0, 0), 0.0, 50.0, 0.4, 0.5, 0.2)(x, y)[0] < 0.6
    assert dark.mean() == pytest.approx(0.4, abs=0.02)
    assert photo.spot((0, 0), 10.0, 80.0)(x, y)[0, [100, 110]] == pytest.approx([80, 80 * np.exp(-0.5)])


@pytest.mark.parametrize('name', [LOOK_ALIKES, *nightly(*KINDS)])
def test_photos_are_the_same_each_time_and_differ_by_half(name):
    first, again, other = (marker_classes.photo(name, half, 1) for half in (DEVELOPMENT, DEVELOPMENT, TEST))
    assert (first.image == again.image).all() and first.frame == again.frame
    assert (first.image != other.image).any()
    for marker in first.frame['markers']:
        assert (np.array(marker['corners']) > 0).all() and (np.array(marker['corners']) < [640, 480]).all()


def test_scores_count_corners_flags_and_rotations():
    shot = marker_classes.photo('even', DEVELOPMENT, 0)
    marker = shot.frame['markers'][0]
    moved = copy.deepcopy(marker['corners'])
    moved[2][0] += 3.0
    right = {'id': marker['id'], 'position': marker['position'], 'orientation': marker['orientation'],
             'corners': moved, 'ambiguous': True}
    score = Score()
    score.add(score_frame(shot.frame, shot.camera, 640, [right, {**right, 'id': marker['id'] ^ 1}]))
    assert score.corners() == pytest.approx([3.0]) and score.recall == 100 and score.wrong == 1
    assert score.flags() == [True] == score.flags(good_only=True) and score.rotations(sure=True) == []
