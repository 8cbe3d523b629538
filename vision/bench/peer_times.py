"""CPU time of this project's detector beside that of napa-vision, in turns: photos with one marker each, one thread.

The peer reads AprilTags in the same scenes, in a virtual environment that is deleted after the measurement.
"""
import json
import os
import tempfile
import time
from statistics import median

import numpy as np

import marker_classes
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from class_scores import PEER_FAMILY, PEER_SCRIPT, peer_call, peer_environment

PEER = 'napa-vision'
CLASSES = ('even', '20 to 25 px', 'jpeg', 'tilt', 'motion')  # which the peer finds, too
PHOTOS = 8  # of each class
TURNS, TRACKED = 3, 6  # turns of both; times that each photo is tracked in a turn


def times(half, count, progress):
    """Return {figure key: samples}: our median times as multiples of the peer's, and these [ms], one for each turn.

    ``count``: photos of each class in a half. Raise BenchError if the peer cannot be installed.
    """
    places = [(name, number) for name in CLASSES for number in range(count)]
    ours = [marker_classes.photo(name, half, number) for name, number in places]
    found = {}
    with tempfile.TemporaryDirectory(prefix='turtle_robotont_peer_') as folder:
        python = peer_environment(folder, progress, [PEER])
        for place, (name, number) in enumerate(places):
            twin = marker_classes.photo(name, half, number,
                                        lambda tag: marker_classes.family_cells(PEER_FAMILY, tag))
            np.save(os.path.join(folder, f'{place}.npy'), twin.image)
        for turn in range(TURNS):
            progress(f'    turn {turn + 1} of {TURNS}')
            answers = os.path.join(folder, 'answers.json')
            peer_call([python, PEER_SCRIPT, PEER, folder, str(len(places)), answers])
            with open(answers, encoding='utf-8') as file:
                peer = median(ms for _, ms in json.load(file))
            found.setdefault('beside_peer', []).append(peer)
            for key, measured in ('single', _single), ('tracked', _tracked):
                found.setdefault(f'beside_{key}', []).append(median(map(measured, ours)) / peer)
    return found


def _single(shot):
    detector = Detector(marker_classes.SIZE)
    detector.detect(shot.image, shot.camera)  # a first call does what is needed only once
    return _timed(detector.detect, shot)


def _tracked(shot):
    tracker = Tracker(Detector(marker_classes.SIZE))
    tracker.update(shot.image, shot.camera)
    return median(_timed(tracker.update, shot) for _ in range(TRACKED))


def _timed(function, shot):
    begun = time.process_time()
    function(shot.image, shot.camera)
    return 1e3 * (time.process_time() - begun)
