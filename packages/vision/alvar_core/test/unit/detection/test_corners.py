"""Large markers are as exact as their edges are sharp; what covers an edge does not move them."""
import numpy as np
import pytest

from alvar_core import native, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import homography
from alvar_core.detection.detector import Detector
from alvar_core.detection.light import LINEAR
from alvar_core.detection.pyramid import Pyramid
from rostest_support.marker_scenes import Placed, Scene, image_of
from unit_support.cases import nightly

pytestmark = pytest.mark.slow

SIZE = 0.1
CORNER_TOLERANCE = 0.1  # px, median of several markers' worst corners
POSITION_TOLERANCE = 0.0005  # of the distance
ROTATION_TOLERANCE = np.radians(0.2)


def near(rng, camera, side, tilt):
    """A marker `side` px wide, the way it is turned and its place left to chance."""
    distance = camera.fx * SIZE / side
    room = max(0.0, (240 - 0.75 * side) / camera.fx * distance)
    return Placed(int(rng.integers(256)), SIZE, rotations.facing(np.radians(tilt), *rng.uniform(0, 6.3, 2)),
                         np.array([*rng.uniform(-room, room, 2), distance]))


@pytest.mark.parametrize('side, distorted', [
    (90, True), (170, False), (230, True),
    *nightly((90, False), (130, False), (130, True), (170, True), (230, False), (340, False), (340, True))])
def test_large_markers_are_exact(side, distorted):
    camera, detector, errors = default_camera(distorted=distorted), Detector(SIZE), []
    for seed, (tilt, blur) in enumerate(((3, 0.4), (20, 0.6), (40, 1.0))):
        rng = np.random.default_rng(10 * side + seed)
        placed = near(rng, camera, side, tilt)
        found, = detector.detect(image_of(rng, camera, [placed], Scene(blur=blur)), camera)
        assert found.id == placed.id
        errors.append((np.abs(found.corners - placed.corners).max(),
                       np.linalg.norm(found.position - placed.position) / np.linalg.norm(placed.position),
                       rotations.angle_between(found.rotation, placed.rotation)))
    corner, position, rotation = np.median(errors, 0)
    assert corner < CORNER_TOLERANCE
    assert position < POSITION_TOLERANCE and rotation < ROTATION_TOLERANCE


def seen_near(covered):
    """(Pyramid, camera, right corners) of a marker 180 px wide; `covered`: share of its upper side."""
    rng, camera = np.random.default_rng(3), default_camera()
    placed = Placed(9, SIZE, rotations.facing(0.4, 1.0, 0.1), np.array([0, 0, camera.fx * SIZE / 180]))
    picture = image_of(rng, camera, [placed], Scene())
    left, right = placed.corners[:2]
    for share in np.linspace(0, covered, 200) if covered else ():
        x, y = (left + share * (right - left)).astype(int)
        picture[y - 12:y + 12, x - 1:x + 2] = 120
    return Pyramid(picture), camera, placed.corners


def refined(pyramid, camera, h, blur):
    return native.steps.refine_edges(grey=pyramid.full, lens=camera.lens, h=h, half=4.5, sigma=np.array([blur]),
                                     light=LINEAR.steps, limit=native.limit)


@pytest.mark.parametrize('covered, seen', [(0.0, True), (0.25, True), (0.8, False)])
def test_covered_part_of_a_side_does_not_count_and_a_covered_side_is_told(covered, seen):
    pyramid, camera, right = seen_near(covered)
    start = right[None] + np.random.default_rng(4).uniform(-1.5, 1.5, (1, 4, 2))
    h = homography.from_square(start, 4.5)
    corners, covariance, good = refined(pyramid, camera, h, 1.0)
    assert good.tolist() == [seen]
    assert (np.linalg.eigvalsh(covariance[0]) > 0).all()
    if seen:
        assert np.abs(corners - right).max() < 0.15


def test_covariance_is_as_large_as_the_errors_are():
    camera, chi2 = default_camera(), []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        placed = near(rng, camera, 80, 20)
        picture = image_of(rng, camera, [placed], Scene(noise=4.0, blur=0.8))
        h = homography.from_square(placed.corners[None], 4.5)
        corners, covariance, _ = refined(Pyramid(picture), camera, h, 0.9)
        error = (corners - placed.corners).reshape(8)
        chi2.append(error @ np.linalg.solve(covariance[0], error) / 8)
    assert 0.3 < np.median(chi2) < 3.0
