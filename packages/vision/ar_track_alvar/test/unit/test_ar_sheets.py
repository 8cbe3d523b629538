"""The sheets in markers/ show the markers that their names and the bundle files say."""

import cv2
import pytest

from alvar_core import bundles
from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from unit_support import REPOSITORY

FOLDER = REPOSITORY / 'packages' / 'vision' / 'ar_track_alvar'
EDGE, SIDE = 60, 166  # [px] of white around; of a marker of 4.4 cm, at 96 px for each inch


def found(name):
    """Return {id: centre [px]} of the markers on a sheet."""
    image = cv2.imread(str(FOLDER / 'markers' / name), cv2.IMREAD_GRAYSCALE)
    image = cv2.copyMakeBorder(image, EDGE, EDGE, EDGE, EDGE, cv2.BORDER_CONSTANT, value=255)
    detections = Detector(0.044).detect(image, default_camera(*image.shape[::-1]))
    assert all(abs(each.side - SIDE) < 2 for each in detections)
    return {each.id: each.centre for each in detections}


@pytest.mark.parametrize('name, ids', [('Markers_0_to_8.png', range(9)), ('Markers_9_to_17.png', range(9, 18)),
                                       ('table_8_9_10.png', (8, 9, 10))])
def test_a_sheet_shows_its_markers(name, ids):
    assert sorted(found(name)) == list(ids)


def test_the_sheet_of_a_bundle_fits_its_file():
    centres, bundle = found('table_8_9_10.png'), bundles.read(FOLDER / 'bundles' / 'table_8_9_10.xml')
    for number, (x, y) in centres.items():
        place = bundle.corners[number].mean(0) / 0.0254 * 96
        expected = centres[8][0] + place[0], centres[8][1] - place[1]
        assert (x, y) == pytest.approx(expected, abs=1.5)
