"""The bench of the marker tracker's node: from a picture to its message, rate and processor time.

The time is that from the camera's publish() to the message at a subscriber: the transport of the picture, which a
node cannot do anything about, is in it.  The form of a suite: suite_turtlesim.py.
"""

import time

from figures import Figure, Target, mean_rate, median, p95
from processes import cpu_between, tree_cpu, tree_memory
from session import answer
from suite_turtlesim import FULL, QUICK, Measurement

PACKAGE = 'ar_track_alvar'
EXECUTABLE = 'individualMarkersNoKinect'

COME_UP = 40.0  # [s] until a node answers; the probe gives up before that with a better text
SETTLE = 1.0  # [s] from the first message until the window opens
CASES = {  # name: (options of the probe, words)
    'vga_8': (('--limit', 8), '640x480, 30 Hz camera, max_frequency 8 Hz'),
    'vga_30': (('--limit', 30), '640x480, 30 Hz camera, max_frequency 30 Hz'),
    'vga_colour': (('--limit', 8, '--colour'), '640x480 rgb8, 30 Hz camera, max_frequency 8 Hz'),
    'vga_colour_30': (('--limit', 30, '--colour'), '640x480 rgb8, 30 Hz camera, max_frequency 30 Hz'),
    'hd_8': (('--limit', 8, '--width', 1280, '--height', 720, '--colour'),
             '1280x720 rgb8, 30 Hz camera, max_frequency 8 Hz'),
}

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']


def start(subject, scale):
    """Measure the time from the start of the process to its first message; the camera runs already."""
    seconds = []
    for _ in range(scale.starts):
        with subject.probe('ar_track_probe.py', 'watch', '--limit', 30, '--seconds', 0.1, '--settle', 0.1) as probe:
            answer(probe, COME_UP)
            begun = time.perf_counter()
            with subject.node() as node:
                seconds.append(answer(probe, COME_UP, [node])['first'] - begun)
    return {'start': seconds}


def watch(name):
    """Return the measurement of one of CASES."""
    def run(subject, scale):
        with subject.probe('ar_track_probe.py', 'watch', *CASES[name][0], '--seconds', 2 * scale.window,
                           '--settle', SETTLE) as probe:
            answer(probe, COME_UP)
            with subject.node() as node:
                answer(probe, COME_UP, [node])
                answer(probe, COME_UP, [node])
                begun, before = time.perf_counter(), tree_cpu(node.pid)
                found = answer(probe, COME_UP + 2 * scale.window, [node])
                cpu = 100.0 * cpu_between(before, tree_cpu(node.pid)) / (time.perf_counter() - begun)
                memory, _ = tree_memory(node.pid)
        return {f'latency_{name}': [1e3 * seconds for seconds in found['times']],
                f'rate_{name}': [mean_rate(found['stamps'])], f'cpu_{name}': [cpu], f'memory_{name}': [memory]}
    return run


MEASUREMENTS = {'start': Measurement(start, 'start to first message'),
                **{name: Measurement(watch(name), words) for name, (_, words) in CASES.items()}}


def _figures():
    limits = dict.fromkeys(('vga_8', 'vga_30', 'vga_colour', 'vga_colour_30'), 15.0)
    for name, (_, words) in CASES.items():
        target = Target('below', limits[name]) if name in limits else None
        yield Figure(f'picture to message, {words}, median', f'latency_{name}', 'ms', median, target)
        yield Figure(f'picture to message, {words}, p95', f'latency_{name}', 'ms', p95)
        yield Figure(f'rate, {words}', f'rate_{name}', 'Hz', median)
        yield Figure(f'CPU, {words}', f'cpu_{name}', '% of a core', median)
        yield Figure(f'memory, {words}', f'memory_{name}', 'MB', median)


FIGURES = (Figure('start to first message', 'start', 's', median, Target('below', 2.0)), *_figures())
