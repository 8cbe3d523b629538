"""Following markers: nothing invented or kept, changes right in the next frame, motion settles the ambiguity."""
import numpy as np
import pytest

from alvar_core import rotations
from alvar_core.camera import default_camera
from alvar_core.detection import candidates, thresholds
from alvar_core.detection.detector import Detector
from alvar_core.detection.prepared_image import ImageError
from alvar_core.detection.tracker import Tracker
from rostest_support.marker_scenes import Placed, Scene, image_of
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

SIZE = 0.1
CAMERA = default_camera()


def picture(seed, placed, **how):
    how.setdefault('noise', 1.5)
    return image_of(np.random.default_rng(seed), CAMERA, placed, Scene(**how))


def one(marker_id=42, tilt=30, azimuth=40, roll=20, position=(0, 0, 0.6), **more):
    rotation = rotations.facing(*np.radians([tilt, azimuth, roll]))
    return Placed(marker_id, SIZE, rotation, np.array(position, float), **more)


def ids(found):
    return sorted(d.id for d in found)


def started(placed, frames=4):
    tracker, grey = Tracker(Detector(SIZE)), picture(1, placed)
    for _ in range(frames):
        assert ids(tracker.update(grey, CAMERA)) == sorted(p.id for p in placed)
    return tracker


@pytest.mark.parametrize('frames', [4, *nightly(3, 5)])
def test_swapped_marker_is_right_in_the_next_frame(frames):
    tracker = started([one(1)], frames)
    assert ids(tracker.update(picture(1, [one(2)]), CAMERA)) == [2]


@pytest.mark.parametrize('frames', [4, *nightly(3, 5)])
def test_turned_marker_is_right_in_the_next_frame(frames):
    tracker = started([one(1, roll=20)], frames)
    turned = one(1, roll=110)
    found = tracker.update(picture(1, [turned]), CAMERA)
    assert ids(found) == [1]
    assert rotations.angle_between(found[0].rotation, turned.rotation) < np.radians(3)


@pytest.mark.parametrize('frames', [4, *nightly(3, 5)])
def test_removed_marker_is_gone_in_the_next_frame(frames):
    tracker = started([one(1), one(2, position=(0.2, 0, 0.6))], frames)
    assert ids(tracker.update(picture(1, [one(2, position=(0.2, 0, 0.6))]), CAMERA)) == [2]
    assert tracker.update(picture(1, []), CAMERA) == []


def test_of_two_markers_with_one_id_any_may_go():
    places = [one(1, position=(x, 0, 0.6)) for x in (-0.15, 0.15)]
    for stays in places:
        found = started(places).update(picture(1, [stays]), CAMERA)
        assert ids(found) == [1] and abs(found[0].position[0] - stays.position[0]) < 0.01


def test_covered_marker_is_not_reported_and_comes_back_at_once():
    placed = one(1)
    tracker = started([placed])
    hidden = picture(1, [placed])
    low, high = placed.corners.min(0).astype(int), placed.corners.max(0).astype(int)
    hidden[low[1] - 4:high[1] + 4, low[0] - 4:low[0] + (high[0] - low[0]) * 2 // 3] = 140
    assert tracker.update(hidden, CAMERA) == []
    assert ids(tracker.update(picture(1, [placed]), CAMERA)) == [1]


@pytest.mark.parametrize('frames, distance', [  # 66 or 131 px wide
    (4, 0.4), (4, 0.8), *nightly((3, 0.8), (5, 0.4), (5, 0.8))])
def test_new_marker_is_seen_in_the_next_frame(frames, distance):
    tracker = started([one(1, position=(-0.15, 0, 0.6))], frames)
    both = [one(1, position=(-0.15, 0, 0.6)), one(2, position=(0.2 * distance, 0.1 * distance, distance))]
    assert ids(tracker.update(picture(1, both), CAMERA)) == [1, 2]


def test_new_marker_that_is_hard_to_see_is_seen_when_the_search_is_through():
    tracker = started([one(1)], 4)
    both = [one(1), one(2, position=(0.55, 0.4, 2.6), tilt=10)]  # 20 px
    grey = picture(1, both)
    assert [ids(tracker.update(grey, CAMERA)) for _ in range(tracker.full_every)][-1] == [1, 2]


@pytest.mark.parametrize('frames', [4, *nightly(3, 5)])
def test_new_marker_that_is_hard_to_see_is_seen_in_the_next_frame_after_the_rest_was_searched(frames):
    tracker = started([one(1)], frames)
    both = picture(1, [one(1), one(2, position=(0.55, 0.4, 2.6), tilt=10)])  # 20 px
    tracker.update(both, CAMERA)
    tracker.search_rest()
    assert ids(tracker.update(both, CAMERA)) == [1, 2]


def test_what_the_rest_of_the_search_found_is_not_reported_when_it_is_gone():
    tracker = started([one(1)], 4)
    tracker.update(picture(1, [one(1), one(2, position=(0.2, 0.1, 0.8))]), CAMERA)
    tracker.search_rest()
    assert ids(tracker.update(picture(1, [one(1)]), CAMERA)) == [1]


def test_searching_the_rest_twice_or_before_any_picture_does_nothing():
    tracker = Tracker(Detector(SIZE))
    tracker.search_rest()
    grey = picture(1, [one(1)])
    for _ in range(2):
        assert ids(tracker.update(grey, CAMERA)) == [1]
    tracker.search_rest()
    tracker.search_rest()
    assert ids(tracker.update(grey, CAMERA)) == [1]


@pytest.mark.parametrize('full_every', [1, 2, 3, 6])
def test_every_pass_is_made_once_in_full_every_frames(full_every, monkeypatch):
    tracker = Tracker(Detector(SIZE), full_every)
    grey, made = picture(1, [one(1)]), []
    tracker.update(grey, CAMERA)
    found = candidates.candidates
    monkeypatch.setattr(candidates, 'candidates', lambda smooth, passes, *more: (made.extend(passes),
                                                                            found(smooth, passes, *more))[1])
    for _ in range(full_every):
        assert ids(tracker.update(grey, CAMERA)) == [1]
    assert sorted(made) == sorted(thresholds.PASSES)


@pytest.mark.parametrize('full_every', [0, -1, 1.5, None])
def test_impossible_full_every_is_refused(full_every):
    with pytest.raises(ValueError, match='full_every'):
        Tracker(Detector(SIZE), full_every)


def test_bad_picture_is_refused_and_forgets_nothing():
    tracker = started([one(1)])
    with pytest.raises(ImageError):
        tracker.update(np.zeros((480, 640), np.float32), CAMERA)
    assert len(tracker.tracks) == 1 and ids(tracker.update(picture(1, [one(1)]), CAMERA)) == [1]


def test_fast_motion_is_followed():
    tracker = Tracker(Detector(SIZE))
    for k in range(12):
        placed = one(5, position=(-0.2 + 0.03 * k, 0, 0.6))
        found = tracker.update(picture(k, [placed]), CAMERA)
        assert ids(found) == [5]
        assert np.linalg.norm(found[0].position - placed.position) < 0.005


def test_motion_settles_the_ambiguity():
    # It comes from near, where the tilt is clear, and goes far, where one picture alone leaves it open.
    tracker, alone, flips, flips_alone = Tracker(Detector(SIZE)), Detector(SIZE), 0, 0
    for k in range(24):
        placed = one(3, tilt=25, azimuth=70, position=(0.02, 0, 0.5 + 0.09 * k))
        grey = picture(400 + k, [placed], noise=4.0, blur=0.9)
        for found, followed in ((tracker.update(grey, CAMERA), True), (alone.detect(grey, CAMERA), False)):
            wrong = sum(rotations.angle_between(d.rotation, placed.rotation) > np.radians(25) for d in found)
            flips += wrong if followed else 0
            flips_alone += 0 if followed else wrong
    assert flips == 0 and flips <= flips_alone


@pytest.mark.parametrize('away, back', [(0.25, 0.25), (0.25, 0.0), (-0.25, 0.25)])
def test_marker_that_jumps_away_and_on_is_followed(away, back):
    """Too far to be the same one: two of the id are remembered then, and either may be seen next."""
    tracker = started([one(1)])
    for x in (away, away, back, back):
        there = one(1, position=(x, 0, 0.6))
        found = tracker.update(picture(1, [there]), CAMERA)
        assert ids(found) == [1]
        assert np.abs(found[0].position - there.position).max() < 0.02 * 0.6  # 2 %


def test_another_picture_size_starts_anew():
    tracker = started([one(1)])
    assert tracker.update(np.full((240, 320), 128, np.uint8), CAMERA) == []
