"""Several Robotonts in one world, in the simulator of gazebo_ros: each in a namespace, with a laser scanner."""
import importlib
import os

import rospkg

from course_grader.rules import random_stimuli
from kinematic_core.worlds.planar import Pose2D

DESCRIPTION = 'robotont_description.urdf'  # module with describe(); the original package does not have it
MODEL = 'robotont_gazebo_lidar'
OWN_TOPICS = 'odom', 'scan', 'joint_states'  # that a program which publishes there forges


def topics(names):
    """Return the topics of robots that only their simulator may publish."""
    return [f'/{name}/{topic}' for name in names for topic in OWN_TOPICS]


def described(exercise, seed, master):
    """Return [(name, URDF, Pose2D)] of the robots of an exercise, and set the prefixes of their frames.

    ``master``: a rosgraph.Master. Raise ImportError if the description of the robot is missing.
    """
    urdf = importlib.import_module(DESCRIPTION)
    folder = os.path.join(rospkg.RosPack().get_path('robotont_description'), 'urdf')
    for name in exercise.robots:
        master.setParam(f'/{name}/tf_prefix', name)
    return [(name, urdf.describe(MODEL, f'{name}/', folder), Pose2D(start['x'], start['y'], start['theta']))
            for name, start in random_stimuli.robots(exercise, seed).items()]
