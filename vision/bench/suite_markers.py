"""The bench of the marker detector: score and time on frames with ground truth, beside ArUco and the real tracker.

The frames are those of test/data/alvar, or of another folder with frames.json; answers of others that lie beside it
(real_alvar.json, aruco.json) are scored, too. Without a folder, photos by class (marker_classes.py) are scored, too.
"""

import json
import math
import os
import pathlib
import time

import cv2
import numpy as np

import class_scores
import marker_bag
import marker_classes
import no_markers
import peer_times
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from aruco_baseline import ArucoBaseline
from command import progress, write_figures
from figures import OURS, Figure, Target, median, p95
from marker_score import cameras_of, score, score_frame
from markers_cli import detection_record
from photo import with_gamma
from processes import BenchError
from report import aligned
from sensitivity import report as sensitivity_report
from session import Measurement

NEEDS_NODE = False
FOLDER = str(pathlib.Path(__file__).resolve().parents[2] / 'test' / 'data' / 'alvar')
DIFFICULTIES = ('easy', 'medium', 'hard')
SIZES = {(640, 480): '640x480', (1280, 720): '1280x720'}
GAMMA = 2.2  # of most cameras
GAMMA_CORNERS = {'easy': (0.03, 0.06), 'medium': (0.05, 0.1), 'hard': (0.2, 0.6)}  # px, goals: median, 95th percentile
CROWDS = {60: (640, 480, 10, 6), 200: (1280, 720, 20, 10)}  # markers: width, height [px], columns, rows
STEP, STEPS = (2, 1), 6  # [px] how far a frame moves a step while tracking is measured; the first step is no sample
FULL, QUICK = 1, 6  # every n-th frame is timed
STORED = {'real': ('real_alvar.json', 'real tracker, stored'), 'aruco_stored': ('aruco.json', 'ArUco, stored')}
TOOLS = {'ours': 'here', 'gamma': f'here, gamma {GAMMA}', 'aruco': 'ArUco',
         **{key: words for key, (_, words) in STORED.items()}}


class Frames:
    """The frames in a folder with ground truth, images and cameras; BenchError if they cannot be read."""

    def __init__(self, folder):
        self.folder = folder
        try:
            with open(os.path.join(folder, 'frames.json'), encoding='utf-8') as file:
                self.truth = json.load(file)
            self.cameras = cameras_of(self.truth)
        except (OSError, ValueError, KeyError) as error:
            raise BenchError(f'{folder} has no frames with ground truth: {error}.') from error
        self.images = {}

    def __iter__(self):
        """Yield (entry of frames.json, grey image, Camera)."""
        for frame in self.truth['frames']:
            path = os.path.join(self.folder, frame['file'])
            image = self.images.get(path)
            if image is None:
                image = self.images[path] = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
            if image is None:
                raise BenchError(f'{path} cannot be read as an image.')
            yield frame, image, self.cameras[frame['camera']]

    def stored(self, name):
        """Return the results that are stored beside the frames, or None."""
        path = os.path.join(self.folder, name)
        if not os.path.exists(path):
            return None
        with open(path, encoding='utf-8') as file:
            return json.load(file)['frames']


SHOWN = TOOLS['gamma']

_frames = []
_classes = {}  # {'half', 'peers', 'results': {tool: {class: ClassScore}}, 'beside': samples}


def use(options):
    """Measure on the folder and the half of the options; raise BenchError for a folder without frames."""
    _classes.update(half=options.half, peers=options.peers)
    if options.none and not options.folder:
        raise BenchError('--none needs a folder of images: ./run bench markers FOLDER --none')
    if options.folder and not options.none and not options.folder.endswith('.bag'):
        use_folder(options.folder)


def instead(options):
    """Return the function of a function that prints progress which does what the options ask for; else None."""
    cv2.setNumThreads(1)

    def work(progress):
        if options.sensitivity:
            text, figures = sensitivity_report(frames(), progress)
            write_figures(options.json, json.dumps(figures, indent=1))
        else:
            text = (no_markers if options.none else marker_bag).report(options.folder)
        print(text)
        return 0
    return work if options.sensitivity or options.none or (options.folder or '').endswith('.bag') else None


def use_folder(folder):
    """Measure on the frames of this folder; BenchError if it has none."""
    _frames[:] = [Frames(folder)]


def frames():
    """Return the Frames under test."""
    if not _frames:
        use_folder(FOLDER)
    return _frames[0]


def scores(tool, results):
    """Return {figure key: samples} of a tool's results."""
    found = score(frames().truth, results)
    out = {f'{tool}_{key}': [sum(getattr(each, key) for each in found.values())]
           for key in ('flips', 'false', 'wrong', 'double')}
    for name in DIFFICULTIES:
        if name in found and found[name].matches:
            out[f'{tool}_recall_{name}'] = [found[name].recall]
            if found[name].found:
                out[f'{tool}_position_{name}'] = [found[name].position(50)]
                out[f'{tool}_distance_{name}'] = [found[name].distance()]
                out[f'{tool}_rotation_{name}'] = [found[name].rotation(95)]
                out[f'{tool}_corner_{name}'] = found[name].corners() or [math.nan]
    return out


def _timed(samples, key, function, *arguments):
    begun, cpu = time.perf_counter(), time.thread_time()
    found = function(*arguments)
    samples.setdefault(f'{key}_cpu', []).append(1e3 * (time.thread_time() - cpu))
    samples.setdefault(key, []).append(1e3 * (time.perf_counter() - begun))
    return found


def _all_frames(tool, detect, exponent=1.0):
    """Return the scores and times of detect(frame, image, camera) on every frame, with this gamma of its camera."""
    cv2.setNumThreads(1)
    samples, results = {}, {}
    for frame, rendered, camera in frames():
        image = with_gamma(rendered, exponent)
        detect(frame, image, camera)  # a first call does what is needed only once
        size = SIZES.get(image.shape[::-1], 'other')
        found = _timed(samples, f'{tool}_{size}', detect, frame, image, camera)
        results[frame['name']] = {'detections': found}
    return {**samples, **scores(tool, results)}


def single(_subject, _scale):
    """Return the scores and times of our detector, each frame on its own."""
    return _all_frames('ours', _detect())


def gamma(_subject, _scale):
    """Return the same of the frames as a camera with GAMMA shows them."""
    return _all_frames('gamma', _detect(), GAMMA)


def _detect():
    detectors = {}  # of each camera

    def detect(frame, image, camera):
        if frame['camera'] not in detectors:  # making one takes longer than an image
            detectors[frame['camera']] = Detector(1.0)
        detector = detectors[frame['camera']]
        detector.size = frame.get('marker_size_m') or 1.0
        return [detection_record(found) for found in detector.detect(image, camera)]
    return detect


def aruco(_subject, _scale):
    """Return the scores and times of OpenCV's detector."""
    baseline = ArucoBaseline()
    return _all_frames('aruco', lambda frame, image, camera: baseline.detect(image, camera,
                                                                              frame.get('marker_size_m') or 1.0))


def many(_subject, scale):
    """Return how many of the markers of crowded images are missed, the time, and the same of cameras with GAMMA."""
    cv2.setNumThreads(1)
    samples = {}
    for count, layout in CROWDS.items():
        for number in range(max(1, 3 // scale)):
            shot = marker_classes.crowd(*layout, number)
            for key, exponent in ('many', 1.0), ('gamma_many', GAMMA):
                image, detector = with_gamma(shot.image, exponent), Detector(marker_classes.SIZE)
                detector.detect(image, shot.camera)
                found = _timed(samples, f'{key}_{count}', detector.detect, image, shot.camera)
                score = score_frame(shot.frame, shot.camera, layout[0], [detection_record(each) for each in found])
                samples.setdefault(f'{key}_{count}_missed', []).append(count - len(score.found))
                samples.setdefault(f'{key}_{count}_false', []).append(score.false + score.wrong)
                samples.setdefault(f'{key}_{count}_corner', []).extend(score.corners())
    return samples


def tracking(_subject, scale):
    """Return the time of the tracker, and the share of the markers found singly that it finds while frames move."""
    cv2.setNumThreads(1)
    samples, seen, alone = {}, 0, 0
    chosen = [each for each in frames() if each[0]['markers']][::scale]
    for frame, image, camera in chosen:
        detector = Detector(frame.get('marker_size_m') or 1.0)
        tracker, size = Tracker(detector), SIZES.get(image.shape[::-1], 'other')
        for step in range(STEPS):
            moved, lens = np.roll(image, (step * STEP[1], step * STEP[0]), (0, 1)), _moved(camera, step)
            if step:
                seen += len(_timed(samples, f'tracking_{size}', tracker.update, moved, lens))
                alone += len(detector.detect(moved, lens))
            else:
                tracker.update(moved, lens)
    return {**samples, 'tracking_found': [100.0 * seen / alone if alone else 100.0]}


def _moved(camera, step):
    """Return the Camera with its centre moved as the image is: else markers would no longer be squares to it."""
    matrix = camera.matrix.copy()
    matrix[:2, 2] += np.multiply(step, STEP)
    return Camera(matrix, camera.distortion, camera.size)


def stored(_subject, _scale):
    """Return the scores of other tools' results that are stored beside the frames."""
    out = {}
    for tool, (name, _) in STORED.items():
        results = frames().stored(name)
        if results:
            out.update(scores(tool, results))
            for frame, image, _ in frames():
                ms = results.get(frame['name'], {}).get('detect_ms')
                if ms is not None:
                    out.setdefault(f'{tool}_{SIZES.get(image.shape[::-1], "other")}', []).append(ms)
    return out


def classes(_subject, scale):
    """Return the scores by class of our detector; keep those of all tools for the preface."""
    if _frames and _frames[0].folder != FOLDER:
        return {}
    cv2.setNumThreads(1)
    half, count = _classes.get('half', marker_classes.DEVELOPMENT), max(1, class_scores.PER_CLASS // scale)
    if 'results' not in _classes:
        results = class_scores.scores(class_scores.tools(), half, count)
        results.update(class_scores.scores({SHOWN: class_scores.detector_of(marker_classes.SIZE)}, half, count, GAMMA))
        if _classes.get('peers'):
            results.update(class_scores.peer_scores(half, count, print))
        _classes['results'] = results
    results = _classes['results']
    return {**class_scores.figures(results['here']), **class_scores.figures(results[SHOWN], 'gamma_class')}


def beside(_subject, scale):
    """Return the CPU times beside those of a peer; it is installed only if the options ask for peers."""
    if not _classes.get('peers'):
        progress('    skipped: --peers installs napa-vision and measures beside it')
        return {}
    cv2.setNumThreads(1)
    if 'beside' not in _classes:
        _classes['beside'] = peer_times.times(_classes['half'], max(1, peer_times.PHOTOS // scale), progress)
    return _classes['beside']


MEASUREMENTS = {
    'single': Measurement(single, 'score and time, each frame on its own', in_process=True),
    'gamma': Measurement(gamma, f'the same with a camera of gamma {GAMMA}', in_process=True),
    'tracking': Measurement(tracking, 'time with tracking', in_process=True),
    'many': Measurement(many, 'many markers at once', in_process=True),
    'aruco': Measurement(aruco, 'the same of cv2.aruco', in_process=True),
    'stored': Measurement(stored, 'scores of stored answers', in_process=True),
    'beside': Measurement(beside, 'CPU beside napa-vision, with --peers', in_process=True),
    'classes': Measurement(classes, 'scores by class: light, paper, camera', in_process=True),
}


def preface(pools):
    """Return the scores of all tools side by side, as text."""
    pool = pools[OURS]
    head = ('', 'recall %', 'position %, median', 'rotation deg, 95th', 'flips/false/wrong', *SIZES.values())
    rows = [head] + [_row(pool, tool, words) for tool, words in TOOLS.items() if f'{tool}_flips' in pool]
    note = f"{frames().truth['set']}: {len(frames().truth['frames'])} frames; easy / medium / hard; ms median / 95th"
    parts = [f'{note}\n{aligned(rows)}\n' if len(rows) > 1 else '']
    if 'results' in _classes:
        half = _classes.get('half', marker_classes.DEVELOPMENT)
        parts.append(f'By class, {half} half; median / 95th percentile; '
                     f'off: poses beyond {class_scores.OFF:.0f} degrees without a flag')
        results = dict(_classes['results'])
        both = {tool: results.pop(tool) for tool in ('here', SHOWN) if tool in results}  # linear and gamma side by side
        groups = both, *({tool: by_class} for tool, by_class in results.items())
        parts += [class_scores.table(group) + '\n' for group in groups]
    return '\n'.join(part for part in parts if part)


def _row(pool, tool, words):
    def three(key, form):
        values = [pool.get(f'{tool}_{key}_{name}') for name in DIFFICULTIES]
        return ' / '.join(form.format(median(value)) if value else '-' for value in values)

    def time_of(size):
        samples = pool.get(f'{tool}_{size}')
        return f'{median(samples):.1f} / {p95(samples):.1f}' if samples else '-'
    counts = ' / '.join(f"{median(pool[f'{tool}_{key}']):.0f}" for key in ('flips', 'false', 'wrong'))
    return (words, three('recall', '{:.1f}'), three('position', '{:.2f}'), three('rotation', '{:.1f}'), counts,
            *(time_of(size) for size in SIZES.values()))


def _score_figures():
    goals = {'easy': (100.0, 0.2, 1.0, 0.02, 0.05), 'medium': (99.5, 0.5, 5.0, 0.03, 0.07),
             'hard': (92.0, 0.9, 10.0, 0.15, 0.5)}
    for name, (recall, position, rotation, *corner) in goals.items():
        yield Figure(f'recall, {name}', f'ours_recall_{name}', '%', median, Target('at_least', recall))
        yield Figure(f'position error, {name}, median', f'ours_position_{name}', '% of distance', median,
                     Target('below', position))
        yield Figure(f'rotation error, {name}, 95th percentile', f'ours_rotation_{name}', 'degrees', median,
                     Target('below', rotation))
        for key, words, limits in ('ours', 'linear', corner), ('gamma', f'gamma {GAMMA}', GAMMA_CORNERS[name]):
            for pool, of, limit in zip((median, p95), ('median', '95th percentile'), limits):
                yield Figure(f'worst corner, {name}, {words}, {of}', f'{key}_corner_{name}', 'px', pool,
                             Target('below', limit))
            yield Figure(f'distance too long, {name}, {words}, median', f'{key}_distance_{name}', '%', median)
    for key, words in (('flips', 'unflagged flips'), ('false', 'false positives'), ('wrong', 'wrong ids')):
        for tool, of in ('ours', 'linear'), ('gamma', f'gamma {GAMMA}'):
            yield Figure(f'{words}, {of}', f'{tool}_{key}', 'in all', max, Target('below', 1.0))


def _time_figures():
    for key, words, limits in (('ours', 'single', (3.5, 5.0)), ('tracking', 'with tracking', (2.0, 3.5))):
        for size, limit in zip(SIZES.values(), limits):
            # CPU time is judged: what one thread takes. Other load on the machine makes the wall time longer.
            yield Figure(f'{words}, {size}, CPU, median', f'{key}_{size}_cpu', 'ms', median, Target('below', limit))
            yield Figure(f'{words}, {size}, wall, median', f'{key}_{size}', 'ms', median)
            yield Figure(f'{words}, {size}, wall, p95', f'{key}_{size}', 'ms', p95)
    for key, words, limit in ('single', 'single', 4.0), ('tracked', 'with tracking', 2.0):
        yield Figure(f'beside napa-vision, {words}, CPU', f'beside_{key}', 'times', median, Target('below', limit))
    yield Figure('napa-vision, CPU, median', 'beside_peer', 'ms', median)
    yield Figure('found while tracking, of those found singly', 'tracking_found', '%', median, Target('at_least', 99.0))


def _class_figures(key, of):
    for name, words, limit in (('shadows', 'shadows', 95), ('blinds', 'blinds', 90), ('margin', 'thin margins', 99),
                               ('small', '13 to 20 px', 80), ('10 to 13.5 px', '10 to 13.5 px', 80),
                               ('laminate', 'laminate', 50), ('tape', 'tape', 70), ('faded toner', 'faded toner', 80),
                               ('backlight', 'backlight', 90), ('pole', 'pole', 95),
                               ('flush paper', 'paper flush with one side', 90)):
        yield Figure(f'recall, {words}, {of}', f'{key}_recall_{name}', '%', median, Target('at_least', limit))
    for pool, words, limits in (median, 'median', (0.15, 1.0)), (p95, '95th percentile', (0.6, None)):
        yield Figure(f'worst corner in bad light, {of}, {words}', f'{key}_corner_light', 'px', pool,
                     Target('below', limits[0]))
        if limits[1]:
            yield Figure(f'rotation in bad light, {of}, {words}', f'{key}_rotation_light', 'degrees', pool,
                         Target('below', limits[1]))
    for name, words, unit, limit in (
            ('corner_paper', 'worst corner on bent paper', 'px', 0.5),
            ('rotation_bent', 'rotation, bent, radius 10 cm', 'degrees', 1.5),
            ('rotation_creased', 'rotation, radius 6 cm and creased', 'degrees', 3.0)):
        yield Figure(f'{words}, {of}, median', f'{key}_{name}', unit, median, Target('below', limit))
    for name, words in (('off', 'off by 5 degrees without a flag'), ('flips', 'flips'), ('false', 'false positives'),
                        ('wrong', 'wrong ids')):
        yield Figure(f'classes, {of}: {words}', f'{key}_{name}', 'in all', max, Target('below', 1.0))
    yield Figure(f'classes, {of}: flagged, but right', f'{key}_flagged_good', '%', max, Target('below', 3.0))


def _many_figures():
    for count in CROWDS:
        for key, of in ('many', 'linear'), ('gamma_many', f'gamma {GAMMA}'):
            yield Figure(f'{count} at once, {of}: missed', f'{key}_{count}_missed', 'in an image', max,
                         Target('below', 1))
            yield Figure(f'{count} at once, {of}: false or wrong', f'{key}_{count}_false', 'in an image', max,
                         Target('below', 1))
            yield Figure(f'{count} at once, {of}: worst corner, median', f'{key}_{count}_corner', 'px', median)
            yield Figure(f'{count} at once, {of}: CPU, median', f'{key}_{count}_cpu', 'ms', median)


FIGURES = (*_score_figures(), *_time_figures(), *_many_figures(), *_class_figures('class', 'linear'),
           *_class_figures('gamma_class', f'gamma {GAMMA}'))
