"""Poses of markers from image and points: planes with noise, holes and outliers, and points that contradict."""
import dataclasses

import cv2
import numpy as np
import pytest

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import depth, pose
from alvar_core.detection.detection import Detection
from alvar_core.detection.detector import Detector
from rostest_support.marker_scenes import Placed, Scene, image_of
from unit_support.photo import with_gamma

pytestmark = pytest.mark.slow

CAMERA, SHAPE, SIZE = default_camera(), (480, 640), 0.1
RAYS = np.concatenate([CAMERA.to_rays(np.stack(np.meshgrid(np.arange(640), np.arange(480)), -1).astype(float)),
                       np.ones((*SHAPE, 1))], -1)
POSE = rotations.facing(0.5, 1.0, 0.3), np.array([0.05, -0.04, 0.9])


class Points:
    """The points of the plane of a marker, as a depth camera with noise [m at 1 m] would see them."""

    def __init__(self, rotation, position, noise=0.0, scale=1.0, seed=1):
        z = (rotation[:, 2] @ position) / (RAYS @ rotation[:, 2])
        if noise:  # neighbouring pixels share errors, as depth cameras compare windows
            errors = cv2.GaussianBlur(np.random.default_rng(seed).normal(0, 1, SHAPE), (0, 0), 1.1)
            z = z * scale + errors / errors.std() * noise * z * z
        else:
            z = z * scale
        self.array = (RAYS * z[..., None]).astype(np.float32)

    def window(self, top, bottom, left, right):
        return self.array[top:bottom, left:right].astype(float)


def true_q(rotation, position):
    return rotation[:, 2] / (rotation[:, 2] @ position)


def detection(rotation, position, corner_error=0.0, seed=2):
    """Return the Detection of a marker whose corners have errors [px]."""
    corners = drawing.project(CAMERA, rotation, position, drawing.object_corners(SIZE))
    corners = corners + np.random.default_rng(seed).normal(0, 1, (4, 2)) * corner_error
    information = np.eye(8) / max(corner_error, 0.05) ** 2
    solutions = pose.solve(corners[None], [SIZE], CAMERA, information[None])[0]
    share, ambiguous = pose.ambiguity(solutions)
    best = solutions[0]
    return Detection(7, corners, best.rotation, best.position, 0.9, share, ambiguous, best.error, solutions, None,
                     information)


def angle(a, b):
    return np.degrees(rotations.angle_between(a, b))


@pytest.mark.parametrize('rotation, position', [POSE, (rotations.facing(0.0, 0.0, 0.0), np.array([0, 0, 0.5])),
                                                (rotations.facing(1.0, 2.0, 1.0), np.array([0.3, 0.2, 1.5]))])
def test_exact_points_give_the_exact_plane(rotation, position):
    found = depth.plane_on(Points(rotation, position), detection(rotation, position).corners, SHAPE)
    assert np.allclose(found.q, true_q(rotation, position), rtol=1e-4, atol=1e-4)


def behind(points, share):
    """Move this share of the columns of the marker 1 m back, like the background beside an object."""
    columns = np.arange(SHAPE[1]) % 10 < 10 * share
    points.array[:, columns] *= 2.0


def test_points_of_something_behind_do_not_count():
    points = Points(*POSE)
    behind(points, 0.2)
    found = depth.plane_on(points, detection(*POSE).corners, SHAPE)
    assert np.allclose(found.q, true_q(*POSE), rtol=1e-3, atol=1e-3)


def holes(value):
    def make(points):
        points.array[:] = value
    return make


def scattered(points):
    points.array *= np.random.default_rng(5).uniform(0.5, 2.0, (*SHAPE, 1)).astype(np.float32)


@pytest.mark.parametrize('spoil, expected', [(holes(np.nan), depth.NO_DEPTH), (holes(0.0), depth.NO_DEPTH),
                                             (holes(np.inf), depth.NO_DEPTH), (holes(-1.0), depth.NO_DEPTH),
                                             (scattered, depth.NO_PLANE)])
def test_without_usable_points_the_image_counts_and_the_reason_is_given(spoil, expected):
    points, one = Points(*POSE), detection(*POSE)
    spoil(points)
    found = depth.plane_on(points, one.corners, SHAPE)
    assert found == expected
    measured = depth.measured(one, SIZE, CAMERA, found)
    assert measured.source == expected and measured.detection is one


def test_points_that_agree_remove_the_doubt():
    one = detection(*POSE)
    one.doubtful = True
    found = depth.measured(one, SIZE, CAMERA, depth.plane_on(Points(*POSE), one.corners, SHAPE))
    assert found.source == depth.BOTH and not found.detection.doubtful


def test_points_correct_the_distance_if_it_is_unknown_whether_greys_are_light():
    """A marker of 26 px says nothing about that: a camera with a gamma shows it too far away."""
    place = rotations.facing(0.4, 1.0, 0.3), np.array([0.05, -0.04, 2.0])
    picture = image_of(np.random.default_rng(1), CAMERA, [Placed(7, SIZE, *place)], Scene())
    one, = Detector(SIZE).detect(with_gamma(picture, 2.2), CAMERA)
    both = depth.measured(one, SIZE, CAMERA, depth.plane_on(Points(*place), one.corners, SHAPE)).detection
    distance = np.linalg.norm(place[1])
    assert np.linalg.norm(one.position - place[1]) > 0.0025 * distance
    assert np.linalg.norm(both.position - place[1]) < 0.001 * distance


def test_half_of_the_points_is_enough():
    points = Points(*POSE)
    points.array[:, ::2] = np.nan
    assert isinstance(depth.plane_on(points, detection(*POSE).corners, SHAPE), depth.Plane)


@pytest.mark.parametrize('corners', [[[-50, -50], [-10, -50], [-10, -10], [-50, -10]], [[1, 1], [3, 1], [3, 3], [1, 3]],
                                     [[600, 400], [900, 400], [900, 900], [600, 900]]])
def test_outlines_beyond_the_image_or_tiny_are_no_error(corners):
    depth.plane_on(Points(*POSE), np.array(corners, float), SHAPE)


def test_image_and_points_together_are_better_than_either():
    errors = {'image': [], 'points': [], 'both': []}
    for seed in range(30):
        rng = np.random.default_rng(seed)
        rotation = rotations.facing(rng.uniform(0.0, 0.7), rng.uniform(0, 6), rng.uniform(0, 6))
        position = np.array([0.1, 0.05, 1.5])
        one = detection(rotation, position, 0.3, seed)
        plane = depth.plane_on(Points(rotation, position, 0.002, 1 + 0.005 * rng.normal(), seed), one.corners, SHAPE)
        both = depth.measured(one, SIZE, CAMERA, plane)
        points = depth.pose_on(plane, CAMERA.to_rays(one.corners))
        for name, found in (('image', (one.rotation, one.position)), ('points', points[:2]),
                            ('both', (both.detection.rotation, both.detection.position))):
            errors[name].append((angle(found[0], rotation), 100 * np.linalg.norm(found[1] - position) / 1.5))
    image, points, both = (np.sqrt(np.mean(np.square(errors[name]), 0)) for name in ('image', 'points', 'both'))
    assert (both <= 1.02 * np.minimum(image, points)).all() and both[0] < 0.5 * image[0], (image, points, both)


def test_points_decide_between_two_tilts_that_look_alike():
    rotation, position = rotations.facing(0.2, 1.0, 0.0), np.array([0, 0, 2.0])
    for seed in range(10):
        one = detection(rotation, position, 0.3, seed)
        assert one.ambiguous
        found = depth.measured(one, SIZE, CAMERA, depth.plane_on(Points(rotation, position), one.corners, SHAPE))
        assert angle(found.detection.rotation, rotation) < 5.0 and not found.detection.ambiguous


def test_a_wrong_size_is_noticed_and_named_and_the_points_count():
    one = detection(*POSE)
    twice = Points(*POSE, scale=2.0)  # as if the marker were twice as large and twice as far away
    found = depth.measured(one, SIZE, CAMERA, depth.plane_on(twice, one.corners, SHAPE))
    assert found.source == depth.CLOUD and found.size == pytest.approx(2 * SIZE, rel=1e-3)
    assert np.allclose(found.detection.position, 2 * POSE[1], rtol=1e-3)
    assert angle(found.detection.rotation, POSE[0]) < 0.1 and found.detection.confidence < 0.5


def test_the_pose_of_a_bundle_uses_the_planes_of_all_its_markers():
    rotation, position = POSE
    places = [drawing.object_corners(SIZE) + [dx, 0, 0] for dx in (-0.1, 0.1)]
    plane = depth.Plane(true_q(rotation, position), np.eye(3) * 1e6)
    observations = []
    for place in places:
        corners = drawing.project(CAMERA, rotation, position, place)
        observations.append(depth.Observation(place, corners, np.eye(8) / 0.04, plane))
    start = rotations.facing(0.6, 1.2, 0.35), position + [0.02, -0.02, 0.05]
    found = depth.fitted(observations, *start, CAMERA)
    assert angle(found.rotation, rotation) < 0.01 and np.allclose(found.position, position, atol=1e-5)


def test_derivatives_of_the_plane_equal_differences():
    rotation, position = POSE
    points, plane = drawing.object_corners(SIZE), depth.Plane(np.zeros(3), np.eye(3))
    value, jacobian = depth._plane_equations(points @ rotation.T, position, plane)
    for k in range(6):
        step = np.zeros(6)
        step[k] = 1e-6
        turned = pose.turned_by(step[None, :3], rotation[None])[0]
        after = depth._plane_equations(points @ turned.T, position + step[3:], plane)[0]
        assert np.allclose((after - value) / 1e-6, jacobian[:, k], atol=1e-4)


def bent_points(bend, noise=0.002):
    """Return the Points of a marker whose paper turns by ``bend`` [rad] over its width, and its true pose."""
    rotation, position = rotations.facing(0.4, 1.0, 0.2), np.array([0.02, 0.0, 0.8])
    flat = Points(rotation, position, noise)
    x = (flat.array - position) @ rotation[:, 0]
    sag = bend / (2 * SIZE) * np.square(x)  # a parabola that turns by bend over the width
    flat.array = (flat.array * (1 + sag / flat.array[..., 2])[..., None]).astype(np.float32)
    return flat, rotation, position


@pytest.mark.parametrize('bend, source', [(0.0, depth.BOTH), (0.5, depth.BENT), (-0.5, depth.BENT)])
def test_points_decide_whether_paper_is_bent(bend, source):
    """An image that says bent, and is doubtful: points on one plane disprove it, those of a bent paper do not."""
    points, rotation, position = bent_points(bend)
    seen = dataclasses.replace(detection(rotation, position, 0.1), bend=0.5, doubtful=True)
    found = depth.measured(seen, SIZE, CAMERA, depth.plane_on(points, seen.corners, SHAPE))
    assert found.source == source
    assert (found.detection.bend, found.detection.doubtful) == ((0, False) if source == depth.BOTH else (0.5, True))
    if source == depth.BOTH:
        assert angle(found.detection.rotation, rotation) < 1.0
    else:
        assert found.detection is seen


def test_bend_that_points_would_not_show_stays():
    points, rotation, position = bent_points(0.0, 0.02)
    seen = dataclasses.replace(detection(rotation, position, 0.1), bend=0.1)
    plane = depth.plane_on(points, seen.corners, SHAPE, 0.02)
    assert depth.measured(seen, SIZE, CAMERA, plane).source == depth.BENT


def test_corners_that_fit_no_square_count_less():
    """Corners off by ten times their claimed error: the points decide the tilt."""
    rotation, position = rotations.facing(0.3, 1.0, 0.2), np.array([0.0, 0.0, 1.0])
    turns = []
    for seed in range(5):
        seen = detection(rotation, position, 0.5, seed)
        sure = dataclasses.replace(seen, information=np.eye(8) / 0.05 ** 2)
        plane = depth.plane_on(Points(rotation, position, 0.002, seed=seed), seen.corners, SHAPE)
        turns.append(angle(depth.measured(sure, SIZE, CAMERA, plane).detection.rotation, rotation))
    assert np.median(turns) < 1.0
