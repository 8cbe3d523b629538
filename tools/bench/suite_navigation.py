"""The bench of mapping and localisation: slam_gmapping and amcl on drives through the minimaze, beside a peer's.

With --peer WORKSPACE, the nodes of that workspace play the same drives: the same scans, transforms and odometry
(navigation_probe.py), and the parameters of the course's launch files. A drive is played as fast as the node takes it,
so that the load of the machine changes no figure but processor time. The odometry of a robot in `NOISES` gets worse
from drive to drive. Pose errors are those of every scan (5 a second); processor time is that of one scan.
"""
import math
import os
from functools import lru_cache, partial

from figures import OURS, Figure, Target, median, p95
from processes import BenchError, Cpu
from session import Measurement, answer, find_node
from unit_support.maze_drive import drive

PACKAGE, EXECUTABLE = 'gmapping', 'slam_gmapping'
NOISES = {'exact': (0.0, 0.0), 'good': (0.02, 0.02), 'fair': (0.05, 0.05), 'bad': (0.1, 0.05)}  # noise [m], slip
CARRIED = 150, 330  # scans between which the robot is carried: it does not see them
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

moments = lru_cache(maxsize=None)(drive)


def error(pose, truth):
    return math.hypot(pose.x - truth.x, pose.y - truth.y)


def carried_log(log):
    """Return (Moments without those in which the robot was carried, index of the first after that).

    Its wheels did not turn meanwhile, and no time has passed.
    """
    before, after = log[:CARRIED[0]], log[CARRIED[1]:]
    last, first = before[-1], after[0]
    wait = last.time - before[-2].time
    return before + [moment._replace(time=last.time + wait + moment.time - first.time,
                                     odometry=last.odometry.then(first.odometry.step_to(moment.odometry)))
                     for moment in after], len(before)


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


def map_drive(drive, subject, _scale):
    """Let slam_gmapping map a drive."""
    found, used = _played(subject, 'gmapping', 'map_drive', ['_minimumScore:=100'], drive=drive)
    shares = {'iou': found['iou'], 'right': 100.0 * found['right'], 'found': 100.0 * found['found']}
    return {**{f'map_{drive}_{name}': [value] for name, value in shares.items()},
            **of_errors(f'map_{drive}', _known(found), used)}


def localise(drive, subject, _scale):
    """Let amcl localise on a drive whose start is known."""
    found, used = _played(subject, 'amcl', 'localise', NO_RECOVERY, drive=drive)
    return of_errors(f'localise_{drive}', _known(found), used)


def _known(found):
    return [error for error in found['errors'] if error is not None]


def lose(way, subject, _scale):
    """Carry the robot away, and measure for how long amcl does not know where it is."""
    parameters, call = LOST[way]
    found, _ = _played(subject, 'amcl', 'lose', parameters, call=call)
    return {way: [until_found(found['errors'][found['carried']:])]}


def until_found(errors):
    """Return the time [s] until the errors [m] are below FOUND for CERTAIN, or else that of all of them."""
    certain = round(CERTAIN / PERIOD)
    for start in range(len(errors) - certain):
        if all(error is not None and error < FOUND for error in errors[start:start + certain]):
            return start * PERIOD
    return len(errors) * PERIOD


def use(options):
    """Refuse a peer that is no built workspace."""
    if options.peer:
        devel_space(options.peer)


MEASUREMENTS = {
    **{f'map_{name}': Measurement(partial(map_drive, name), f'slam_gmapping, {name} odometry') for name in NOISES},
    'map_camera': Measurement(partial(map_drive, 'camera'), "slam_gmapping, the camera's 90 degrees"),
    **{f'localise_{name}': Measurement(partial(localise, name), f'amcl, {name} odometry') for name in NOISES},
    'carried': Measurement(partial(lose, 'carried'), 'amcl, a robot that is carried away'),
    'told': Measurement(partial(lose, 'told'), 'amcl, the same with a call of global_localization')}


def _error_figures(key, words):
    for name, of, unit in (('median', 'pose error, median', 'cm'), ('p95', 'pose error, p95', 'cm'),
                           ('time', 'CPU a scan', 'ms')):
        yield Figure(f'{words}: {of}', f'{key}_{name}', unit, median, Target('ratio', 1.0))


def _map_figures(key, words):
    for name, of, unit in (('iou', 'IoU of the free area', ''), ('right', 'occupied cells that are right', '%'),
                           ('found', 'walls found', '%')):
        yield Figure(f'{words}: {of}', f'{key}_{name}', unit, median, Target('times', NEARLY))
    yield from _error_figures(key, words)


def _figures():
    for name, (noise, slip) in NOISES.items():
        yield from _map_figures(f'map_{name}', f'slam_gmapping, noise {noise:g}, slip {slip:g}')
        yield from _error_figures(f'localise_{name}', f'amcl, noise {noise:g}, slip {slip:g}')
    yield from _map_figures('map_camera', "slam_gmapping, the camera's 90 degrees")
    yield Figure('amcl, carried away: time until found', 'carried', 's', median, Target('ratio', 1.0))
    yield Figure('amcl, carried away and global_localization: likewise', 'told', 's', median, Target('ratio', 1.0))


FIGURES = tuple(_figures())
