"""The bench of mapping and localisation: drives through the minimaze without ROS, compared with the truth.

The odometry of a robot in `NOISES` gets worse from drive to drive. Pose errors are those of every scan (5 a second);
processor time is that of one scan.

With --peer WORKSPACE, the nodes are measured instead, and those of the workspace beside them: see stacks.py.
"""
import math
import os
import time
from functools import lru_cache, partial
from statistics import mean

os.environ['OMP_NUM_THREADS'] = os.environ['OPENBLAS_NUM_THREADS'] = '1'  # before numpy is loaded

import cv2
import numpy as np

import stacks
from figures import Figure, Target, median
from navigation_core.localisation import particle_filter
from navigation_core.localisation.particle_filter import ParticleFilter
from navigation_core.localisation.sensor import MeasuredMap, SensorModel
from navigation_core.maps.scores import scores
from navigation_core.poses import Pose
from navigation_core.slam import mapper
from navigation_core.slam.mapper import Mapper
from session import FULL, QUICK, Measurement
from unit_support import goals
from unit_support.maze_drive import START, camera_scan, drive, lidar_scan, walls

PACKAGE, EXECUTABLE = 'gmapping', 'slam_gmapping'
NOISES = {'exact': (0.0, 0.0), 'good': (0.02, 0.02), 'fair': (0.05, 0.05), 'bad': (0.1, 0.05)}  # noise [m], slip
PARTICLES = 500
SPREAD = np.diag([0.2, 0.2, 0.2]) ** 2
UPDATE_DISTANCE, UPDATE_TURN = 0.2, math.pi / 6.0  # [m], [rad] amcl's
CARRIED = 150, 330  # scans between which the robot is carried: it does not see them

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']
cv2.setNumThreads(1)
moments = lru_cache(maxsize=None)(drive)


def error(pose, truth):
    return math.hypot(pose.x - truth.x, pose.y - truth.y)


def mapped(log, scan_of, **settings):
    """Return (Mapper, errors [m], processor time of each scan [ms])."""
    made, errors, times = Mapper(mapper.Settings(area=(-5.0, -5.0, 5.0, 5.0), **settings), Pose(*START)), [], []
    for moment in log:
        scan, begun = scan_of(moment), time.process_time()
        made.process(moment.odometry, scan, moment.time)
        times.append(1e3 * (time.process_time() - begun))
        errors.append(error(made.pose, moment.truth))
    return made, errors, times


def map_drive(name, scan_of, key, seed, _subject, _scale, **settings):
    """Map a drive and score the map."""
    made, errors, times = mapped(moments(*NOISES[name], seed), scan_of, **settings)
    return stacks.of_map(key, scores(made.to_map(), walls(), START[:2]), errors, mean(times))


@lru_cache(maxsize=None)
def known_map():
    """Return the MeasuredMap of an exact drive, whose frame is the world's."""
    return MeasuredMap(mapped(moments(*NOISES['exact'], 1), lidar_scan)[0].to_map(), 2.0)


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


def localised(log, **settings):
    """Return (errors [m] of each scan, processor time of each update [ms])."""
    tracked = ParticleFilter(known_map(), particle_filter.Settings(
        max_particles=PARTICLES, motion='omni-corrected', **settings), SensorModel())
    tracked.place(log[0].truth, SPREAD)
    last = base = None
    errors, times = [], []
    for moment in log:
        step = last.step_to(moment.odometry) if last else Pose()
        if base is None or math.hypot(step.x, step.y) > UPDATE_DISTANCE or abs(step.yaw) > UPDATE_TURN:
            begun = time.process_time()
            tracked.update(step, lidar_scan(moment))
            pose = tracked.estimate().pose
            times.append(1e3 * (time.process_time() - begun))
            last, base = moment.odometry, pose.then(moment.odometry.inverse())
        errors.append(error(base.then(moment.odometry), moment.truth))
    return errors, times


def localise(name, _subject, _scale):
    """Localise on a drive whose start is known."""
    errors, times = localised(moments(*NOISES[name], 2))
    return stacks.of_errors(f'{name}_local', errors, mean(times))


def carry(_subject, _scale):
    """Measure how long a robot that was carried away drives until it knows where it is."""
    log, start = carried_log(moments(*NOISES['good'], 2))
    errors, _ = localised(log, recovery_slow=0.001, recovery_fast=0.1)
    late = [index for index in range(start, len(log)) if errors[index] > stacks.FOUND]
    first = next(index for index in range(start, len(log)) if errors[index] < stacks.FOUND)
    return {'carried': [log[first].time - log[start].time], 'carried_lost': [100.0 * len(late) / len(log)]}


MEASUREMENTS = {f'map_{name}': Measurement(partial(map_drive, name, lidar_scan, name, 1), f'map, {name} odometry',
                                           in_process=True) for name in NOISES}
MEASUREMENTS['map_camera'] = Measurement(partial(map_drive, 'good', camera_scan, 'camera', 1),
                                         "map, the camera's 90 degrees", in_process=True)
MEASUREMENTS.update({f'localise_{name}': Measurement(partial(localise, name), f'localise, {name} odometry',
                                                     in_process=True) for name in NOISES})
MEASUREMENTS['goals'] = Measurement(lambda _subject, _scale: goals.measured(), '20 random goals', in_process=True)
MEASUREMENTS['carried'] = Measurement(carry, 'a robot that is carried away', in_process=True)
NODES = stacks.measurements(NOISES)
CORE = list(MEASUREMENTS)
MEASUREMENTS.update(NODES)


def use(options):
    """Measure the nodes with a peer, and the core without one, unless the user has chosen."""
    if options.peer:
        stacks.devel_space(options.peer)
    options.only = options.only or list(NODES if options.peer else CORE)


def _figures():
    below_10 = Target('below', 10.0)
    for name, (noise, slip) in NOISES.items():
        yield from stacks.map_figures(name, f'map, noise {noise:g}, slip {slip:g}', (
            Target('at_least', 0.95), None, None, Target('below', 5.0), below_10, below_10))
        yield from stacks.error_figures(f'{name}_local', f'localisation, noise {noise:g}', (
            Target('below', 5.0), below_10, None), 'update')
    yield from stacks.map_figures('camera', "map, the camera's 90 degrees, noise 0.02", (
        Target('at_least', 0.8), None, None, below_10, below_10, below_10))
    yield Figure('carried away: time until found', 'carried', 's', median, Target('below', 15.0))
    yield Figure('carried away: scans off by more than 0.2 m', 'carried_lost', '%')


FIGURES = (*_figures(), *goals.FIGURES, *stacks.figures(NOISES))
