"""Score detectors on the photos of marker_classes, and print the scores by class. A peer reads tags of its own family.

Peers run in a virtual environment that is created for the measurement and deleted after it.
"""
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np

import marker_classes
from alvar_core.detection.detector import Detector
from aruco_baseline import ArucoBaseline
from marker_classes import KINDS, LIGHT, LOOK_ALIKES, PAPER, SIZE
from marker_score import Score, flagged, score_frame
from markers_cli import detection_record
from photo import with_gamma
from processes import BenchError
from report import aligned

HEADS = ('corner px', 'rotation deg', 'flagged %', 'off', 'wrong, false')
COLUMNS = 1 + len(HEADS)  # of a tool in the table
PER_CLASS = 24  # photos of each class, in each half
LOOK_ALIKE_PHOTOS = 35  # for each photo of another class: 10,080 squares
OFF, GOOD = 5.0, 2.0  # [degrees] error of a pose that must be flagged, and of one that must not
PEER_FAMILY = 'AprilTag 36h11'
PEERS = ('napa-vision', 'locus-tag', 'pupil-apriltags')
PEER_SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'peer_detections.py')
TINY, SHINY = '10 to 13.5 px', ('laminate', 'tape', 'faded toner', 'backlight', 'pole', 'flush paper')
SHADOWS = ('shadow 0.5', 'shadow 0.35', 'shadow 0.2', 'soft shadow', 'pole')


class ClassScore(Score):
    """A Score with flags, and with the CPU times ``ms`` of the detector."""

    def __init__(self):
        super().__init__()
        self.ms = []

    def rotations(self, sure=False):
        """Return the rotation errors [degrees]; ``sure``: only of poses without a flag."""
        return [m.rotation_error for m in self.found if not (sure and flagged(m.detection))]

    def flags(self, good_only=False):
        """Return for each pose (``good_only``: if it is right) whether it is flagged."""
        return [flagged(m.detection) for m in self.found if not good_only or m.rotation_error < GOOD]


def scores(tools, half, count, gamma=1.0):
    """Return {tool: {class: ClassScore}} of ``tools``, {name: function (image, camera) that returns detections}.

    ``gamma`` is that of the camera; look-alikes are shown to a linear one only.
    """
    out = {tool: {} for tool in tools}
    for name in (*KINDS, LOOK_ALIKES) if gamma == 1 else KINDS:
        for number in range(count * (LOOK_ALIKE_PHOTOS if name == LOOK_ALIKES else 1)):
            shot = marker_classes.photo(name, half, number)
            image = with_gamma(shot.image, gamma)
            for tool, detect in tools.items():
                score = out[tool].setdefault(name, ClassScore())
                begun = time.thread_time()
                found = detect(image, shot.camera)
                score.ms.append(1e3 * (time.thread_time() - begun))
                score.add(score_frame(shot.frame, shot.camera, marker_classes.WIDTH, found))
    return out


def detector_of(size):
    """Return the function (image, camera) of this project's detector for markers of ``size`` [m]."""
    detector = Detector(size)
    return lambda image, camera: [detection_record(each) for each in detector.detect(image, camera)]


def tools():
    """Return {tool: function (image, camera)} of this project's detector and of OpenCV's."""
    baseline = ArucoBaseline()
    return {'here': detector_of(SIZE), 'ArUco': lambda image, camera: baseline.detect(image, camera, SIZE)}


def _pair(values, form='{:.2f} / {:.2f}'):
    return form.format(*np.percentile(values, [50, 95])) if len(values) else '-'


def table(results):
    """Return the table of {tool: {class: ClassScore}} as text: a group of columns for each tool."""
    head = ['class']
    for tool in results:
        head += [f'{tool}: recall %', *HEADS]
    rows = [head]
    for name in next(iter(results.values())):
        row = [name]
        for by_class in results.values():
            row += _columns(by_class[name]) if name in by_class else ['-'] * COLUMNS
        rows.append(row)
    lines = [aligned(rows)]
    for tool, by_class in results.items():
        times = [each for name in KINDS for each in by_class[name].ms]
        if not times:
            continue
        lines.append('{}: CPU of an image with a marker, ms: median {:.2f}, 95th percentile {:.2f}'.format(
            tool, *np.percentile(times, [50, 95])))
    return '\n'.join(lines)


def _columns(score):
    turns = score.rotations()
    recall = f'{score.recall:.1f}' if score.matches else '-'
    flags = f'{100 * np.mean(score.flags()):.0f}' if score.flags() else '-'
    off = str(sum(turn > OFF for turn in score.rotations(sure=True)))
    return [recall, _pair(score.corners()), _pair(turns, '{:.1f} / {:.1f}'), flags, off,
            f'{score.wrong}, {score.false}']


def figures(by_class, key='class'):
    """Return {figure key: samples} of our scores; all keys begin with ``key``."""
    def all_of(names, method, **options):
        return [value for name in names for value in getattr(by_class[name], method)(**options)]

    def recall(*names):
        found = [m.detection is not None for name in names for m in by_class[name].matches]
        return [100.0 * float(np.mean(found))]
    sure = [turn for score in by_class.values() for turn in score.rotations(sure=True)]
    good = all_of([name for name in KINDS if name != TINY], 'flags', good_only=True)  # TINY has two poses nearly always
    return {
        f'{key}_recall_shadows': recall(*SHADOWS), f'{key}_recall_blinds': recall('blinds'),
        f'{key}_recall_margin': recall('thin margin'), f'{key}_recall_small': recall('13 to 20 px'),
        **{f'{key}_recall_{name}': recall(name) for name in (TINY, *SHINY)},
        f'{key}_corner_light': all_of(LIGHT, 'corners') or [np.inf],
        f'{key}_rotation_light': all_of(LIGHT, 'rotations', sure=True) or [np.inf],
        f'{key}_corner_paper': all_of(PAPER, 'corners') or [np.inf],
        f'{key}_rotation_bent': all_of(['bent 10 cm'], 'rotations', sure=True) or [np.inf],
        f'{key}_rotation_creased': all_of(['bent 6 cm', 'creased'], 'rotations', sure=True) or [np.inf],
        f'{key}_off': [sum(turn > OFF for turn in sure)], f'{key}_flips': [sum(s.flips for s in by_class.values())],
        f'{key}_flagged_good': [100.0 * float(np.mean(good or [0]))],
        f'{key}_false': [sum(score.false for score in by_class.values())],
        f'{key}_wrong': [sum(score.wrong for score in by_class.values())],
    }


def peer_scores(half, count, progress):
    """Return {peer: {class: ClassScore}}; raise BenchError if the peers cannot be installed."""
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_peers_') as folder:
        python = peer_environment(folder, progress)
        shots = _peer_photos(folder, half, count)
        found = {}
        for peer in PEERS:
            progress(f'    {peer}')
            answers = os.path.join(folder, f'{peer}.json')
            peer_call([python, PEER_SCRIPT, peer, folder, str(len(shots)), answers])
            with open(answers, encoding='utf-8') as file:
                found[peer] = _scored(shots, json.load(file))
    return found


def peer_environment(folder, progress, peers=PEERS):
    """Return the Python of a new virtual environment in a folder, with the peers; raise BenchError if that fails."""
    progress(f'    installing {", ".join(peers)} for this measurement')
    home = os.path.join(folder, 'environment')
    peer_call([sys.executable, '-m', 'venv', home])
    python = os.path.join(home, 'bin', 'python')
    peer_call([python, '-m', 'pip', 'install', '--quiet', '--disable-pip-version-check', 'numpy', *peers])
    return python


def peer_call(command):
    """Run a command of the peers' environment; raise BenchError with its last line if it fails."""
    environment = {key: value for key, value in os.environ.items() if key != 'PYTHONPATH'}
    ended = subprocess.run(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=environment)
    if ended.returncode:
        last = (ended.stderr.strip().splitlines() or ['no text'])[-1]
        raise BenchError(f'{" ".join(command[:4])} ended with {ended.returncode}: {last}. The peers are installed from '
                         'PyPI with python3 -m venv and pip: are python3-venv and a network there?')


def _peer_photos(folder, half, count):
    """Save the photos with tags of the peers' family; return [(class, Shot)] in the order of their files."""
    shots = []
    for name in (*KINDS, LOOK_ALIKES):
        for number in range(count):
            shot = marker_classes.photo(name, half, number,
                                        lambda tag: marker_classes.family_cells(PEER_FAMILY, tag))
            np.save(os.path.join(folder, f'{len(shots)}.npy'), shot.image)
            shots.append((name, shot._replace(image=None)))
    return shots


def _scored(shots, answers):
    """Return {class: ClassScore} of a peer's ids and corners; without look-alikes, which are real tags for it."""
    out = {name: ClassScore() for name in (*KINDS, LOOK_ALIKES)}
    pose = ArucoBaseline.pose
    for (name, shot), (found, ms) in zip(shots, answers):
        out[name].ms.append(ms)
        if name != LOOK_ALIKES:
            records = [record for number, corners in found
                       for record in pose(number, np.array(corners), shot.camera, SIZE)]
            out[name].add(score_frame(shot.frame, shot.camera, marker_classes.WIDTH, records))
    return out
