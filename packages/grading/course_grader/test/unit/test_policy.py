"""course_grader.supervision.policy: lockstep or real time, and the environment, from facts alone."""
import pytest

from course_grader.supervision import policy
from course_grader.supervision.policy import SLOWEST_PACE, SLOWEST_WALL_PACE


@pytest.mark.parametrize('facts, lockstep, slowest_pace, remark', [
    ({}, True, SLOWEST_PACE, ''),
    ({'real_time': True}, False, SLOWEST_PACE, ''),
    ({'wall_clock': 'time.sleep'}, False, SLOWEST_WALL_PACE, 'the program uses the wall clock (time.sleep), so it is'),
    ({'wall_clock': 'time.sleep', 'real_time': True}, False, SLOWEST_WALL_PACE, 'the program uses the wall clock'),
    ({'compiled': 'drive'}, False, SLOWEST_WALL_PACE, 'drive is a compiled program, so it is graded in real time'),
])
def test_what_does_not_follow_simulated_time_is_graded_in_real_time(facts, lockstep, slowest_pace, remark):
    decided = policy.decide(**facts)
    assert (decided.lockstep, decided.slowest_pace, len(decided.remarks)) == (lockstep, slowest_pace, bool(remark))
    assert ''.join(decided.remarks).startswith(remark)


@pytest.mark.parametrize('base, packages, expected', [
    ({'HOME': '/h'}, None, {'HOME': '/h'}),
    ({'ROS_PACKAGE_PATH': '/ros'}, '/mine', {'ROS_PACKAGE_PATH': '/mine:/ros'}),
    ({}, '/mine', {'ROS_PACKAGE_PATH': '/mine'}),
    ({'ROS_PACKAGE_PATH': '/ros'}, None, {'ROS_PACKAGE_PATH': '/ros'}),
    ({'DISPLAY': ':0', 'ROS_IP': '10.0.0.1', 'ROS_NAMESPACE': '/x', 'ROSCONSOLE_FORMAT': '${message}'}, None, {}),
    ({'ROS_HOSTNAME': 'robot'}, None, {}),
])
def test_the_environment_is_the_graders_own_without_the_users_settings(base, packages, expected):
    before = dict(base)
    assert policy.environment(base, packages) == {**expected, 'ROS_HOSTNAME': 'localhost'}
    assert base == before
