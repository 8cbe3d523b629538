"""The picture of a map that the demo saves."""
import numpy as np

from course_grader.demo import course_navigation
from navigation_core.maps.grid_map import GridMap
from navigation_core.poses import Pose


def test_the_picture_shows_what_was_seen_with_the_first_row_below():
    cells = np.full((5, 6), -1, np.int8)
    cells[1, 2], cells[2, 3] = 0, 100
    picture = course_navigation._picture(GridMap(cells, 0.05, Pose()))
    size = course_navigation.PIXELS
    assert picture.shape == (2 * size, 2 * size, 3)
    assert picture[::size, ::size, 0].tolist() == [[205, 0], [254, 205]]
