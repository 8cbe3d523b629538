"""The bench of the marker tracker's node: time from an image to its message, rate and processor time.

The time runs from the camera's publish() to the message at a subscriber. It includes the transport of the image, which
the node cannot influence. ``video`` shows the node a video of a moving camera.
"""

import functools
import json
import os
import tempfile
from statistics import pstdev

from figures import Figure, Target, mean_rate, median, p95
from processes import Cpu
from session import QUICK, Measurement, answer
from unit_support import course_video

PACKAGE = 'ar_track_alvar'
EXECUTABLE = 'individualMarkersNoKinect'
CASES = {  # name: (options of the probe, words)
    'vga_8': ({'limit': 8}, '640x480, 30 Hz camera, max_frequency 8 Hz'),
    'vga_30': ({'limit': 30}, '640x480, 30 Hz camera, max_frequency 30 Hz'),
    'vga_colour': ({'limit': 8, 'colour': True}, '640x480 rgb8, 30 Hz camera, max_frequency 8 Hz'),
    'vga_colour_30': ({'limit': 30, 'colour': True}, '640x480 rgb8, 30 Hz camera, max_frequency 30 Hz'),
}
VIDEO = f'video of a moving camera, {course_video.WIDTH}x{course_video.HEIGHT} bgr8, {course_video.RATE:g} Hz'
GAMMAS = {'video': course_video.GAMMA, 'video_linear': 1.0}  # of the measurements with a video
LENGTHS = {True: 2, False: 10}  # [s] of the images, quick and in full; of a video each frame about once

_made = {}  # by gamma: the Video, the file of what it shows, and the folder, which is deleted at the end


def _video(seconds, gamma):
    """Return the Video and the file of what it shows."""
    if gamma not in _made:
        folder = tempfile.TemporaryDirectory(prefix='turtle_robotont_video_')
        made = course_video.make(folder.name, seconds, gamma)
        truth = os.path.join(folder.name, 'shown.json')
        with open(truth, 'w', encoding='utf-8') as file:
            json.dump(made.shown, file)
        _made[gamma] = made, truth, folder
    return _made[gamma][:2]


def watch(name, subject, scale):
    """Show a node images: one of CASES, or the video of one of GAMMAS."""
    seconds, options = LENGTHS[scale == QUICK], CASES.get(name, ({},))[0]
    if name in GAMMAS:
        made, truth = _video(seconds, GAMMAS[name])
        options = {'path': made.path, 'truth': truth, 'limit': course_video.RATE}
    with subject.probe('ar_track_probe', 'watch', seconds=seconds, **options) as probe:
        answer(probe, seconds)
        with subject.node() as node:
            for _ in ('first', 'begun'):
                answer(probe, 0.0, node)
            cpu = Cpu(node.pid)
            timed = answer(probe, seconds, node)
            used, each = cpu.percent(), 1e3 * cpu.seconds() / max(1, len(timed['stamps']))
            found = _compared(name, answer(probe, seconds, node)) if name in GAMMAS else {}
    milliseconds = [1e3 * each for each in timed['times']]
    return {f'latency_{name}': milliseconds, f'jitter_{name}': [pstdev(milliseconds)], f'cpu_{name}': [used],
            f'image_cpu_{name}': [each], f'rate_{name}': [mean_rate(timed['stamps'])], **found}


def _compared(key, found):
    return {f'found_{key}': [100.0 * found['found'] / found['seen']], f'other_{key}': [found['other']],
            **{f'{what}_{key}': found[what] for what in ('off', 'far', 'turned')}}


MEASUREMENTS = {**{name: Measurement(functools.partial(watch, name), words) for name, (_, words) in CASES.items()},
                **{name: Measurement(functools.partial(watch, name), f'{VIDEO}, gamma {gamma:g}')
                   for name, gamma in GAMMAS.items()}}


def preface(_pools):
    """Return what the video is, as text."""
    return '\n'.join(f'Video, gamma {gamma:g}: {len(made.shown)} frames, {made.codec}'
                     for gamma, (made, *_) in _made.items())


def _figures():
    for name, shown in (*((name, words) for name, (_, words) in CASES.items()),
                        *((name, f'{VIDEO}, gamma {gamma:g}') for name, gamma in GAMMAS.items())):
        yield Figure(f'picture to message, {shown}, median', f'latency_{name}', 'ms', median, Target('below', 15.0))
        yield Figure(f'picture to message, {shown}, p95', f'latency_{name}', 'ms', p95)
        yield Figure(f'jitter (standard deviation of this time), {shown}', f'jitter_{name}', 'ms', median)
        yield Figure(f'rate, {shown}', f'rate_{name}', 'Hz', median)
        yield Figure(f'CPU, {shown}', f'cpu_{name}', '% of a core', median)
        yield Figure(f'CPU of an image, {shown}', f'image_cpu_{name}', 'ms', median)
    for name, gamma in GAMMAS.items():
        words = f'video, gamma {gamma:g}'
        yield Figure(f'markers found, {words}', f'found_{name}', '%', median)
        yield Figure(f'ids that are not there, {words}', f'other_{name}', 'in all', max, Target('below', 1))
        yield Figure(f'distance too long, {words}, median', f'far_{name}', '%', median)
        for key, kind, unit in ('off', 'position', '% of distance'), ('turned', 'rotation', 'deg'):
            yield Figure(f'{kind} error, {words}, median', f'{key}_{name}', unit, median)
            yield Figure(f'{kind} error, {words}, p95', f'{key}_{name}', unit, p95)


FIGURES = tuple(_figures())
