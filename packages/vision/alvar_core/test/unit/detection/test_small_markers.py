"""Markers with cells of 1.1 to 1.5 px are read, and squares of random cells as small are not."""
import math

import numpy as np
import pytest

from alvar_core.detection import thresholds
from alvar_core.detection.detector import Detector
from unit_support import marker_classes
from unit_support.photo import Photo, Sheet, with_gamma

KIND, PHOTOS, LEAST = '10 to 13.5 px', 20, 15
NOT_MARKERS = 40


@pytest.mark.parametrize('gamma', [1.0, 2.2])
def test_they_are_read(gamma):
    detector, found = Detector(marker_classes.SIZE), 0
    for number in range(PHOTOS):
        shot = marker_classes.photo(KIND, marker_classes.DEVELOPMENT, number)
        ids = [each.id for each in detector.detect(with_gamma(shot.image, gamma), shot.camera)]
        assert set(ids) <= {shot.frame['markers'][0]['id']}
        found += len(ids)
    assert found >= LEAST


def random_squares():
    rng, camera = np.random.default_rng(4), marker_classes.CAMERAS[0]
    made = Photo(camera, (marker_classes.WIDTH, marker_classes.HEIGHT), [])
    for place in range(NOT_MARKERS):
        at = (np.array([place % 8, place // 8]) + 0.5) * [marker_classes.WIDTH / 8, marker_classes.HEIGHT / 5]
        distance = camera.fx * marker_classes.SIZE / math.exp(rng.uniform(math.log(10), math.log(15)))
        position = np.append(camera.to_rays(camera.to_ideal(at)), 1.0) * distance
        cells = np.pad(rng.integers(0, 2, (5, 5)).astype(bool), 2)
        made.sheets.append(Sheet(cells, None, marker_classes.SIZE, np.diag([1.0, -1.0, -1.0]), position))
    return made.render(rng), camera


def test_other_small_squares_are_not(monkeypatch):
    image, camera = random_squares()
    assert not Detector(marker_classes.SIZE).detect(image, camera)
    monkeypatch.setattr(thresholds, 'SMALL_FIT', 0.0)
    assert Detector(marker_classes.SIZE).detect(image, camera)  # the fit is what tells them apart
