"""The bench of robotont_gazebo: the speed of the simulator's parts, and the processor time of its nodes in real time.

"Times real time" is simulated seconds a second of one core.
"""

from functools import partial
from statistics import stdev

from figures import Figure, Target, intervals, mean_rate, median
from processes import tree_memory
from session import FULL, QUICK, Measurement, answer, find_node, listened, seconds_to_first

PACKAGE = 'robotont_gazebo'
EXECUTABLE = 'robotont_gazebo'
WORLD = '_world:=minimaze_ar', '_x:=-2.0'

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']


def start(subject, scale):
    """Measure the time from the start of the process to its first odometry at a waiting subscriber."""
    return {'start': seconds_to_first(subject, scale, 'odom', *WORLD)}


def rates(subject, scale):
    """Measure rate and regularity of odometry and scans, and the CPU time and memory of the node."""
    found = {}
    with subject.node(*WORLD, '_model:=robotont_gazebo_lidar') as node:
        for topic in ('odom', 'scan'):
            used, stamps = listened(subject, node, scale, topic=topic)
            found.update({f'{topic}_cpu': [used], f'{topic}_rate': [mean_rate(stamps)],
                          f'{topic}_jitter': [1e3 * stdev(intervals(stamps))]})
        found['memory'] = [tree_memory(node.pid)[0]]
    return found


def camera(topic, key, subject, scale):
    """Measure a camera of 1280 x 720 with one subscriber to ``topic``."""
    with subject.node(*WORLD), subject.other(find_node(PACKAGE, 'robotont_camera')) as eye:
        used, stamps = listened(subject, eye, scale, topic=topic, turning=True)
        return {f'{key}_cpu': [used], f'{key}_rate': [mean_rate(stamps)], f'{key}_memory': [tree_memory(eye.pid)[0]]}


def core(subject, scale):
    """Measure the simulator's parts without ROS."""
    with subject.probe('robotont_core_probe', 'real_time', seconds=scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first odometry'),
    'rates': Measurement(rates, 'odometry and scans'),
    'colour': Measurement(partial(camera, 'camera/color/image_raw', 'colour'), 'colour images of 1280 x 720'),
    'depth': Measurement(partial(camera, 'camera/depth/image_rect_raw', 'depth'), 'depth images of 1280 x 720'),
    'core': Measurement(core, 'kinematics, scanner, camera, tracker without ROS', in_process=True),
}


def _camera_figures():
    for key, word in (('colour', 'colour'), ('depth', 'depth')):
        yield Figure(f'{word} pictures', f'{key}_rate', 'Hz')
        yield Figure(f'CPU, {word} pictures', f'{key}_cpu', '% of a core', median, Target('below', 50.0))
        yield Figure(f'memory, {word} pictures', f'{key}_memory', 'MB')


FIGURES = (
    Figure('start to first odometry', 'start', 's', median, Target('below', 1.0)),
    Figure('odometry', 'odom_rate', 'Hz', median, Target('near', 30.0)),
    Figure('odometry, jitter (std dev)', 'odom_jitter', 'ms'),
    Figure('CPU, one subscriber of odometry', 'odom_cpu', '% of a core'),
    Figure('scans', 'scan_rate', 'Hz', median, Target('near', 40.0)),
    Figure('scans, jitter (std dev)', 'scan_jitter', 'ms'),
    Figure('CPU, one subscriber of scans', 'scan_cpu', '% of a core'),
    Figure('memory', 'memory', 'MB'),
    *_camera_figures(),
    Figure('kinematics alone', 'kinematics', 'x real time', median, Target('at_least', 500.0)),
    Figure('kinematics and scanner', 'scanner', 'x real time', median, Target('at_least', 50.0)),
    Figure('kinematics, 640 x 480 camera, tracker at 7.5 Hz', 'tracker', 'x real time', median,
           Target('at_least', 8.0)),
    Figure('the same, tracker in every picture', 'tracker_each', 'x real time', median, Target('at_least', 10.0)),
    Figure('one 1280 x 720 picture', 'picture', 'ms'),
)
