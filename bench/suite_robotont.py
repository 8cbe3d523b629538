"""The bench of robotont_gazebo: how fast the simulator's parts are, and what the nodes take at the rate of the clock.

The same form as suite_turtlesim.py. "Times real time" is simulated seconds a second of one core.
"""

import time
from statistics import stdev

from figures import Figure, Target, intervals, mean_rate, median
from processes import cpu_between, tree_cpu, tree_memory
from session import answer, find_node
from suite_turtlesim import COME_UP, FULL, QUICK, SETTLE, Measurement

PACKAGE = 'robotont_gazebo'
EXECUTABLE = 'robotont_gazebo'
WORLD = '_world:=minimaze_ar', '_x:=-2.0'
PROBE = 'robotont_probe.py'

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']


def start(subject, scale):
    """Measure the time from the start of the process to its first odometry at a waiting subscriber."""
    seconds = []
    for _ in range(scale.starts):
        with subject.probe(PROBE, 'first', 'odom') as probe:
            answer(probe, COME_UP)
            begun = time.perf_counter()
            with subject.node(*WORLD) as node:
                seconds.append(answer(probe, COME_UP, [node])['stamp'] - begun)
    return {'start': seconds}


def rates(subject, scale):
    """Measure rate and regularity of odometry and scans, and the CPU time and memory of the node."""
    found = {}
    with subject.node(*WORLD, '_model:=robotont_gazebo_lidar') as node:
        for topic in ('odom', 'scan'):
            with subject.probe(PROBE, 'listen', topic, '--seconds', scale.window) as probe:
                answer(probe, COME_UP, [node])
                time.sleep(SETTLE)
                used = _percent(node, scale.window)
                stamps = answer(probe, COME_UP + scale.window, [node])['stamps']
            found[f'{topic}_cpu'] = [used]
            found[f'{topic}_rate'] = [mean_rate(stamps)]
            found[f'{topic}_jitter'] = [1e3 * stdev(intervals(stamps))]
        found['memory'] = [tree_memory(node.pid)[0]]
    return found


def camera(topic, key):
    """Return the measurement of a camera of 1280 x 720 with one subscriber to ``topic``."""
    def run(subject, scale):
        with subject.node(*WORLD) as node, subject.other(find_node(PACKAGE, 'robotont_camera')) as eye:
            with subject.probe(PROBE, 'listen', topic, '--turning', '--seconds', scale.window) as probe:
                answer(probe, COME_UP, [node, eye])
                time.sleep(SETTLE)
                used = _percent(eye, scale.window)
                stamps = answer(probe, COME_UP + scale.window, [node, eye])['stamps']
            return {f'{key}_cpu': [used], f'{key}_rate': [mean_rate(stamps)],
                    f'{key}_memory': [tree_memory(eye.pid)[0]]}
    return run


def _percent(child, seconds):
    begun, before = time.perf_counter(), tree_cpu(child.pid)
    time.sleep(seconds)
    return 100.0 * cpu_between(before, tree_cpu(child.pid)) / (time.perf_counter() - begun)


def core(subject, scale):
    """Measure the simulator's parts without ROS."""
    with subject.probe('robotont_core_probe.py', scale.window / 2.5) as probe:
        return {key: [value] for key, value in answer(probe, COME_UP + 4.0 * scale.window).items()}


MEASUREMENTS = {
    'start': Measurement(start, 'start to first odometry'),
    'rates': Measurement(rates, 'odometry and scans'),
    'colour': Measurement(camera('camera/color/image_raw', 'colour'), 'colour pictures of 1280 x 720'),
    'depth': Measurement(camera('camera/depth/image_rect_raw', 'depth'), 'depth pictures of 1280 x 720'),
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
