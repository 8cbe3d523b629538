"""slam_gmapping and amcl as nodes, on drives through the minimaze: ours, and those of a peer's workspace.

All get the same scans, transforms and odometry (navigation_probe.py), and the parameters of the course's launch files.
A drive is played as fast as the node takes it, so that the load of the machine changes no figure but processor time.
"""
import os
from functools import partial
from types import SimpleNamespace

from figures import OURS, Figure, Target, median, p95
from processes import BenchError, Cpu
from session import Measurement, answer, find_node

PROBE = 'navigation_probe'
PATIENCE = 600.0  # [s] for a drive
FOUND = 0.2  # [m]
CERTAIN = 5.0  # [s] for which a robot must stay found
PERIOD = 0.2  # [s] between two scans
NEARLY = 0.99  # shares that differ by less are equal: repeated maps differ by this much
EXECUTABLES = {'gmapping': 'slam_gmapping', 'amcl': 'amcl'}
FRAMES = {'gmapping': ('_base_frame:=base_footprint', '_odom_frame:=odom'),
          'amcl': ('_base_frame_id:=base_footprint', '_odom_frame_id:=odom')}
RECOVERY = '_recovery_alpha_slow:=0.001', '_recovery_alpha_fast:=0.1'  # what amcl's documentation suggests
NO_RECOVERY = '_recovery_alpha_slow:=0.0', '_recovery_alpha_fast:=0.0'
LOST = {'carried': (RECOVERY, False), 'told': (NO_RECOVERY, True)}  # parameters, whether global_localization is called


def devel_space(path):
    """Return the devel space of a workspace; ``path``: that of the workspace, its devel space or a file in this."""
    path = os.path.abspath(os.path.expanduser(path))
    folder = path if os.path.isdir(path) else os.path.dirname(path)
    for found in (folder, os.path.join(folder, 'devel')):
        if os.path.isfile(os.path.join(found, 'env.sh')):
            return found
    raise BenchError(f'--peer {path}: there is no built catkin workspace. Name the folder in which catkin_make was '
                     'run; it has devel/env.sh')


def command(subject, package):
    """Return the command of a side's node, with its frames; raise BenchError if the peer does not have it."""
    executable = EXECUTABLES[package]
    if subject.side == OURS:
        return [*find_node(package, executable), *FRAMES[package]]
    devel = devel_space(subject.command[0])
    if not os.path.isdir(os.path.join(devel, 'share', package)):
        raise BenchError(f'{devel} has no package {package}. Build it there, or leave this out: see --only')
    return [os.path.join(devel, 'env.sh'), os.path.join(devel, 'lib', package, executable), *FRAMES[package]]


def _played(subject, package, task, parameters=(), **arguments):
    """Play a drive to a node; return (the probe's answer, processor time of a scan [ms])."""
    words = command(subject, package)
    with subject.probe(PROBE, task, **arguments) as probe:
        answer(probe, PATIENCE)
        with subject.start(f'{package} of {subject.side}', [*words, *parameters]) as node:
            answer(probe, PATIENCE, node)
            cpu = Cpu(node.pid)
            found = answer(probe, PATIENCE, node)
            return found, 1e3 * cpu.seconds() / len(found['errors'])


def of_errors(key, errors, used):
    """Return {figure key: samples} of pose errors [m], and of processor time [ms]."""
    return {f'{key}_median': [100.0 * median(errors)], f'{key}_p95': [100.0 * p95(errors)], f'{key}_time': [used]}


def of_map(key, found, errors, used):
    """Return the same of a map that was made meanwhile; ``found``: its scores."""
    return {f'{key}_iou': [found.iou], f'{key}_right': [100.0 * found.right], f'{key}_found': [100.0 * found.found],
            **of_errors(key, errors, used)}


def map_drive(drive, subject, _scale):
    """Let slam_gmapping map a drive."""
    found, used = _played(subject, 'gmapping', 'map_drive', ['_minimumScore:=100'], drive=drive)
    return of_map(f'nodes_{drive}', SimpleNamespace(**found), _known(found), used)


def localise(drive, subject, _scale):
    """Let amcl localise on a drive whose start is known."""
    found, used = _played(subject, 'amcl', 'localise', NO_RECOVERY, drive=drive)
    return of_errors(f'nodes_{drive}_local', _known(found), used)


def _known(found):
    return [error for error in found['errors'] if error is not None]


def lose(way, subject, _scale):
    """Carry the robot away, and measure for how long amcl does not know where it is."""
    parameters, call = LOST[way]
    found, _ = _played(subject, 'amcl', 'lose', parameters, call=call)
    return {f'nodes_{way}': [until_found(found['errors'][found['carried']:])]}


def until_found(errors):
    """Return the time [s] until the errors [m] are below FOUND for CERTAIN, or else that of all of them."""
    certain = round(CERTAIN / PERIOD)
    for start in range(len(errors) - certain):
        if all(error is not None and error < FOUND for error in errors[start:start + certain]):
            return start * PERIOD
    return len(errors) * PERIOD


def measurements(noises):
    """Return {name: Measurement} of the nodes; ``noises``: {drive: (noise [m], slip)}."""
    return {**{f'nodes_map_{drive}': Measurement(partial(map_drive, drive), f'slam_gmapping, {drive} odometry')
               for drive in noises},
            'nodes_map_camera': Measurement(partial(map_drive, 'camera'), "slam_gmapping, the camera's 90 degrees"),
            **{f'nodes_localise_{drive}': Measurement(partial(localise, drive), f'amcl, {drive} odometry')
               for drive in noises},
            'nodes_carried': Measurement(partial(lose, 'carried'), 'amcl, a robot that is carried away'),
            'nodes_told': Measurement(partial(lose, 'told'), 'amcl, the same with a call of global_localization')}


def error_figures(key, words, limits, each='scan'):
    """Yield the Figures of ``of_errors``; ``limits``: the Target of each, or None."""
    for (name, of, unit), target in zip((('median', 'pose error, median', 'cm'), ('p95', 'pose error, p95', 'cm'),
                                         ('time', f'CPU {"an" if each == "update" else "a"} {each}', 'ms')), limits):
        yield Figure(f'{words}: {of}', f'{key}_{name}', unit, median, target)


def map_figures(key, words, limits):
    """Yield the Figures of ``of_map`` likewise."""
    for (name, of, unit), target in zip((('iou', 'IoU of the free area', ''),
                                         ('right', 'occupied cells that are right', '%'),
                                         ('found', 'walls found', '%')), limits):
        yield Figure(f'{words}: {of}', f'{key}_{name}', unit, median, target)
    yield from error_figures(key, words, limits[3:])


def figures(noises):
    """Yield the Figures of these measurements."""
    at_least, at_most = Target('times', NEARLY), Target('ratio', 1.0)
    for drive, (noise, slip) in noises.items():
        yield from map_figures(f'nodes_{drive}', f'slam_gmapping, noise {noise:g}, slip {slip:g}',
                               3 * [at_least] + 3 * [at_most])
        yield from error_figures(f'nodes_{drive}_local', f'amcl, noise {noise:g}, slip {slip:g}', 3 * [at_most])
    yield from map_figures('nodes_camera', "slam_gmapping, the camera's 90 degrees", 3 * [at_least] + 3 * [at_most])
    yield Figure('amcl, carried away: time until found', 'nodes_carried', 's', median, at_most)
    yield Figure('amcl, carried away and global_localization: likewise', 'nodes_told', 's', median, at_most)
