"""The nodes of navigation that run beside a simulator, as an exercise asks: with the parameters of their launch files.

Fork them while this process has one thread; the map that they get has the true walls, but for what is ``unmapped``.
"""
import contextlib
import importlib
import os

import rospkg
import rospy
import tf2_ros

from course_grader.attempt import forked
from kinematic_core.worlds import world_format
from kinematic_core.worlds.frames import LIDAR_X, LIDAR_Z, frames
from navigation_core.maps import map_files
from navigation_core.poses import Pose
from navigation_core.ros.poses import to_transform
from rospy_support import nodes

MODULES = {'map_server': 'map_server.server', 'amcl': 'amcl.node', 'slam_gmapping': 'gmapping.node',
           'move_base': 'move_base.node'}  # node: module with main()
WITH_NODES = 'roslaunch', 'navigation_core.maps.scores'  # take 0.9 s to import, which other exercises do not need
LAUNCH_FILES = ('robotont_demos', 'gmapping.launch'), ('robotont_navigation', 'navstack.launch')
FOR_A_GRADING = {'/amcl/max_particles': 1000}  # instead of 5000: as exact in a maze, and five times as fast
LAUNCHED = '__log:='  # as roslaunch starts nodes: under their own names, with parameters that are meant
PATIENCE = 10.0  # [s] of ~lockstep_wait: these nodes compute more in a step than those of a student
STEPS = 12  # of the robot between two times, scans and odometry that nodes get: 10 Hz
RESOLUTION = 0.05  # [m] a cell of the map
MAP = 'map'  # name of its files
OWN_TOPICS = {'amcl': ('/amcl_pose', '/particlecloud'), 'slam_gmapping': ('/map',), 'map_server': ('/map',),
              'move_base': ('/move_base/result', '/move_base/status')}  # that a program which publishes there forges


def topics(names):
    """Return the topics that only these nodes may publish."""
    return {topic for name in names for topic in OWN_TOPICS[name]}


def prepare(names):
    """Import what the nodes need, in a process from which attempts are forked; ``start`` says what is missing."""
    with contextlib.suppress(ImportError):
        for module in [*WITH_NODES, *map(MODULES.get, names)] if names else []:
            importlib.import_module(module)


def start(exercise, start_pose, folder, log_folder, master):
    """Fork the nodes; return {name: Forked}. Raise ImportError if one is missing.

    ``start_pose``: {x, y, theta} of the robot; ``folder``: for the files of the map; ``master``: a rosgraph.Master.
    """
    modules = {name: importlib.import_module(MODULES[name]) for name in exercise.beside}
    pose = start_pose if exercise.localised else dict.fromkeys(('x', 'y', 'theta'), 0.0)
    path = os.path.join(folder, f'{MAP}.yaml')
    if 'map_server' in modules:
        _write_map(exercise, folder)
    for name, value in {**_parameters(path, pose), **FOR_A_GRADING, **exercise.parameters}.items():
        if name.split('/')[1] in modules:
            master.setParam(name, value)
    arguments = {'map_server': [path]}
    return {f'/{name}': forked.Forked(
        name, lambda module=module: nodes.run(module.main), [*arguments.get(name, ()), LAUNCHED],
        os.path.join(log_folder, f'{name}.txt')) for name, module in modules.items()}


def publish_mount():
    """Publish where the laser scanner is on the robot, as robot_state_publisher does."""
    names = frames('')
    message = to_transform(Pose(LIDAR_X, 0.0, 0.0), names.footprint, names.lidar, rospy.Time.now())
    message.transform.translation.z = LIDAR_Z
    tf2_ros.StaticTransformBroadcaster().sendTransform(message)


def _parameters(path, pose):
    """Return {name: value} of the launch files."""
    from roslaunch.config import ROSLaunchConfig
    from roslaunch.xmlloader import XmlLoader
    config = ROSLaunchConfig()
    for package, name in LAUNCH_FILES:
        arguments = [f'map_file:={path}', *(f'{arg}:={pose[axis]}' for arg, axis in zip(
            ('x', 'y', 'yaw'), ('x', 'y', 'theta')))] if name == 'navstack.launch' else []
        file = os.path.join(rospkg.RosPack().get_path(package), 'launch', name)
        XmlLoader().load(file, config, argv=arguments, verbose=False)
    return {name: parameter.value for name, parameter in config.params.items()}


def _write_map(exercise, folder):
    from navigation_core.maps.scores import true_map
    plan = world_format.parse(exercise.world)
    known = plan._replace(**{kind: tuple(shape for shape in getattr(plan, kind) if shape.name not in exercise.unmapped)
                             for kind in world_format.KINDS})
    for content, suffix in zip(map_files.saved(true_map(known.outlines(LIDAR_Z), RESOLUTION), MAP), ('pgm', 'yaml')):
        with open(os.path.join(folder, f'{MAP}.{suffix}'), 'wb') as file:
            file.write(content)
