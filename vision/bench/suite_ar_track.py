"""The bench of the marker tracker's node: time from an image to its message, rate and processor time.

The time runs from the camera's publish() to the message at a subscriber. It includes the transport of the image, which
the node cannot influence.
"""

import functools

from figures import Figure, Target, mean_rate, median, p95
from processes import Cpu, tree_memory
from session import FULL, QUICK, Measurement, answer, seconds_to_first

PACKAGE = 'ar_track_alvar'
EXECUTABLE = 'individualMarkersNoKinect'
PROBE = 'ar_track_probe'
CASES = {  # name: (options of the probe, words)
    'vga_8': ({'limit': 8}, '640x480, 30 Hz camera, max_frequency 8 Hz'),
    'vga_30': ({'limit': 30}, '640x480, 30 Hz camera, max_frequency 30 Hz'),
    'vga_colour': ({'limit': 8, 'colour': True}, '640x480 rgb8, 30 Hz camera, max_frequency 8 Hz'),
    'vga_colour_30': ({'limit': 30, 'colour': True}, '640x480 rgb8, 30 Hz camera, max_frequency 30 Hz'),
    'hd_8': ({'limit': 8, 'width': 1280, 'height': 720, 'colour': True},
             '1280x720 rgb8, 30 Hz camera, max_frequency 8 Hz'),
}

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']


def start(subject, scale):
    """Measure the time from the start of the process to its first message, with a running camera."""
    return {'start': seconds_to_first(subject, scale, lambda: subject.probe(
        PROBE, 'watch', limit=30, seconds=0.1, settle=0.1))}


def watch(name, subject, scale):
    """Measure one of CASES."""
    with subject.probe(PROBE, 'watch', seconds=2 * scale.window, **CASES[name][0]) as probe:
        answer(probe)
        with subject.node() as node:
            for _ in ('first', 'begun'):
                answer(probe, 0.0, node)
            cpu = Cpu(node.pid)
            found = answer(probe, 2 * scale.window, node)
            used, memory = cpu.percent(), tree_memory(node.pid)[0]
    return {f'latency_{name}': [1e3 * seconds for seconds in found['times']],
            f'rate_{name}': [mean_rate(found['stamps'])], f'cpu_{name}': [used], f'memory_{name}': [memory]}


MEASUREMENTS = {'start': Measurement(start, 'start to first message'),
                **{name: Measurement(functools.partial(watch, name), words) for name, (_, words) in CASES.items()}}


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
