"""The file that a simulator's ``~record`` asks for."""
import os

import rospy

from kinematic_core.timing.recorder import ACTIVE
from rospy_support import parameters


def begin(make):
    """Return make(path), a timing.recorder.Recorder, for the path in ``~record``; None where that is empty.

    Parameters outlive nodes: one that an earlier run has set must neither cost that run's recording nor keep this one
    from starting.
    """
    path = parameters.text('~record', '')
    if not path:
        return None
    name = rospy.resolve_name('~record')
    try:
        recorder = make(path)
    except OSError as error:
        raise parameters.ParameterError(
            f'parameter {name} is {path!r}: {error}; it must be a file that can be written, '
                                    f'empty. To forget it, type: rosparam delete {name}') from None
    if recorder.path != os.path.abspath(path):
        rospy.logwarn('%s is %r, which exists and stays as it is: this run is recorded in %s. If no recording is '
                      'wanted, type: rosparam delete %s', name, path, recorder.path, name)
    rospy.loginfo('Recording %s, called %s until this node ends.', recorder.path, recorder.path + ACTIVE)
    return recorder
