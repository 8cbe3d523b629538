"""course_grader.rules.fits: shapes are recognised wherever they lie, and others are not taken for them."""
import math

import numpy as np
import pytest

from course_grader.rules import fits

pytestmark = pytest.mark.slow

TOLERANCE = 0.1  # [m]


def polygon(sides, length, start=(3.0, 3.0), heading=0.3, turn=None, legs=None):
    """The corners of a regular polygon, or of one whose turns are ``turn`` [rad]."""
    points = [start]
    for leg in range(sides if legs is None else legs):
        angle = heading + leg * (2.0 * math.pi / sides if turn is None else turn)
        points.append((points[-1][0] + length * math.cos(angle), points[-1][1] + length * math.sin(angle)))
    return points


def arc(radius, angle=2.0 * math.pi, centre=(5.0, 5.0), steps=400):
    angles = np.linspace(0.0, angle, steps)
    return [(centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles]


RIGHT = [
    ('square', polygon(4, 2.0), 2.0), ('square', polygon(4, 0.5, heading=2.0), 0.5),
    ('square', [(5.5, 5.5), *polygon(4, 3.0)], 3.0), ('square', [(10.0, 9.0), (1.0, 9.5), *polygon(4, 3.0)], 3.0),
    ('square', polygon(4, 2.0, turn=-math.pi / 2.0), 2.0), ('square', polygon(4, 2.0, legs=12), 2.0),
    ('triangle', polygon(3, 3.0), 3.0), ('triangle', [(9.0, 9.0), *polygon(3, 3.0)], 3.0),
    ('circle', arc(2.5), 5.0), ('circle', arc(0.3), 0.6), ('circle', [(5.0, 5.0), *arc(2.0, angle=14.0)], 4.0),
]
def eight(radius, heading=0.4, centre=(5.0, 5.0), laps=1):
    """Two circles that touch, driven one after the other, to the left and to the right."""
    points = [centre]
    for side in (1.0, -1.0) * laps:
        middle = (centre[0] - side * radius * math.sin(heading), centre[1] + side * radius * math.cos(heading))
        angles = heading - side * math.pi / 2.0 + side * np.linspace(0.0, 2.0 * math.pi, 200)
        points += [(middle[0] + radius * math.cos(a), middle[1] + radius * math.sin(a)) for a in angles]
    return points


LINE = [(2.0, 2.0), (6.0, 2.0), (6.0, 5.0)]
RIGHT += [('eight', eight(1.5), 3.0), ('eight', eight(0.6, heading=2.5), 1.2), ('eight', eight(1.5, laps=3), 3.0),
          ('eight', [(9.0, 1.0), *eight(1.5)], 3.0)]
WRONG = [
    ('eight', arc(1.5)), ('eight', eight(1.5)[:201]), ('eight', eight(1.5)[:300]), ('eight', polygon(4, 3.0)),
    ('eight', [*arc(1.0), *arc(1.0, centre=(8.0, 5.0))]),  # they do not touch
    ('eight', [*arc(1.5), *arc(0.75, centre=(7.25, 5.0))]), ('square', eight(1.5)),
    ('square', polygon(4, 2.0, legs=3)), ('square', polygon(4, 2.0, turn=math.radians(97.0))), ('square', arc(2.0)),
    ('square', [(1, 1), (4, 1), (4, 3), (1, 3), (1, 1)]), ('square', polygon(3, 3.0)), ('square', [(1, 1), (5, 5)]),
    ('square', polygon(5, 2.0)), ('triangle', arc(1.5)), ('triangle', polygon(4, 2.0)),
    ('triangle', polygon(3, 2.0, legs=2)),
    ('triangle', [(1, 1), (9, 1), (9, 1.5), (1, 1)]), ('circle', polygon(4, 3.0)), ('circle', arc(2.0, math.pi)),
    ('circle', [(1, 1), (2, 2)]), ('circle', [(3, 3)]), ('square', []), ('triangle', [(2, 2), (2, 2)]),
    ('square', arc(0.05)),
]


@pytest.mark.parametrize('shape, way, size', RIGHT)
def test_right_shapes_fit(shape, way, size):
    found = fits.fit(way, shape, TOLERANCE)
    assert found.quality > 0.99
    assert found.size == pytest.approx(size, abs=TOLERANCE)


@pytest.mark.parametrize('way, good', [
    (LINE, True), (LINE[::-1], True), ([(9.0, 9.0), *LINE], True), ([(x, y + 0.08) for x, y in LINE], True),
    (LINE[:2], False), ([(x + 1.0, y) for x, y in LINE], False), ([LINE[0], LINE[2]], False), ([(2.0, 2.0)], False)])
def test_a_line_is_asked_for_where_it_lies(way, good):
    found = fits.fit(way, fits.LINE, TOLERANCE, LINE)
    assert (found.quality > 0.99) == good and (found.quality < 0.85) != good
    assert not good or found.size == pytest.approx(7.0)


@pytest.mark.parametrize('shape, way', WRONG)
def test_wrong_shapes_do_not(shape, way):
    assert fits.fit(way, shape, TOLERANCE).quality < 0.85


def test_quality_falls_with_the_error():
    qualities = [fits.fit(polygon(4, 2.0, turn=math.radians(90.0 + error)), 'square', TOLERANCE).quality
                 for error in (0.0, 5.0, 10.0, 20.0)]
    assert qualities == sorted(qualities, reverse=True) and qualities[0] > qualities[-1] + 0.4


def test_length_and_corners_of_a_way():
    way = [(0.0, 0.0), (1.0, 0.01), (2.0, 0.0), (2.0, 1.0)]
    assert fits.path_length(way) == pytest.approx(2.0 * math.hypot(1.0, 0.01) + 1.0)
    assert fits.corners(way) == [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0)]
    assert fits.corners([(1.0, 2.0)]) == [(1.0, 2.0)]
