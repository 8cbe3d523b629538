"""The effect of the detector's thresholds: each one changed by -10 % and +10 %, on frames and on rendered scenes.

The scenes add what the frames lack: markers of 7x7 cells (``7x7``), markers with other margins than the detector's
(``margin``), motion (``tracking``), bundles, half of them with a marker that has moved (``bundles``), shadows
(``light``), bent paper (``paper``) and markers of few pixels (``small``). Thresholds of only the tracker or only
bundles are tried on their scenes alone.
"""
import math
import multiprocessing
import os
import pathlib
import re
from contextlib import contextmanager
from typing import Any, Dict, Iterator, List, NamedTuple, Set, Tuple

import numpy as np

from alvar_core import bundles, drawing, native, rotations
from alvar_core.camera import default_camera
from alvar_core.detection import bundle_pose, thresholds
from alvar_core.detection.detector import Detector
from alvar_core.detection.tracker import Tracker
from rostest_support.marker_scenes import Placed, Scene, image_of, random_markers
from unit_support import marker_classes
from unit_support.marker_score import Match, Score, detector_of, records_of, scored

CHANGE = 0.1  # of a threshold
STEPS = {'window': 2}  # the window of a Pass is odd
SIZE = 0.1  # m, of rendered markers
MIN_TURN_CHANGE = 0.05  # degrees: smaller changes of the rotation error are not reported
PAPER_CLASSES = ('even', 'bent 10 cm', 'bent 6 cm', 'creased')
SMALL_CLASSES = ('10 to 13.5 px', '13 to 20 px', 'look-alikes')
ALSO_ON = {'paper': re.compile('BOW|BEND|BENT|FLAT|STRAIGHT|CREASE|FOLD'),  # sets, and what is tried on them, too
           'small': re.compile('SMALL|MIN_SCORE_GAP')}
LIGHT_CLASSES = ('shadow 0.35', 'shadow 0.2', 'soft shadow', 'pole', 'blinds', 'look-alikes')
GLARE_CLASSES = ('laminate', 'tape', 'glare', 'exposure', 'look-alikes')
COUNTS = ('false', 'wrong', 'flips')
OWN_SCENES = {'tracker': 'tracking', 'bundle_pose': 'bundles', 'uneven_light': 'light', 'local_contrast': 'light',
              'broken_outlines': 'light', 'edge_alignment': 'light', 'striped_light': 'light', 'glare': 'glare',
              'bent_paper': 'paper'}  # of the thresholds that only these modules use
PHOTOS = {'light': 4, 'glare': 4, 'paper': 4, 'small': 24}  # of each class


class Part(NamedTuple):
    """One number of a threshold: the threshold's name, the indices in its tuples, the name to print, the number."""

    threshold: str
    path: Tuple[int, ...]
    name: str
    number: float


def parts() -> List[Part]:
    """Return the Parts of all numbers in thresholds.py."""
    found: List[Part] = []
    for name, value in vars(thresholds).items():
        if name.isupper():
            found += _parts(name, (), name, value)
    return found


def _parts(threshold: str, path: Tuple[int, ...], name: str, value: Any) -> Iterator[Part]:
    if not isinstance(value, tuple):
        yield Part(threshold, path, name, value)
        return
    fields = getattr(value, '_fields', None)
    for index, each in enumerate(value):
        inner = f'{name}.{fields[index]}' if fields else f'{name}[{index}]'
        yield from _parts(threshold, (*path, index), inner, each)


def modules_using() -> Dict[str, Set[str]]:
    """Return {threshold: names of the modules and compiled steps of alvar_core that use it}."""
    used: Dict[str, Set[str]] = {}
    detection = pathlib.Path(thresholds.__file__).parent
    for path in (*detection.glob('*.py'), *(detection.parents[2] / 'native').glob('*.cpp')):
        for name in re.findall(r'\b(?:thresholds|limit)\.([A-Z][A-Z0-9_]*)', path.read_text(encoding='utf-8')):
            used.setdefault(name, set()).add(path.stem)
    return used


def changed(part: Part, sign: int) -> float:
    """Return the number of a Part, changed by CHANGE up (sign 1) or down (-1), an integer by at least 1."""
    if isinstance(part.number, int):
        least = STEPS.get(part.name.rpartition('.')[2], 1)
        return part.number + sign * max(least, round(CHANGE * part.number))
    return part.number * (1 + sign * CHANGE)


@contextmanager
def set_to(part: Part, number: float) -> Iterator[None]:
    """Change a number in thresholds.py during the with statement."""
    before = getattr(thresholds, part.threshold)
    setattr(thresholds, part.threshold, _with(before, part.path, number))
    native.limit.read(thresholds)
    try:
        yield
    finally:
        setattr(thresholds, part.threshold, before)
        native.limit.read(thresholds)


def _with(value: Any, path: Tuple[int, ...], number: float) -> Any:
    if not path:
        return number
    items = list(value)
    items[path[0]] = _with(items[path[0]], path[1:], number)
    return type(value)(*items) if hasattr(value, '_fields') else tuple(items)


def _shot(image, camera, placed) -> marker_classes.Shot:
    """Return the Shot of an image and the Placed markers in it."""
    return marker_classes.Shot(image, camera, {'markers': [
        {'id': each.id, 'position': each.position.tolist(), 'corners': each.corners.tolist(),
         'orientation': rotations.quaternion_from_matrix(each.rotation).tolist(),
         'distance_m': float(np.linalg.norm(each.position)), 'ignore': False} for each in placed]})


class Scenes:
    """The frames of a folder (suite_markers.Frames), and rendered scenes, or every n-th; run() scores the detector."""

    BOARD = {number: drawing.object_corners(SIZE) + [0.16 * (number % 3), 0.16 * (number // 3), 0]
             for number in range(6)}

    def __init__(self, frames, every=1):
        self.frames = frames
        self.camera = default_camera(distorted=True)
        self.larger = [self._random(300 + seed, 3, first_id=256) for seed in range(0, 12, every)]
        self.margins = [self._random(400 + seed, 4, margin=(1, 3)[seed % 2]) for seed in range(0, 24, every)]
        self.motion = [list(self._moving(500 + seed)) for seed in range(0, 4, every)]
        self.photos = {key: [marker_classes.photo(name, marker_classes.DEVELOPMENT, number)
                             for name in names for number in range(0, PHOTOS[key], every)]
                       for key, names in (('light', LIGHT_CLASSES), ('glare', GLARE_CLASSES),
                                          ('paper', PAPER_CLASSES), ('small', SMALL_CLASSES))}
        self.boards = [self._board(600 + seed) for seed in range(0, 16, every)]

    def _random(self, seed, count, first_id=0, margin=2):
        """Return the Shot of some random markers."""
        rng = np.random.default_rng(seed)
        blur, noise = rng.uniform([0.4, 1], [1.1, 4]).tolist()
        scene = Scene(blur=blur, noise=noise, shadow=seed % 3 == 0, clutter=3)
        placed = random_markers(rng, self.camera, scene, count, side=(35, 130), size=SIZE, cover=0.15)
        for marker in placed:
            marker.id += first_id
        return _shot(image_of(rng, self.camera, placed, scene, margin), self.camera, placed)

    def _moving(self, seed):
        """Yield the Shots of 20 frames: a marker swings and recedes, one passes by and is hidden for a time."""
        rng = np.random.default_rng(seed)
        scene = Scene(blur=0.7, noise=3.0, clutter=5)
        for frame in range(20):
            turn = 0.35 * frame + seed
            placed = [Placed(seed % 256, SIZE, rotations.facing(0.35 + 0.25 * math.sin(turn), turn, 0.1 * frame),
                             np.array([-0.12, 0.05, 0.5 + 0.07 * frame]))]
            if not 8 <= frame < 12:
                placed.append(Placed(7, SIZE, rotations.facing(0.3, 1.0, 0.3),
                                     np.array([-0.25 + 0.03 * frame, -0.15, 0.8])))
            yield _shot(image_of(rng, self.camera, placed, scene), self.camera, placed)

    def _board(self, seed):
        """Return an image, rotation and position of the board in it, and the ids of the markers that have moved."""
        rng = np.random.default_rng(seed)
        rotation = rotations.facing(*rng.uniform([0.0, 0, 0], [1.0, 6.3, 6.3]))
        position = np.array([0, 0, rng.uniform(0.7, 1.6)]) - rotation @ [0.16, 0.08, 0]
        ids = rng.choice(6, rng.integers(1, 6), replace=False).tolist()
        moved = ids[:1] if len(ids) > 2 and seed % 2 else []
        placed = [Placed(number, SIZE, rotation,
                         rotation @ (self.BOARD[number].mean(0) + [0.02 * (number in moved), 0, 0]) + position)
                  for number in ids]
        image = image_of(rng, self.camera, placed, Scene(blur=0.8, noise=2.0))
        return image, (rotation, position), set(moved)

    def run(self, only: str = '') -> Dict[str, Score]:
        """Return {set: Score} with the current thresholds; ``only``: one of OWN_SCENES, by default all others."""
        if only == 'tracking':
            total = Score()
            for sequence in self.motion:
                total.add(scored(sequence, records_of(Tracker(Detector(SIZE)).update)))
            return {only: total}
        if only in self.photos:
            return {only: scored(self.photos[only], detector_of(marker_classes.SIZE))}
        return {only: self._scored_boards(Detector(SIZE))} if only == 'bundles' else self._single_images()

    def _single_images(self) -> Dict[str, Score]:
        out: Dict[str, Score] = {}
        detector = Detector(1.0)
        for frame, image, camera in self.frames:
            detector.size = frame.get('marker_size_m') or 1.0
            name = frame['difficulty'] if frame['markers'] else 'no marker'
            out.setdefault(name, Score()).add(scored([marker_classes.Shot(image, camera, frame)],
                                                     records_of(detector.detect)))
        out['7x7'] = scored(self.larger, detector_of(SIZE, resolution=7))
        out['margin'] = scored([shot._replace(frame={'markers': []}) for shot in self.margins], detector_of(SIZE))
        return out

    def _scored_boards(self, detector) -> Score:
        """Count as wrong each marker that has moved but is used, or has not moved but is ignored."""
        total = Score()
        bundle = bundles.Bundle('board', 0, tuple(self.BOARD), self.BOARD)
        for image, (rotation, position), moved in self.boards:
            found = bundle_pose.solve(bundle, detector.detect(image, self.camera), self.camera)
            truth = {'position': position.tolist(), 'distance_m': float(np.linalg.norm(position)),
                     'orientation': rotations.quaternion_from_matrix(rotation).tolist()}
            record = found and {'position': found.position.tolist(), 'orientation': found.quaternion.tolist(),
                                'ambiguous': found.ambiguous}
            total.matches.append(Match(truth, record))
            if found:
                total.wrong += len(moved & set(found.used)) + len(set(found.rejected) - moved)
        return total


def figures(scores: Dict[str, Score]) -> Dict[str, Dict[str, float]]:
    """Return {set: {figure: value}}: recall [%], counts, 95th percentile of the rotation error [degrees]; else NaN."""
    return {name: {'recall': score.recall, 'false': score.false, 'wrong': score.wrong, 'flips': score.flips,
                   'rotation': score.rotation(95)} for name, score in scores.items()}


def differences(before: Dict[str, Dict[str, float]], after: Dict[str, Dict[str, float]]) -> str:
    """Return the differences as text; '=' for none."""
    texts = []
    for name, new in after.items():
        old = before[name]
        changes = [f'recall {new["recall"] - old["recall"]:+.1f}'] if abs(new['recall'] - old['recall']) > 1e-9 else []
        changes += [f'{key} {new[key] - old[key]:+d}' for key in COUNTS if new[key] != old[key]]
        if abs(new['rotation'] - old['rotation']) >= MIN_TURN_CHANGE:
            changes.append(f'rotation {new["rotation"] - old["rotation"]:+.2f}')
        if changes:
            texts.append(f'{name}: {", ".join(changes)}')
    return '; '.join(texts) or '='


def baseline_table(before: Dict[str, Dict[str, float]]) -> List[str]:
    """Return the lines of a table of the figures with the current thresholds."""
    rows = ['| set | recall % | false | wrong | flips | rotation, degrees, 95th percentile |',
            '|---|---|---|---|---|---|']
    for name, row in before.items():
        shown = [f'{row[key]:.1f}' if not math.isnan(row[key]) else '-' for key in ('recall', 'rotation')]
        rows.append(f'| {name} | {shown[0]} | {row["false"]} | {row["wrong"]} | {row["flips"]} | {shown[1]} |')
    return rows


def row_of(part: Part, down: str, up: str) -> str:
    """Return the line of a threshold in the table."""
    return f'| `{part.name}` | {part.number:.4g} | {down} | {up} |'


HEAD = ['| threshold | value | -10 % | +10 % |', '|---|---|---|---|']


_scenes: List[Scenes] = []  # of the processes that share the work


def _try(part: Part) -> List[Dict[str, Dict[str, float]]]:
    """Return the figures with a Part changed down and up."""
    scenes = {OWN_SCENES.get(module, '') for module in modules_using()[part.threshold]}
    sets = list(scenes) if len(scenes) == 1 else ['']
    sets += [name for name, names in ALSO_ON.items() if names.search(part.threshold) and name not in sets]
    after = []
    for sign in (-1, 1):
        with set_to(part, changed(part, sign)), np.errstate(all='ignore'):
            after.append(figures({name: score for only in sets for name, score in _scenes[0].run(only).items()}))
    return after


def report(frames, progress=lambda text: None) -> Tuple[str, Dict[str, Any]]:
    """Return the report of all thresholds on these suite_markers.Frames, as text and as a dictionary."""
    _scenes[:] = [Scenes(frames)]
    before: Dict[str, Dict[str, float]] = {}
    for only in ('', *dict.fromkeys((*OWN_SCENES.values(), *ALSO_ON))):
        before.update(figures(_scenes[0].run(only)))
    rows, every, all_figures = [], parts(), {}
    with multiprocessing.get_context('fork').Pool(os.cpu_count()) as pool:
        for number, (part, after) in enumerate(zip(every, pool.imap(_try, every)), 1):
            progress(f'[{number}/{len(every)}] {part.name}')
            rows.append(row_of(part, *(differences(before, each) for each in after)))
            all_figures[part.name] = {'value': part.number, '-10 %': after[0], '+10 %': after[1]}
    text = '\n'.join([*baseline_table(before), '', *HEAD, *rows])
    return text, {'set': frames.truth.get('set'), 'as they are': before, 'thresholds': all_figures}
