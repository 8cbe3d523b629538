"""The bench of the marker detector: score and time on frames with ground truth, beside ArUco and the real tracker.

The frames are those of test/data/alvar, or of another folder with frames.json; answers of others that lie beside it
(real_alvar.json, aruco.json) are scored, too. Without a folder, photos by class (marker_classes.py) are scored, too.
"""

import functools
import json
import math
import pathlib
import time

import cv2
import numpy as np

import class_scores
from alvar_core.camera import Camera
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from alvar_core.markers_cli import detection_record
from aruco_baseline import ArucoBaseline
from figures import OURS, Figure, Target, aligned, median, p95
from processes import BenchError
from session import Measurement
from unit_support import marker_classes
from unit_support.marker_score import cameras_of, detector_of, score, scored
from unit_support.photo import with_gamma

NEEDS_NODE = False
FOLDER = pathlib.Path(__file__).resolve().parents[2] / 'test' / 'data' / 'alvar'
DIFFICULTIES = ('easy', 'medium', 'hard')
SIZES = ('640x480', '1280x720')
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
        self.folder = pathlib.Path(folder)
        try:
            self.truth = json.loads((self.folder / 'frames.json').read_text(encoding='utf-8'))
            self._cameras = cameras_of(self.truth)
        except (OSError, ValueError, KeyError) as error:
            raise BenchError(f'{folder} has no frames with ground truth: {error}.') from error
        self._image = functools.lru_cache(maxsize=None)(self._read)

    def _read(self, name):
        image = cv2.imread(str(self.folder / name), cv2.IMREAD_GRAYSCALE)
        if image is None:
            raise BenchError(f'{self.folder / name} cannot be read as an image.')
        return image

    def __iter__(self):
        """Yield (entry of frames.json, grey image, Camera)."""
        for frame in self.truth['frames']:
            yield frame, self._image(frame['file']), self._cameras[frame['camera']]

    def stored(self, name):
        """Return the results that are stored beside the frames, or None."""
        path = self.folder / name
        return json.loads(path.read_text(encoding='utf-8'))['frames'] if path.exists() else None


SHOWN = TOOLS['gamma']
_chosen = {'folder': FOLDER}
_kept = {}  # of the first round of classes: {tool: {class: Score}}


def use(options):
    """Measure on the folder of the options; raise BenchError for a folder without frames."""
    _chosen['folder'] = pathlib.Path(options.folder or FOLDER)
    frames()


_read = functools.lru_cache(maxsize=None)(Frames)


def frames():
    """Return the Frames under test; BenchError if the folder has none."""
    return _read(_chosen['folder'])


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
                out[f'{tool}_rotation_{name}'] = [found[name].rotation(95)]
                out[f'{tool}_corner_{name}'] = found[name].corners() or [math.nan]
    return out


def _timed(samples, key, function, *arguments):
    """Return function(*arguments), and note its CPU time: other load on the machine makes the wall time longer."""
    begun = time.thread_time()
    found = function(*arguments)
    samples.setdefault(f'{key}_cpu', []).append(1e3 * (time.thread_time() - begun))
    return found


def _size_of(image):
    return '{1}x{0}'.format(*image.shape)


def _all_frames(tool, detect, exponent=1.0):
    """Return the scores and times of detect(image, camera, marker's size) on every frame, with this gamma."""
    cv2.setNumThreads(1)
    samples, results = {}, {}
    for frame, rendered, camera in frames():
        arguments = with_gamma(rendered, exponent), camera, frame.get('marker_size_m') or 1.0
        detect(*arguments)  # a first call does what is needed only once
        results[frame['name']] = {'detections': _timed(samples, f'{tool}_{_size_of(rendered)}', detect, *arguments)}
    return {**samples, **scores(tool, results)}


def single(_subject, _scale):
    """Return the scores and times of our detector, each frame on its own."""
    return _all_frames('ours', _detect())


def gamma(_subject, _scale):
    """Return the same of the frames as a camera with GAMMA shows them."""
    return _all_frames('gamma', _detect(), GAMMA)


def _detect():
    """Return a function of our detectors, one of each camera: making one takes longer than an image."""
    detector_of = functools.lru_cache(maxsize=None)(lambda camera: Detector(1.0))

    def detect(image, camera, size):
        detector = detector_of(camera)
        detector.size = size
        return [detection_record(found) for found in detector.detect(image, camera)]
    return detect


def aruco(_subject, _scale):
    """Return the scores and times of OpenCV's detector."""
    return _all_frames('aruco', ArucoBaseline().detect)


def many(_subject, scale):
    """Return how many of the markers of crowded images are missed, the time, and the same of cameras with GAMMA."""
    cv2.setNumThreads(1)
    samples = {}
    for count, layout in CROWDS.items():
        for number in range(max(1, 3 // scale)):
            shot = marker_classes.crowd(*layout, number)
            for key, exponent in ('many', 1.0), ('gamma_many', GAMMA):
                seen = [shot._replace(image=with_gamma(shot.image, exponent))]
                detect = detector_of(marker_classes.SIZE)
                scored(seen, detect)  # a first call does what is needed only once
                score = scored(seen, detect)
                for of, values in (('cpu', score.ms), ('missed', [count - len(score.found)]),
                                   ('false', [score.false + score.wrong]), ('corner', score.corners())):
                    samples.setdefault(f'{key}_{count}_{of}', []).extend(values)
    return samples


def tracking(_subject, scale):
    """Return the time of the tracker, and the share of the markers found singly that it finds while frames move."""
    cv2.setNumThreads(1)
    samples, seen, alone = {}, 0, 0
    chosen = [each for each in frames() if each[0]['markers']][::scale]
    for frame, image, camera in chosen:
        detector = Detector(frame.get('marker_size_m') or 1.0)
        tracker = Tracker(detector)
        for step in range(STEPS):
            moved, lens = np.roll(image, (step * STEP[1], step * STEP[0]), (0, 1)), _moved(camera, step)
            if step:
                seen += len(_timed(samples, f'tracking_{_size_of(image)}', tracker.update, moved, lens))
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
                    out.setdefault(f'{tool}_{_size_of(image)}_cpu', []).append(ms)
    return out


def classes(_subject, scale):
    """Return the scores by class of our detector; keep those of all tools for the preface."""
    if frames().folder != FOLDER:
        return {}
    cv2.setNumThreads(1)
    if not _kept:
        count, size, baseline = max(1, class_scores.PER_CLASS // scale), marker_classes.SIZE, ArucoBaseline()
        tools = {'here': detector_of(size), 'ArUco': lambda image, camera: baseline.detect(image, camera, size)}
        _kept.update(class_scores.scores(tools, count))
        _kept.update(class_scores.scores({SHOWN: detector_of(size)}, count, GAMMA))
    return {**class_scores.samples(_kept['here']), **class_scores.samples(_kept[SHOWN], 'gamma_class')}


MEASUREMENTS = {
    'single': Measurement(single, 'score and time, each frame on its own', in_process=True),
    'gamma': Measurement(gamma, f'the same with a camera of gamma {GAMMA}', in_process=True),
    'tracking': Measurement(tracking, 'time with tracking', in_process=True),
    'many': Measurement(many, 'many markers at once', in_process=True),
    'aruco': Measurement(aruco, 'the same of cv2.aruco', in_process=True),
    'stored': Measurement(stored, 'scores of stored answers', in_process=True),
    'classes': Measurement(classes, 'scores by class: light, paper, camera', in_process=True),
}


def preface(pools):
    """Return the scores of all tools side by side, as text."""
    pool = pools[OURS]
    head = ('', 'recall %', 'position %, median', 'rotation deg, 95th', 'flips/false/wrong', *SIZES)
    rows = [head] + [_row(pool, tool, words) for tool, words in TOOLS.items() if f'{tool}_flips' in pool]
    parts = []
    if len(rows) > 1:
        truth = frames().truth
        parts.append(f"{truth['set']}: {len(truth['frames'])} frames; easy / medium / hard; CPU, ms, median / 95th\n"
                     f'{aligned(rows)}\n')
    if _kept:
        parts.append('By class; median / 95th percentile; '
                     f'off: poses beyond {class_scores.OFF:.0f} degrees without a flag')
        pair = {tool: _kept[tool] for tool in ('here', SHOWN)}  # linear and gamma side by side
        parts += [class_scores.table(group) + '\n' for group in (pair, {'ArUco': _kept['ArUco']})]
    return '\n'.join(parts)


def _row(pool, tool, words):
    def three(key, form):
        values = [pool.get(f'{tool}_{key}_{name}') for name in DIFFICULTIES]
        return ' / '.join(form.format(median(value)) if value else '-' for value in values)

    def time_of(size):
        samples = pool.get(f'{tool}_{size}_cpu')
        return f'{median(samples):.1f} / {p95(samples):.1f}' if samples else '-'
    counts = ' / '.join(f"{median(pool[f'{tool}_{key}']):.0f}" for key in ('flips', 'false', 'wrong'))
    return (words, three('recall', '{:.1f}'), three('position', '{:.2f}'), three('rotation', '{:.1f}'), counts,
            *(time_of(size) for size in SIZES))


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
    for key, words in (('flips', 'unflagged flips'), ('false', 'false positives'), ('wrong', 'wrong ids')):
        for tool, of in ('ours', 'linear'), ('gamma', f'gamma {GAMMA}'):
            yield Figure(f'{words}, {of}', f'{tool}_{key}', 'in all', max, Target('below', 1.0))


def _time_figures():
    for key, words, limits in (('ours', 'single', (3.5, 5.0)), ('tracking', 'with tracking', (2.0, 3.5))):
        for size, limit in zip(SIZES, limits):
            yield Figure(f'{words}, {size}, CPU, median', f'{key}_{size}_cpu', 'ms', median, Target('below', limit))
    yield Figure('found while tracking, of those found singly', 'tracking_found', '%', median, Target('at_least', 99.0))


def _many_figures():
    for count in CROWDS:
        for key, of in ('many', 'linear'), ('gamma_many', f'gamma {GAMMA}'):
            yield Figure(f'{count} at once, {of}: missed', f'{key}_{count}_missed', 'in an image', max,
                         Target('below', 1))
            yield Figure(f'{count} at once, {of}: false or wrong', f'{key}_{count}_false', 'in an image', max,
                         Target('below', 1))
            yield Figure(f'{count} at once, {of}: worst corner, median', f'{key}_{count}_corner', 'px', median)
            yield Figure(f'{count} at once, {of}: CPU, median', f'{key}_{count}_cpu', 'ms', median)


FIGURES = (*_score_figures(), *_time_figures(), *_many_figures(), *class_scores.figures('class', 'linear'),
           *class_scores.figures('gamma_class', f'gamma {GAMMA}'))
