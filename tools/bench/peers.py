"""Peers from PyPI beside this project's detector, on photos by class: their scores and their CPU times.

They read tags of their own family in the same scenes, in a virtual environment that is deleted after the measurement.
"""
import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from statistics import median

import numpy as np

from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from aruco_baseline import ArucoBaseline
from processes import BenchError
from unit_support import marker_classes
from unit_support.marker_classes import KINDS, LOOK_ALIKES, SIZE
from unit_support.marker_score import Score, score_frame

FAMILY = 'AprilTag 36h11'
PEERS = ('napa-vision', 'locus-tag', 'pupil-apriltags')
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'peer_detections.py')
TIMED = ('even', '20 to 25 px', 'jpeg', 'tilt', 'motion')  # classes in which napa-vision finds its tags, too
PHOTOS = 8  # of each of these
TURNS, TRACKED = 3, 6  # turns of both; times that each photo is tracked in a turn


def tag_photo(name, half, number):
    """Return the Shot of a class with a tag of the peers' family."""
    return marker_classes.photo(name, half, number, lambda tag: marker_classes.family_cells(FAMILY, tag))


@contextlib.contextmanager
def installed(peers, shots, progress):
    """Yield a function of a peer that returns [([(id, corners)], CPU [ms])] of the Shots.

    Raise BenchError if the peers cannot be installed.
    """
    progress(f'    installing {", ".join(peers)} for this measurement')
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_peers_') as folder:
        python, answers = (os.path.join(folder, name) for name in ('environment/bin/python', 'answers.json'))
        _call([sys.executable, '-m', 'venv', os.path.join(folder, 'environment')])
        _call([python, '-m', 'pip', 'install', '--quiet', '--disable-pip-version-check', 'numpy', *peers])
        for number, shot in enumerate(shots):
            np.save(os.path.join(folder, f'{number}.npy'), shot.image)

        def detections(peer):
            _call([python, SCRIPT, peer, folder, str(len(shots)), answers])
            with open(answers, encoding='utf-8') as file:
                return json.load(file)
        yield detections


def _call(command):
    """Run a command of the peers' environment; raise BenchError with its last line if it fails."""
    environment = {key: value for key, value in os.environ.items() if key != 'PYTHONPATH'}
    ended = subprocess.run(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, env=environment)
    if ended.returncode:
        last = (ended.stderr.strip().splitlines() or ['no text'])[-1]
        raise BenchError(f'{" ".join(command[:4])} ended with {ended.returncode}: {last}. The peers are installed from '
                         'PyPI with python3 -m venv and pip: are python3-venv and a network there?')


def scores(half, count, progress):
    """Return {peer: {class: Score}}, without look-alikes, which are real tags for a peer."""
    places = [(name, number) for name in (*KINDS, LOOK_ALIKES) for number in range(count)]
    shots, out = [tag_photo(name, half, number) for name, number in places], {}
    with installed(PEERS, shots, progress) as detections:
        for peer in PEERS:
            progress(f'    {peer}')
            found = out[peer] = {name: Score() for name in (*KINDS, LOOK_ALIKES)}
            for (name, _), shot, (tags, ms) in zip(places, shots, detections(peer)):
                found[name].ms.append(ms)
                if name != LOOK_ALIKES:
                    records = [record for tag, corners in tags
                               for record in ArucoBaseline.pose(tag, np.array(corners), shot.camera, SIZE)]
                    found[name].add(score_frame(shot.frame, shot.camera, marker_classes.WIDTH, records))
    return out


def times(half, count, progress):
    """Return {figure key: samples}: our median times as multiples of napa-vision's, and these [ms], for each turn.

    ``count``: photos of each class of TIMED in a half. One thread; both take turns.
    """
    places = [(name, half, number) for name in TIMED for number in range(count)]
    ours, found = [marker_classes.photo(*place) for place in places], {}
    with installed(PEERS[:1], [tag_photo(*place) for place in places], progress) as detections:
        for turn in range(TURNS):
            progress(f'    turn {turn + 1} of {TURNS}')
            peer = median(ms for _, ms in detections(PEERS[0]))
            found.setdefault('beside_peer', []).append(peer)
            for key, measured in ('single', _single), ('tracked', _tracked):
                found.setdefault(f'beside_{key}', []).append(median(map(measured, ours)) / peer)
    return found


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
