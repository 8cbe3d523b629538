"""depthimage_to_laserscan.core.projection: angles, ranges, limits and refusals."""
import math

import numpy as np
import pytest

from depthimage_to_laserscan.core.projection import Camera, ScanError, Settings, scan

WIDTH, HEIGHT = 9, 7
CAMERA = Camera(4.0, 4.0, 3.0)  # 90 degrees between the outer columns
ALL = Settings(1, 0.0, 100.0)
TOLERANCE = 1e-6  # [m, rad]


def wall(distance=2.0):
    return np.full((HEIGHT, WIDTH), distance, np.float32)


def test_a_wall_across_the_axis_is_as_far_as_the_rays_are_long():
    found = scan(wall(), CAMERA, ALL)
    assert (found.first, found.last) == pytest.approx((-math.pi / 4, math.pi / 4), abs=TOLERANCE)
    assert len(found.ranges) == WIDTH
    assert found.ranges[-1] == pytest.approx(2.0 * math.sqrt(2.0), abs=TOLERANCE)
    # the two columns at the right edge share the first ray, and the nearer one counts: 2 m * hypot(3 / 4, 1)
    assert found.ranges[0] == pytest.approx(2.5, abs=TOLERANCE)
    assert found.ranges[4] == pytest.approx(2.0, abs=TOLERANCE)


def test_the_first_ray_is_that_of_the_right_edge():
    depths = wall()
    depths[:, -1] = 1.0
    assert scan(depths, CAMERA, ALL).ranges[0] == pytest.approx(math.sqrt(2.0), abs=TOLERANCE)


@pytest.mark.parametrize('height, expected', [(1, 2.0), (2, 2.0), (3, 2.0), (5, 0.5)])
def test_only_the_rows_in_the_middle_count(height, expected):
    depths = wall()
    depths[1] = 0.5  # two rows above the middle
    assert scan(depths, CAMERA, ALL._replace(height=height)).ranges[4] == pytest.approx(expected, abs=TOLERANCE)


@pytest.mark.parametrize('column, expected', [
    ((0.4, 2.0, 9.0), 2.0),  # one too near, one too far
    ((math.nan, math.nan, math.nan), math.nan),
    ((math.nan, math.inf, 0.1), math.inf),
    ((0.1, 0.1, 9.0), math.nan),
    ((0.0, math.nan, 3.0), 3.0),
])
def test_ranges_that_do_not_count(column, expected):
    depths = wall()
    depths[2:5, 4] = column
    assert scan(depths, CAMERA, Settings(3, 0.5, 5.0)).ranges[4] == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize('height, camera', [(8, CAMERA), (3, CAMERA._replace(cy=0.0)), (1, CAMERA._replace(fx=0.0))])
def test_rows_outside_of_the_image_are_refused(height, camera):
    with pytest.raises(ScanError, match=f'scan_height is {height} px'):
        scan(wall(), camera, Settings(height, 0.0, 9.0))
