"""turtle_robotont.markers.sightings: axes, and poses that no marker can have."""
import math

import pytest

from turtle_robotont.driving.shapes import InvalidInput
from turtle_robotont.markers.sightings import FARTHEST, sighting


@pytest.mark.parametrize('frame, axes, ahead, left, up', [
    ('camera_link', 'auto', 1.0, 2.0, 3.0),
    ('head_camera', 'auto', 1.0, 2.0, 3.0),
    ('optical_bench', 'auto', 1.0, 2.0, 3.0),
    ('camera_color_optical_frame', 'auto', 3.0, -1.0, -2.0),  # z ahead, x right, y down
    ('camera_optical', 'auto', 3.0, -1.0, -2.0),
    ('head_camera', 'optical', 3.0, -1.0, -2.0),
    ('camera_color_optical_frame', 'body', 1.0, 2.0, 3.0),
])
def test_axes_follow_the_frame_unless_they_are_given(frame, axes, ahead, left, up):
    assert sighting(7, (1.0, 2.0, 3.0), frame, axes) == (7, ahead, left, up)


def test_distance_and_bearing_are_over_the_ground():
    seen = sighting(1, (3.0, 4.0, 12.0), 'camera_link')
    assert seen.distance == pytest.approx(5.0)
    assert seen.bearing == pytest.approx(math.atan2(4.0, 3.0))


@pytest.mark.parametrize('position, text', [
    ((math.nan, 0.0, 1.0), 'marker 7 at x nan, y 0, z 1 m'),
    ((0.0, -math.inf, 1.0), 'y -inf'),
    ((1e253, 0.0, 1.0), 'x 1e+253'),  # seen from the original tracker; its square is infinite
    ((0.0, 0.0, FARTHEST + 1.0), 'z 101 m'),
])
def test_pose_that_no_marker_can_have_is_refused(position, text):
    with pytest.raises(InvalidInput, match='marker 7') as refusal:
        sighting(7, position, 'camera_link')
    assert text in str(refusal.value) and 'must be within 100 m' in str(refusal.value)
