"""Parameters that a launch file sets beside its simulator, such as robot_description, end with the simulator.

It keeps copies below ``~launched``, from which a second simulator that does not start puts back what its launch file
has replaced (single_world).
"""
from __future__ import annotations

import rosgraph.names
import rospy

from rospy_support import parameters, registration
from rospy_support.master import Master
from sim_ros.single_world import LAUNCHED

NAMES = parameters.Text('~launch_parameters', '')  # separated by spaces


def keep(*others: str) -> None:
    """Copy the parameters of ``~launch_parameters``; when the node ends, delete those that still have their values.

    ``others``: names of parameters that are only copied.
    """
    name = rosgraph.names.ns_join(rospy.get_name(), LAUNCHED)
    if rospy.has_param(name):
        rospy.delete_param(name)  # of a run that was killed
    values = Master().parameters(NAMES.read().split())
    copies = {name + original: value for original, value in {**values, **Master().parameters(others)}.items()}
    for copy, value in copies.items():
        rospy.set_param(copy, value)
    registration.delete_at_end({**values, **copies})
