"""ar_track_alvar.core.debug_image: outline, id and axes are where the marker is."""
from dataclasses import replace

import cv2
import numpy as np
import pytest

from alvar_core import drawing, rotations
from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from ar_track_alvar.core import debug_image
from rostest_support.marker_scenes import Placed, Scene, image_of

SIZE = 0.1  # [m]


@pytest.fixture(scope='module')
def seen():
    """(camera, grey picture, its one Detection)."""
    camera = default_camera()
    placed = [Placed(7, SIZE, rotations.facing(0.5, 0.7, 0.0), np.array([0.02, 0.01, 0.5]))]
    picture = image_of(np.random.default_rng(1), camera, placed, Scene())
    return camera, picture, Detector(SIZE).detect(picture, camera)[0]


def drawn(seen, detection, published=True):
    camera, picture, _ = seen
    bgr = cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    debug_image.draw(bgr, camera, [detection], [detection] if published else [], lambda _: SIZE)
    return bgr


def has(picture, colour, at):
    """Whether a colour is in the picture within 2 px of a place."""
    x, y = np.round(at).astype(int)
    patch = picture[y - 2:y + 3, x - 2:x + 3].astype(int)
    return (np.abs(patch - colour).max(2) < 40).any()


def test_outline_and_axes(seen):
    camera, _, detection = seen
    picture = drawn(seen, detection)
    for start, end in zip(detection.corners, np.roll(detection.corners, -1, 0)):
        assert has(picture, debug_image.SURE, (start + end) / 2)
    for axis, colour in zip(np.eye(3), debug_image.AXES):
        middle = drawing.project(camera, detection.rotation, detection.position, axis[None] * SIZE / 3)[0]
        assert has(picture, colour, middle)


def test_colours_tell_what_is_sure_ambiguous_and_left_out(seen):
    detection = seen[2]
    middle = detection.corners[:2].mean(0)
    assert has(drawn(seen, replace(detection, ambiguous=True)), debug_image.AMBIGUOUS, middle)
    left_out = drawn(seen, detection, published=False)
    assert has(left_out, debug_image.LEFT_OUT, middle) and not (left_out == debug_image.AXES[0]).all(2).any()


def test_the_id_stands_below_also_at_the_rim_of_the_picture(seen):
    detection = seen[2]
    shape = seen[1].shape
    for move in (np.zeros(2), [-1000, 0], [0, 1000], [1000, -1000], [1e9, -1e9]):
        moved = replace(detection, corners=detection.corners + move)
        assert drawn(seen, moved).shape == (*shape, 3)
    below = slice(int(detection.corners[:, 1].max()) + 4, None)
    light = [(part + 255) // 2 for part in debug_image.SURE]
    assert (drawn(seen, detection)[below] == light).all(2).any()


@pytest.mark.parametrize('ground', [0, 70, 128, 255])
def test_the_id_is_readable_on_any_ground(seen, ground):
    """Light letters, at least 12 px high, with black around each of their pixels."""
    camera, picture, detection = seen
    bgr = np.full((*picture.shape, 3), ground, np.uint8)
    debug_image.draw(bgr, camera, [detection], [detection], lambda _: SIZE)
    below = bgr[int(detection.corners[:, 1].max()) + 4:].astype(int)
    light, black = (below > 140).all(2) & (below[..., 1] < 250), (below < 40).all(2)
    rows = np.flatnonzero(light.any(1))
    assert rows[-1] - rows[0] >= 12
    around = cv2.dilate(black.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
    assert around[light].all() and black.sum() > light.sum() / 2
