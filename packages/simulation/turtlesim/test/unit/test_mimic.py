"""mimic's conversion of a pose to a command."""
import math

import pytest
from turtlesim.msg import Pose

from plain_support import InvalidInput
from turtlesim.mimic import twist_from_pose


def test_only_the_speeds_are_taken():
    twist = twist_from_pose(Pose(x=1.0, y=2.0, theta=3.0, linear_velocity=0.5, angular_velocity=-0.25))
    assert (twist.linear.x, twist.angular.z) == (0.5, -0.25)
    assert (twist.linear.y, twist.linear.z, twist.angular.x, twist.angular.y) == (0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize('field', ['linear_velocity', 'angular_velocity'])
@pytest.mark.parametrize('value,text', [(math.nan, 'nan'), (math.inf, 'inf'), (-math.inf, '-inf'), (1e30, r'1e\+30')])
def test_speeds_that_are_none_are_refused_by_name_and_value(field, value, text):
    with pytest.raises(InvalidInput, match=f'{field} is {text}'):
        twist_from_pose(Pose(**{field: value}))


def test_a_position_that_is_none_does_not_matter():
    assert twist_from_pose(Pose(x=math.nan, linear_velocity=1.0)).linear.x == 1.0
