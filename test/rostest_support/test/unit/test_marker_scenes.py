"""Drawn markers and rendered scenes."""
import numpy as np
import pytest

from alvar_core import code, drawing
from alvar_core.camera import default_camera
from rostest_support.marker_scenes import Scene, image_of


def test_marker_picture_is_the_pattern_in_a_black_rim():
    drawn = drawing.marker_image(5, 90)
    assert drawn.shape == (90, 90) and set(np.unique(drawn)) == {0, 255}
    cells = drawn[5::10, 5::10] > 127
    assert (cells[2:7, 2:7] == code.encode(5)).all()
    assert not cells[:2].any() and not cells[7:].any() and not cells[:, :2].any() and not cells[:, 7:].any()


def test_side_need_not_be_a_multiple_of_the_cells():
    assert drawing.marker_image(5, 100).shape == (100, 100)


def test_too_small_a_picture_is_refused():
    with pytest.raises(ValueError, match='9 cells'):
        drawing.marker_image(1, 8)


def test_scene_is_the_same_for_the_same_seed():
    camera = default_camera(320, 240)
    scene = Scene(320, 240)
    pictures = [image_of(np.random.default_rng(3), camera, [], scene) for _ in range(2)]
    assert (pictures[0] == pictures[1]).all()
