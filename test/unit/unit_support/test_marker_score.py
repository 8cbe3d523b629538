"""The score by hand-made frames: one marker of side 40 px in the middle of a 640x480 picture."""
import math

import pytest

from alvar_core.camera import Camera
from unit_support import marker_score

CAMERA = Camera([400, 0, 319.5, 0, 400, 239.5, 0, 0, 1])
UPRIGHT, TURNED_40 = [1.0, 0, 0, 0], [math.cos(math.radians(20)), math.sin(math.radians(20)), 0, 0]


def marker(marker_id=5, x=0.0, ignore=False):
    """0.1 m wide, 1 m away, x m to the right: 40 px wide, 400 x px right of the middle."""
    u, v = 319.5 + 400 * x, 239.5
    return {'id': marker_id, 'position': [x, 0, 1], 'orientation': UPRIGHT, 'distance_m': 1.0, 'ignore': ignore,
            'corners': [[u - 20, v - 20], [u + 20, v - 20], [u + 20, v + 20], [u - 20, v + 20]]}


def detection(marker_id=5, position=(0, 0, 1), orientation=UPRIGHT, **more):
    return dict({'id': marker_id, 'position': list(position), 'orientation': orientation}, **more)


def scored(detections, *markers):
    return marker_score.score_frame({'markers': list(markers or [marker()])}, CAMERA, 640, detections)


def counts(result):
    return len([m for m in result.matches if m.detection]), result.false, result.wrong, result.double


@pytest.mark.parametrize('found, expected', [
    ([], (0, 0, 0, 0)),
    ([detection()], (1, 0, 0, 0)),
    ([detection(), detection(position=(0.01, 0, 1))], (1, 0, 0, 1)),
    ([detection(6)], (0, 0, 1, 0)),  # on the marker, another id
    ([detection(6, (0.3, 0, 1))], (0, 1, 0, 0)),  # 120 px beside it
    ([detection(position=(0.159, 0, 1))], (1, 0, 0, 0)),  # 63.6 px away: within a tenth of the width
    ([detection(position=(0.161, 0, 1))], (0, 1, 0, 0)),
    ([detection(position=(0, 0, -1))], (0, 1, 0, 0)),  # behind the camera
    ([{'id': 5}], (1, 0, 0, 0)),
    ([{'id': 6}], (0, 1, 0, 0)),
])
def test_counts(found, expected):
    assert counts(scored(found)) == expected


def test_marker_cut_by_the_edge_counts_neither_way():
    result = scored([detection()], marker(ignore=True))
    assert counts(result) == (0, 0, 0, 0) and math.isnan(result.recall)


def test_errors_are_of_the_nearest_detection():
    result = scored([detection(position=(0.01, 0, 1)), detection(position=(0.002, 0, 1), orientation=TURNED_40)])
    assert result.position(50) == pytest.approx(0.2) and result.rotation(95) == pytest.approx(40)


@pytest.mark.parametrize('ambiguous, flips', [(False, 1), (True, 0)])
def test_flagged_flip_is_none(ambiguous, flips):
    assert scored([detection(orientation=TURNED_40, ambiguous=ambiguous)]).flips == flips


def test_recall_over_frames():
    truth = {'cameras': {'c': {'K': CAMERA.matrix.ravel().tolist(), 'D': [], 'width': 640, 'height': 480}},
             'frames': [{'name': name, 'camera': 'c', 'difficulty': 'easy', 'markers': [marker(), marker(7, 0.4)]}
                        for name in 'ab']}
    found = marker_score.score(truth, {'a': {'detections': [detection(), detection(7, (0.4, 0, 1))]}})
    assert found['easy'].recall == 50 and counts(found['easy']) == (2, 0, 0, 0)


@pytest.mark.parametrize('a, b, degrees', [(UPRIGHT, [-2.0, 0, 0, 0], 0), (UPRIGHT, [0, 0, 1, 0], 180),
                                           (UPRIGHT, TURNED_40, 40), (UPRIGHT, [0, 0, 0, 0], 180)])
def test_angle_between_quaternions(a, b, degrees):
    assert marker_score.rotation_between(a, b) == pytest.approx(degrees)
