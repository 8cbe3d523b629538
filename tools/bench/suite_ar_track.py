"""The bench of the marker tracker's node: time from an image to its message, rate and processor time.

The time runs from the camera's publish() to the message at a subscriber. It includes the transport of the image, which
the node cannot influence. ``video`` shows the node a video of a moving camera; ``detectors`` searches the frames of the
same video without ROS, here and with OpenCV's ArUco.
"""

import functools
import json
import os
import tempfile
import time
from statistics import pstdev

import cv2

from alvar_core import rotations
from alvar_core.camera import default_camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from aruco_baseline import ArucoBaseline
from figures import Figure, Target, mean_rate, median, p95
from processes import Cpu
from session import FULL, QUICK, Measurement, answer
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

__all__ = ['EXECUTABLE', 'FIGURES', 'FULL', 'MEASUREMENTS', 'PACKAGE', 'QUICK']
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


def detectors(_subject, scale):
    """Search the frames of the video in turns with the tracker, the detector and ArUco; time their processor."""
    cv2.setNumThreads(1)
    made, _ = _video(LENGTHS[scale == QUICK], GAMMAS['video'])
    camera, size = default_camera(course_video.WIDTH, course_video.HEIGHT), course_video.SIZE
    tracker, detector, baseline = Tracker(Detector(size)), Detector(size), ArucoBaseline()
    tools = {'tracker': lambda image: [_pose(each) for each in tracker.update(image, camera)],
             'detector': lambda image: [_pose(each) for each in detector.detect(image, camera)],
             'aruco': lambda image: [(each['id'], each['position'] + each['orientation'])
                                     for each in baseline.detect(image, camera, size)]}
    answers, samples = {tool: [] for tool in tools}, {}
    for image, shown in zip(course_video.frames_of(made.path), made.shown):
        grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
        for tool, detect in tools.items():
            begun = time.thread_time()
            found = detect(grey)
            samples.setdefault(f'frame_cpu_{tool}', []).append(1e3 * (time.thread_time() - begun))
            answers[tool].append((shown, found))
    for tool in tools:
        samples.update(_compared(tool, course_video.compared(answers[tool])))
    return samples


def _pose(detection):
    return detection.id, [*detection.position, *rotations.quaternion_from_matrix(detection.rotation)]


MEASUREMENTS = {**{name: Measurement(functools.partial(watch, name), words) for name, (_, words) in CASES.items()},
                **{name: Measurement(functools.partial(watch, name), f'{VIDEO}, gamma {gamma:g}')
                   for name, gamma in GAMMAS.items()},
                'detectors': Measurement(detectors, 'the frames of this video without ROS, beside ArUco',
                                         in_process=True)}


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
        if name in GAMMAS:
            yield from _answers(name, f'node, gamma {GAMMAS[name]:g}')
    for key, words in (('tracker', 'tracker without ROS'), ('detector', 'each frame on its own'), ('aruco', 'ArUco')):
        yield Figure(f'CPU of a frame, video, {words}, median', f'frame_cpu_{key}', 'ms', median)
        yield Figure(f'CPU of a frame, video, {words}, p95', f'frame_cpu_{key}', 'ms', p95)
        yield from _answers(key, words)


def _answers(key, words):
    yield Figure(f'markers found, video, {words}', f'found_{key}', '%', median)
    yield Figure(f'ids that are not there, video, {words}', f'other_{key}', 'in all', max,
                 None if key == 'aruco' else Target('below', 1))
    yield Figure(f'position error, video, {words}, median', f'off_{key}', '% of distance', median)
    yield Figure(f'position error, video, {words}, p95', f'off_{key}', '% of distance', p95)
    yield Figure(f'distance too long, video, {words}, median', f'far_{key}', '%', median)
    yield Figure(f'rotation error, video, {words}, median', f'turned_{key}', 'deg', median)
    yield Figure(f'rotation error, video, {words}, p95', f'turned_{key}', 'deg', p95)


FIGURES = tuple(_figures())
