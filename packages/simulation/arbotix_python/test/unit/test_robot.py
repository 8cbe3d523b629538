"""The robot of arbotix_driver without ROS: a base that stops by itself, joints with a range and a speed."""
import math

import pytest

from arbotix_python.core.robot import Base, Joint, split

TOLERANCE = 1e-9  # [m, rad]


def test_base_drives_as_told_and_stops_after_its_timeout():
    base = Base(timeout=0.5)
    base.command(0.2, 0.0)
    base.step(0.4)
    assert base.pose.x == pytest.approx(0.08, abs=TOLERANCE) and base.twist.linear_x == 0.2
    base.step(0.4)  # 0.1 s of it until the timeout
    assert base.pose.x == pytest.approx(0.1, abs=TOLERANCE) and base.twist.linear_x == 0.0
    base.step(1.0)
    assert base.pose.x == pytest.approx(0.1, abs=TOLERANCE)


def test_base_drives_arcs_exactly():
    base = Base(timeout=10.0)
    base.command(math.pi, math.pi)  # a circle of radius 1 m; half of it takes 1 s
    base.step(1.0)
    assert (base.pose.x, base.pose.y) == pytest.approx((0.0, 2.0), abs=TOLERANCE)
    assert abs(base.pose.yaw) == pytest.approx(math.pi, abs=TOLERANCE)  # both are the same heading


def test_joint_turns_at_its_speed_within_its_range():
    joint = Joint({'min_angle': -90, 'max_angle': 90, 'max_speed': 45})
    assert joint.command(math.radians(60.0))
    joint.step(1.0)
    assert (joint.angle, joint.speed) == pytest.approx((math.radians(45.0),) * 2, abs=TOLERANCE)
    joint.step(1.0)
    assert joint.angle == pytest.approx(math.radians(60.0), abs=TOLERANCE)
    assert not joint.command(3.0) and joint.goal == pytest.approx(math.pi / 2, abs=TOLERANCE)


@pytest.mark.parametrize('settings, said', [
    ({'min_angle': 10, 'max_angle': 5}, 'must not be above'), ({'max_speed': 0}, 'must be positive'),
    ({'max_angle': 'wide'}, "'wide', must be a number"), ({'max_angle': float('nan')}, 'must be a number')])
def test_joint_refuses_wrong_settings(settings, said):
    with pytest.raises(ValueError, match=said):
        Joint(settings)


def test_controllers_are_bases_and_others():
    base = {'type': 'diff_controller', 'base_width': 0.26}
    assert split({'b': base, 'arm': {'type': 'follow_controller'}, 'x': {}}) == ({'b': base}, ['arm', 'x'])
    with pytest.raises(ValueError, match='the controller b is 3'):
        split({'b': 3})
