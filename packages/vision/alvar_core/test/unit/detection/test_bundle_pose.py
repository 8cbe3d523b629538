"""A bundle's pose against ground truth: all markers seen, some covered, one moved; the ambiguity of a single one."""
import numpy as np
import pytest

from alvar_core import bundles, drawing, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import bundle_pose, thresholds
from alvar_core.detection.detector import Detector
from rostest_support.marker_scenes import Placed, Scene, image_of

pytestmark = pytest.mark.slow

SIDE = 0.044  # [m]
PLACES = {8: (0, 0, 0), 9: (0.09, 0, 0), 10: (0, -0.09, 0), 16: (0, 0.09, 0)}
FLAT = bundles.Bundle('flat', 8, tuple(PLACES), {n: drawing.object_corners(SIDE) + at for n, at in PLACES.items()})
TURN = np.array([[0, 0, 1.0], [0, 1, 0], [-1, 0, 0]])  # looks along x of the bundle
POST = bundles.Bundle('post', 1, (1, 2), {1: drawing.object_corners(SIDE),
                                          2: drawing.object_corners(SIDE) @ TURN.T + [0.025, 0, -0.025]})
CAMERA = default_camera(distorted=True)
DETECTOR = Detector(SIDE)
ROTATION = rotations.facing(np.radians(25), 0.7, 0.4)
POSITION = np.array([0.03, -0.02, 0.6])
DEGREE = np.radians(1)


def placed(bundle, number, rotation=ROTATION, position=POSITION, moved=(0, 0, 0)):
    """A marker of a bundle in a scene, moved in the bundle's frame (m)."""
    turn, centre = bundles.marker_pose(bundle.corners[number])
    return Placed(number, SIDE, rotation @ turn, rotation @ (centre + moved) + position)


def seen(markers, seed=0):
    """Detections of placed markers in a rendered picture."""
    rng = np.random.default_rng(seed)
    return DETECTOR.detect(image_of(rng, CAMERA, markers, Scene(blur=0.8)), CAMERA)


def off(found, rotation=ROTATION, position=POSITION):
    """(angle in rad, distance as a share) between a BundlePose and the truth."""
    return rotations.angle_between(found.rotation, rotation), np.linalg.norm(found.position - position) / position[2]


def check(found, rotation=ROTATION, position=POSITION):
    turn, shift = off(found, rotation, position)
    assert turn < 0.5 * DEGREE and shift < 0.002
    assert not found.ambiguous and found.confidence > 0.8


def test_all_markers_together_are_better_than_each():
    detections = seen([placed(FLAT, n) for n in PLACES])
    found = bundle_pose.solve(FLAT, detections, CAMERA)
    check(found)
    assert set(found.used) == set(PLACES) and found.rejected == () and found.error < 0.3
    turns = []
    for detection in detections:
        turn, _ = bundles.marker_pose(FLAT.corners[detection.id])
        turns.append(rotations.angle_between(detection.rotation, ROTATION @ turn))
    assert off(found)[0] < max(turns)


@pytest.mark.parametrize('there', [(8,), (16,), (9, 10), (10, 16, 9)])
def test_the_masters_pose_by_whatever_markers_are_seen(there):
    found = bundle_pose.solve(FLAT, seen([placed(FLAT, n) for n in there]), CAMERA)
    check(found) if len(there) > 1 else None
    turn, shift = off(found)
    assert set(found.used) == set(there) and turn < 2 * DEGREE and shift < 0.005


@pytest.mark.parametrize('moved', PLACES)
def test_a_marker_that_was_moved_is_left_out(moved):
    markers = [placed(FLAT, n, moved=(0.012, 0.008, 0) if n == moved else (0, 0, 0)) for n in PLACES]
    found = bundle_pose.solve(FLAT, seen(markers), CAMERA)
    check(found)
    assert found.rejected == (moved,) and set(found.used) == set(PLACES) - {moved}


def test_a_second_marker_of_the_same_number_does_no_harm():
    other = Placed(9, SIDE, ROTATION, POSITION + [-0.15, 0.08, 0])
    found = bundle_pose.solve(FLAT, seen([placed(FLAT, n) for n in (8, 9, 10)] + [other]), CAMERA)
    check(found)
    assert sorted(found.used) == [8, 9, 10] and found.rejected == (9,)


def test_of_two_that_disagree_the_first_of_the_file_is_right():
    markers = [placed(FLAT, 9, moved=(0.02, 0, 0)), placed(FLAT, 8)]
    found = bundle_pose.solve(FLAT, seen(markers), CAMERA)
    assert (found.used, found.rejected) == ((8,), (9,))
    assert off(found)[1] < 0.005


def test_markers_on_two_sides_of_a_post():
    rotation = rotations.facing(0, 0, 0) @ np.array([[0.7071068, 0, -0.7071068], [0, 1, 0], [0.7071068, 0, 0.7071068]])
    markers = [placed(POST, n, rotation) for n in (1, 2)]
    found = bundle_pose.solve(POST, seen(markers), CAMERA)
    assert set(found.used) == {1, 2}
    check(found, rotation)


def test_several_of_many_were_moved():
    places = {n: (0.07 * (n % 4), 0.07 * (n // 4), 0) for n in range(12)}
    wall = bundles.Bundle('wall', 0, tuple(places), {n: drawing.object_corners(SIDE) + at for n, at in places.items()})
    position = np.array([-0.12, -0.1, 0.7])
    markers = [placed(wall, n, position=position, moved=(0.01 * (n in (1, 6)), -0.012 * (n in (6, 11)), 0))
               for n in places]
    found = bundle_pose.solve(wall, seen(markers), CAMERA)
    check(found, position=position)
    assert set(found.rejected) == {1, 6, 11} and len(found.used) == 9


def test_places_measured_with_a_ruler_will_do():
    rng = np.random.default_rng(1)
    rough = bundles.Bundle('rough', 8, FLAT.ids, {n: corners + [*rng.uniform(-7e-4, 7e-4, 2), 0]
                                                  for n, corners in FLAT.corners.items()})  # [m]
    found = bundle_pose.solve(rough, seen([placed(FLAT, n) for n in PLACES]), CAMERA)
    assert found.rejected == () and not found.ambiguous
    turn, shift = off(found)
    assert turn < 2 * DEGREE and shift < 0.01  # 0.7 mm of 90 mm are 0.8 %


def test_no_marker_no_pose():
    assert bundle_pose.solve(FLAT, [], CAMERA) is None
    assert bundle_pose.solve(POST, seen([placed(FLAT, 8)]), CAMERA) is None


def small_and_ambiguous():
    """Detections of the master alone, so small that its two poses are alike; a picture with that is looked for."""
    rotation, position = rotations.facing(np.radians(12), 0.3, 0), np.array([0.0, 0.0, 1.3])
    for seed in range(20):
        detections = seen([placed(FLAT, 8, rotation, position)], seed)
        if detections and detections[0].ambiguous:
            return detections
    raise AssertionError('no ambiguous picture')


def test_what_is_ambiguous_is_said_and_the_last_picture_decides():
    detections = small_and_ambiguous()
    free = bundle_pose.solve(FLAT, detections, CAMERA)
    assert free.ambiguous and len(free.solutions) == 2 and 0.01 < free.ambiguity <= 0.5
    for solution in free.solutions:
        led = bundle_pose.solve(FLAT, detections, CAMERA, solution.rotation)
        assert rotations.angle_between(led.rotation, solution.rotation) < DEGREE


def test_tracker_remembers_and_forgets():
    detections = small_and_ambiguous()
    tracker = bundle_pose.BundleTracker([FLAT, POST])
    first, = tracker.update(detections, CAMERA)
    other = first.solutions[1].rotation
    tracker._last[0] = other, 0
    assert rotations.angle_between(tracker.update(detections, CAMERA)[0].rotation, other) < DEGREE
    for _ in range(thresholds.BUNDLE_MEMORY + 1):
        assert tracker.update([], CAMERA) == []
    assert tracker._last == {}


def test_two_bundles_in_one_picture():
    far = np.array([-0.12, 0.05, 0.7])
    markers = [placed(FLAT, n) for n in (8, 9)] + [placed(POST, 1, position=far)]
    found = bundle_pose.BundleTracker([FLAT, POST]).update(seen(markers), CAMERA)
    assert [one.bundle.master for one in found] == [8, 1]
    check(found[0])
    assert off(found[1], position=far)[1] < 0.005
