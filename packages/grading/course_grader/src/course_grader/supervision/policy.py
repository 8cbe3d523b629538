"""Decides how a program is simulated, and in which environment. Without ROS.

In lockstep simulated time runs as fast as the nodes become idle, and the result does not depend on the machine. This
needs a program that follows simulated time; every other program is observed in real time.
"""
import os
from typing import Dict, Mapping, NamedTuple, Optional, Tuple

SLOWEST_PACE = 0.8  # of real time, below which a program that never sleeps cannot be judged
SLOWEST_WALL_PACE = 0.95  # the same for a program that uses the wall clock
REMOVED = ('DISPLAY', 'ROSCONSOLE_CONFIG_FILE', 'ROSCONSOLE_FORMAT', 'ROS_IP', 'ROS_IPV6', 'ROS_NAMESPACE')


class Policy(NamedTuple):
    """Lockstep or real time, the slowest pace at which real time can be judged, and why, for the student."""

    lockstep: bool
    slowest_pace: float
    remarks: Tuple[str, ...] = ()


def decide(wall_clock: str = '', compiled: str = '', real_time: bool = False) -> Policy:
    """Return the Policy for a program.

    ``wall_clock``: its call that uses the wall clock; ``compiled``: an executable that it runs, which cannot be
    searched for such calls; ``real_time``: whether the user, or an earlier attempt, asks for real time.
    """
    if wall_clock:
        return Policy(False, SLOWEST_WALL_PACE, (
            f'the program uses the wall clock ({wall_clock}), so it is graded in real time; use rospy.sleep, '
            'rospy.Rate and rospy.Time to be graded faster',))
    if compiled:
        return Policy(False, SLOWEST_WALL_PACE, (f'{compiled} is a compiled program, so it is graded in real time',))
    return Policy(not real_time, SLOWEST_PACE)


def environment(base: Mapping[str, str], packages: Optional[str] = None) -> Dict[str, str]:
    """Return the environment of a grading.

    ``base``: the grader's own; ``packages``: a folder that comes first on the ROS_PACKAGE_PATH.
    """
    kept = {name: value for name, value in base.items() if name not in REMOVED}
    if packages:
        kept['ROS_PACKAGE_PATH'] = os.pathsep.join(filter(None, (packages, kept.get('ROS_PACKAGE_PATH'))))
    return {**kept, 'ROS_HOSTNAME': 'localhost'}
