"""plain_support.validation: impossible values are refused with a helpful error."""
import math

import pytest

from plain_support.validation import ABSURD, InvalidInput, require_sane, shown

ABOVE = ABSURD + 1e-9  # a few of the last bits above


@pytest.mark.parametrize('value', [0, 0.0, -0.0, 1, -3.5, 5e-324, ABSURD, -ABSURD, int(ABSURD)])
def test_finite_values_up_to_the_limits_inclusive_pass(value):
    assert require_sane('spawn', x=value, y=0.0) is None


@pytest.mark.parametrize('value, shown, allowed', [
    (math.nan, 'nan', 'finite number'),
    (math.inf, 'inf', 'finite number'),
    (-math.inf, '-inf', 'finite number'),
    (ABOVE, '1e+06', '-1e+06 to 1e+06'),
    (-ABOVE, '-1e+06', '-1e+06 to 1e+06'),
    (2e6, '2e+06', '-1e+06 to 1e+06'),
    (-1e300, '-1e+300', '-1e+06 to 1e+06'),
])
def test_refusal_names_source_value_and_what_is_allowed(value, shown, allowed):
    with pytest.raises(InvalidInput) as refusal:
        require_sane('cmd_vel of turtle1', **{'linear.x': 0.0, 'angular.z': value})
    text = str(refusal.value)
    assert text.startswith(f'cmd_vel of turtle1: angular.z is {shown}; ')
    assert allowed in text


@pytest.mark.parametrize('value, text', [('a', "'a'"), ([1, 2], '[1, 2]'), (1e7, '10000000.0'), ({'r': 1}, "{'r': 1}"),
                                         (None, 'None')])
def test_small_values_are_shown_as_they_are(value, text):
    assert shown(value) == text


@pytest.mark.parametrize('value', ['a' * 9999, list(range(9999)), [{'name': 'wall', 'x': 1.0} for _ in range(99)],
                                   10 ** 400, {str(n): [n] * 99 for n in range(99)}])
def test_large_values_are_shown_in_part(value):
    text = shown(value)
    assert '...' in text and len(text) <= 200 and text[0] == repr(value)[0] and text[-1] == repr(value)[-1]
