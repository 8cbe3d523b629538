"""Images full of markers: all are found; if there are more than may be searched, each has its turn."""
import functools

import numpy as np
import pytest

from alvar_core import native
from alvar_core.detection.candidates import Turns
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from unit_support import marker_classes
from unit_support.photo import with_gamma

pytestmark = pytest.mark.slow


@functools.lru_cache(None)
def crowd(*layout):
    return marker_classes.crowd(*layout, 0)


def numbers(shot):
    return sorted(each['id'] for each in shot.frame['markers'])


@pytest.mark.parametrize('layout, gamma', [
    ((640, 480, 10, 6), 1.0), ((640, 480, 10, 6), 2.2), ((1280, 720, 20, 10), 1.0)])
def test_all_are_found(layout, gamma):
    shot = crowd(*layout)
    detector = Detector(marker_classes.SIZE)
    found = detector.detect(with_gamma(shot.image, gamma), shot.camera)
    assert sorted(each.id for each in found) == numbers(shot) and detector.left_out == 0


def test_what_lies_on_a_marker_that_has_been_read_is_not_looked_at():
    """Of ten candidates for each marker, the first is enough."""
    shot = crowd(640, 480, 10, 6)
    detector = Detector(marker_classes.SIZE)
    image, corners = detector.prepare(shot.image, shot.camera), [each['corners'] for each in shot.frame['markers']]
    seen, _, well_read, refined = detector._search.find(image, np.tile(corners, (10, 1, 1)), marker_classes.SIZE, {},
                                                        Turns(400))
    assert sorted(each.number for each in seen) == numbers(shot)
    assert 60 <= len(refined) < 80 and not len(well_read)


def test_points_on_a_square_are_told_from_others():
    points = np.array([[10.0, 10], [12, 8], [12.1, 10], [50, 47], [50, 46.9]])
    free = native.steps.free_of(squares=[(10, 10, 2), (50, 50, 3)], points=points)
    assert free.tolist() == [False, False, True, False, True]
    assert native.steps.free_of(squares=np.zeros((0, 3)), points=points).all()


def test_a_tracker_reports_all_in_each_image():
    shot = crowd(640, 480, 10, 6)
    tracker = Tracker(Detector(marker_classes.SIZE))
    for _ in range(4):
        assert sorted(each.id for each in tracker.update(shot.image, shot.camera)) == numbers(shot)


def test_too_many_take_turns():
    shot = crowd(640, 480, 10, 6)
    detector, found = Detector(marker_classes.SIZE, max_candidates=20), []
    for _ in range(4):
        one = [each.id for each in detector.detect(shot.image, shot.camera)]
        assert len(one) <= 20 and 40 <= detector.left_out < 60
        found += one
    assert sorted(set(found)) == numbers(shot)  # of up to 80 candidates
    assert max(map(found.count, found)) <= 2


def test_turns_go_from_top_to_bottom_and_start_again():
    """Five quads, the last one uppermost, two at a time."""
    quads = np.array([[[0, 10 * k], [5, 10 * k], [5, 10 * k + 5], [0, 10 * k + 5]] for k in (1, 2, 3, 4, 0)], float)
    turns, order = Turns(2), []
    for _ in range(5):
        turns.start()
        order += turns.of(quads, [0, 1, 2, 3, 4])
        assert turns.left_out == 3
    assert order == [0, 4, 1, 2, 3, 4, 0, 1, 2, 3]
    turns.start()
    assert turns.of(quads, [3, 1]) == [0, 1] and turns.left_out == 0


@pytest.mark.parametrize('most', [0, -1, 1.5, True, '9'])
def test_wrong_number_of_candidates_is_refused(most):
    with pytest.raises(ValueError, match=r'max_candidates .*: a whole number of at least 1 is needed'):
        Detector(0.1, max_candidates=most)
