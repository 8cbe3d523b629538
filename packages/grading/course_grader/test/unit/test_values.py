"""course_grader.rules.values: numbers with units, and the errors for others."""
import math

import pytest

from course_grader.rules.values import QuantityError, quantity, span


@pytest.mark.parametrize('text, dimension, value', [
    ('40 s', 'time', 40.0), ('250 ms', 'time', 0.25), ('1.5min', 'time', 90.0), ('-2 cm', 'length', -0.02),
    ('90 deg', 'angle', math.pi / 2.0), ('1e-1 m/s', 'speed', 0.1), ('180 deg/s', 'turn speed', math.pi),
    ('10 Hz', 'rate', 10.0), ('5 %', 'share', 0.05), ('3 px', 'pixels', 3.0),
    (0, 'length', 0.0), ('.5 m', 'length', 0.5),
])
def test_units_become_si(text, dimension, value):
    assert quantity(text, dimension) == pytest.approx(value)


@pytest.mark.parametrize('text, dimension, said', [
    ('40', 'time', "'40' is not a number with one of the units s, ms, min"),
    (40, 'time', '40 is not a number with one of the units'),
    (True, 'time', 'True is not a number'), (False, 'time', 'False is not a number'), (None, 'time', 'None is not'),
    ('40 m', 'time', "the unit 'm' in '40 m' does not measure a time"),
    ('40 parsec', 'length', "the unit 'parsec'"), ('nan m', 'length', "'nan m' is not a number"),
    ('1 2 m', 'length', "'1 2 m' is not a number"),
])
def test_what_is_no_quantity_is_named(text, dimension, said):
    with pytest.raises(QuantityError) as error:
        quantity(text, dimension)
    assert str(error.value).startswith(said)


@pytest.mark.parametrize('text, dimension, limits', [
    ('9 to 11 Hz', 'rate', (9.0, 11.0)), ('-20 to 20 cm', 'length', (-0.2, 0.2)), ('2 m', 'length', (2.0, 2.0)),
    ('at least 0.1 m/s', 'speed', (0.1, math.inf)), ('at most 2 s', 'time', (-math.inf, 2.0)),
    ('0 to 90 deg', 'angle', (0.0, math.pi / 2.0)),
])
def test_spans(text, dimension, limits):
    assert span(text, dimension) == pytest.approx(limits)


@pytest.mark.parametrize('text, said', [
    ('11 to 9 Hz', "'11 to 9 Hz' starts above its end"), ('9 to 11 m', "the unit 'm'"), ('9 to 11', "'9 to 11' is not"),
    ('at least 3', "'3' is not"), ('about 3 Hz', "'about 3 Hz' is not"), ([9, 11], '[9, 11] is not'),
])
def test_what_is_no_span_is_named(text, said):
    with pytest.raises(QuantityError) as error:
        span(text, 'rate')
    assert str(error.value).startswith(said)
