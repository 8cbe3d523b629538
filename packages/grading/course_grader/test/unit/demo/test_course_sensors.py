"""course_grader.demo.course_sensors: the curve of a plot is where its values say, and nothing of it beyond the axes."""
import numpy as np
import pytest

from course_grader.demo import course_sensors
from course_grader.demo.course_sensors import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, WIDTH, over_time


def drawn(values, colour=course_sensors.LINE, tolerance=3):
    """Return the rows and columns that have a colour in a plot of 10 s and 0 to 1 m, with the goal at 0.5 m."""
    picture = over_time('title', np.linspace(0.0, 10.0, len(values)), values, 0.5, 10.0, (0.0, 1.0))
    assert picture.shape == (HEIGHT, WIDTH, 3)
    return np.nonzero((np.abs(picture.astype(int) - colour) <= tolerance).all(-1))


@pytest.mark.parametrize('metres', [0.0, 0.25, 1.0])
def test_curve_is_at_its_distance_from_the_first_to_the_last_second(metres):
    rows, columns = drawn([metres] * 50)
    wanted = HEIGHT - BOTTOM - metres * (HEIGHT - TOP - BOTTOM)
    assert abs(rows - wanted).max() <= 2
    assert abs(columns.min() - LEFT) <= 2 and abs(columns.max() - (WIDTH - RIGHT)) <= 2


def test_line_of_the_goal():
    rows, columns = drawn([0.9] * 50, course_sensors.GOAL_LINE, 60)  # a thin line is blended with the paper
    assert HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) // 2 in rows and np.ptp(columns) > 0.9 * (WIDTH - LEFT - RIGHT)


def test_curve_ends_at_the_axes():
    rows, _ = drawn([3.0, 3.0, 0.2, -2.0])
    assert rows.size and TOP - 2 <= rows.min() and rows.max() <= HEIGHT - BOTTOM + 2
