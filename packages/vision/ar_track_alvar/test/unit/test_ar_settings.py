"""ar_track_alvar.settings and start: wrong parameters and arguments end with what is allowed."""
import sys

import pytest
import rospy

from ar_track_alvar import settings, start
from rospy_support.parameters import ParameterError

NUMBER = 'it must be a number from'


@pytest.fixture
def given(monkeypatch):
    """Return the parameters {name: value} that are set, as a dict to change."""
    values = {'~output_frame': '/camera'}
    monkeypatch.setattr(rospy, 'get_param', lambda name, default=None: values.get(name, default))
    monkeypatch.setattr(rospy, 'has_param', values.__contains__)
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name)
    return values


@pytest.mark.parametrize('name, value, said', [
    ('output_frame', '', 'output_frame must be set: '),
    ('marker_size', 0, f'marker_size is 0; {NUMBER} 0.1 to 1000 cm'),
    ('marker_size', -4.4, f'marker_size is -4.4; {NUMBER}'), ('gamma', 0.5, 'gamma is 0.5: it must be from 1, if'),
    ('marker_resolution', 6, 'marker_resolution: marker resolution 6: an odd number from 5'),
    ('marker_resolution', 33, 'marker_resolution is 33; it must be a whole number from 5 to'),
    ('max_frequency', 'fast', f"max_frequency is 'fast'; {NUMBER} 1 to 30 Hz"),
    ('image_transport', 'theora', "is 'theora'; it must be one of raw, compressed")])
def test_wrong_parameters_are_refused_with_what_is_allowed(given, name, value, said):
    given[f'~{name}'] = value
    with pytest.raises(ParameterError) as refused:
        settings.read()
    assert said in str(refused.value)


def test_a_rate_beyond_the_limits_is_clamped_and_the_frame_has_no_slash(given):
    given['~max_frequency'] = 60.0
    read = settings.read()
    assert (read.max_frequency, read.output_frame) == (30.0, 'camera')


def test_wrong_arguments_end_with_the_usage(monkeypatch):
    monkeypatch.setattr(sys, 'argv', ['individualMarkersNoKinect', '4.4', '0.08', '0.2'])
    with pytest.raises(SystemExit) as ended:
        start.init_node('individualMarkersNoKinect', settings.PARAMETERS)
    assert '3 arguments are given; at least 6 are needed\nUsage: individualMarkersN' in str(ended.value)
