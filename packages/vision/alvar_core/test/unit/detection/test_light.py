"""Where greys are not proportional to light, markers are measured in light; what the camera makes of it is learnt."""
import functools

import numpy as np
import pytest

from alvar_core.detection.detector import Detector
from alvar_core.detection.light import LINEAR, Evidence, Light, Response
from alvar_core.detection.pyramid import Pyramid
from unit_support import marker_classes
from unit_support.photo import with_gamma

pytestmark = pytest.mark.slow

GAMMA = 2.2
CORNER_TOLERANCE = 0.05  # px, median of the worst corners; without light it is 0.25
DISTANCE_TOLERANCE = 0.0003  # of the distance, median; without light it is 0.004
GAMMA_TOLERANCE = 0.15


@functools.lru_cache(None)
def photo(name, number):
    return marker_classes.photo(name, marker_classes.DEVELOPMENT, number)


def measured(name, detector, gamma, count=6):
    """Return the median of the worst corners [px], and of how much too long the distances are, of some photos."""
    corners, distances = [], []
    for number in range(count):
        shot = photo(name, number)
        right, = shot.frame['markers']
        for found in detector.detect(with_gamma(shot.image, gamma), shot.camera):
            corners.append(np.linalg.norm(found.corners - right['corners'], axis=1).max())
            distances.append(np.linalg.norm(found.position) / right['distance_m'] - 1)
    assert len(corners) > count // 2
    return np.median(corners), np.median(distances)


@pytest.mark.parametrize('known', [GAMMA, None])
def test_markers_are_as_exact_as_with_a_linear_camera(known):
    detector = Detector(marker_classes.SIZE, gamma=known)
    corner, distance = measured('even', detector, GAMMA)
    assert corner < CORNER_TOLERANCE and abs(distance) < DISTANCE_TOLERANCE
    assert detector.gamma == known or abs(detector.gamma - GAMMA) < GAMMA_TOLERANCE


def test_without_light_they_look_too_small():
    corner, distance = measured('even', Detector(marker_classes.SIZE, gamma=1.0), GAMMA)
    assert corner > 4 * CORNER_TOLERANCE and distance > 10 * DISTANCE_TOLERANCE


def test_a_linear_camera_is_told_from_others():
    detector, known = Detector(marker_classes.SIZE), Detector(marker_classes.SIZE, gamma=1.0)
    assert measured('even', detector, 1.0) == measured('even', known, 1.0)
    assert detector.gamma == 1


@pytest.mark.parametrize('name', ['shadow 0.35', 'bent 10 cm'])
def test_shadows_and_bent_paper_are_measured_in_light(name):
    wrong, _ = measured(name, Detector(marker_classes.SIZE, gamma=1.0), GAMMA)
    right, _ = measured(name, Detector(marker_classes.SIZE, gamma=GAMMA), GAMMA)
    assert right < 0.5 * wrong


def test_response_follows_a_camera_slowly():
    """Each image asks for gamma 2; a first guess is forgotten, later ones count as much as what is known."""
    response, information = Response(), 400.0
    images = []
    for _ in range(40):
        change = 2.0 / response.light.gamma - 1
        images.append(response.learn([Evidence(information, information * change)]))
    assert images[0] and not any(images[1:]) and response.light.gamma == pytest.approx(2.0)
    assert response.learn([Evidence(1e9, 0.5e9)]) is False  # one marker that asks for 3 changes little
    assert 2.0 < response.light.gamma < 2.1


def test_response_does_not_learn_what_is_known_or_hardly_differs():
    for response, change in (Response(1.8), 0.5), (Response(), 0.05), (Response(), -0.3):
        before = response.light.gamma
        assert not response.learn([Evidence(400.0, 400.0 * change)]) and response.light.gamma == before
    assert not Response().learn([Evidence(0.0, 0.0)]) and not Response().learn([])


def test_smaller_images_have_the_mean_of_the_light():
    """Half of 255's light is the grey 255 * 0.5 ** (1 / 2.2) = 186; a grey of its own stays what it is."""
    stripes = np.tile(np.array([0, 255], np.uint8), (32, 32))
    level = Pyramid(stripes, light=Light(GAMMA)).memory['atlas'][32:48, :32]
    assert np.abs(level.astype(int) - 186).max() <= 1
    for grey in range(5, 256, 10):
        plain = Pyramid(np.full((32, 64), grey, np.uint8), light=Light(GAMMA)).memory['atlas'][32:48, :32]
        assert np.abs(plain.astype(int) - grey).max() <= 1


def test_greys_and_light_are_each_others_inverse():
    light, greys = Light(GAMMA), np.arange(256, dtype=np.uint8)[None]
    assert light.greys(light.of(greys)) == pytest.approx(greys, abs=0.01)
    assert LINEAR.of(greys) is greys


@pytest.mark.parametrize('gamma', [0, 0.5, 9, float('nan'), '2.2', True])
def test_wrong_gamma_is_refused(gamma):
    with pytest.raises(ValueError, match=r'gamma .*: a number from 1 to 4 is needed'):
        Detector(0.1, gamma=gamma)
