"""CPU time beside napa-vision from PyPI, on photos by class; it is installed for this measurement only.

It reads tags of its own family in the same scenes, in a virtual environment that is deleted afterwards.
"""
import os
import subprocess
import sys
import tempfile
import time
from statistics import median

import numpy as np

from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from command import progress
from processes import BenchError
from unit_support import marker_classes
from unit_support.marker_classes import SIZE, TEST

FAMILY, PEER = 'AprilTag 36h11', 'napa-vision'
TIMED = ('even', '20 to 25 px', 'jpeg', 'tilt', 'motion')  # classes in which napa-vision finds its tags, too
PHOTOS = 8  # of each of these
TURNS, TRACKED = 3, 6  # turns of both; times that each photo is tracked in a turn
DETECT = '''import sys, time
import numpy
from napa_vision import NapaDetector
detector = NapaDetector(family='tag36h11', min_tag_px=16)
for path in sys.argv[1:]:
    image = numpy.load(path)
    begun = time.process_time()
    detector.detect(image)
    print(1e3 * (time.process_time() - begun))
'''


def times(count):
    """Return {figure key: samples}: our median times as multiples of napa-vision's, and these [ms], for each turn.

    ``count``: photos of each class of TIMED. One thread; both take turns. Raise BenchError if it cannot be installed.
    """
    places = [(name, TEST, number) for name in TIMED for number in range(count)]
    ours, found = [marker_classes.photo(*place) for place in places], {}
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_peers_') as folder:
        python = os.path.join(folder, 'environment', 'bin', 'python')
        progress(f'    installing {PEER} for this measurement')
        _call(sys.executable, '-m', 'venv', os.path.join(folder, 'environment'))
        _call(python, '-m', 'pip', 'install', '--quiet', '--disable-pip-version-check', 'numpy', PEER)
        files = [os.path.join(folder, f'{number}.npy') for number in range(len(places))]
        for file, place in zip(files, places):
            np.save(file, marker_classes.photo(*place, lambda tag: marker_classes.family_cells(FAMILY, tag)).image)
        for turn in range(TURNS):
            progress(f'    turn {turn + 1} of {TURNS}')
            peer = median(map(float, _call(python, '-c', DETECT, *files).split()))
            found.setdefault('beside_peer', []).append(peer)
            for key, measured in ('single', _single), ('tracked', _tracked):
                found.setdefault(f'beside_{key}', []).append(median(map(measured, ours)) / peer)
    return found


def _call(*command):
    """Return what a command of the peer's environment prints; raise BenchError with its last line if it fails."""
    environment = {key: value for key, value in os.environ.items() if key != 'PYTHONPATH'}
    ended = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if ended.returncode:
        last = (ended.stderr.strip().splitlines() or ['no text'])[-1]
        raise BenchError(f'{" ".join(command[:4])} ended with {ended.returncode}: {last}. The peer is installed from '
                         'PyPI with python3 -m venv and pip: are python3-venv and a network there?')
    return ended.stdout


def _single(shot):
    detector = Detector(SIZE)
    detector.detect(shot.image, shot.camera)  # a first call does what is needed only once
    return _timed(detector.detect, shot)


def _tracked(shot):
    tracker = Tracker(Detector(SIZE))
    tracker.update(shot.image, shot.camera)
    return median(_timed(tracker.update, shot) for _ in range(TRACKED))


def _timed(function, shot):
    begun = time.process_time()
    function(shot.image, shot.camera)
    return 1e3 * (time.process_time() - begun)
