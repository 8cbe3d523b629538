"""Drawn markers."""
import numpy as np
import pytest

from alvar_core import code, drawing


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
