"""Regression floors on the frames with ground truth: ALVAR_FRAMES, or shared/alvar_frames above the project."""
import importlib.util
import json
import os

import pytest

from alvar_core import score_cli


def frames_folder():
    """ALVAR_FRAMES, or shared/alvar_frames beside one of the folders above this file; None if there is none."""
    above = os.path.dirname(os.path.abspath(__file__))
    places = [os.environ.get('ALVAR_FRAMES', '')]
    while os.path.dirname(above) != above:
        above = os.path.dirname(above)
        places.append(os.path.join(above, 'shared', 'alvar_frames'))
    return next((p for p in places if p and os.path.exists(os.path.join(p, 'frames.json'))), None)


FOLDER = frames_folder()
pytestmark = pytest.mark.skipif(FOLDER is None, reason='THE FRAMES SET IS ABSENT: set ALVAR_FRAMES to its folder')

# floors: recall %, position median %, rotation 95th percentile degrees; the goals are 100/98/85, 0.2/0.5/0.9, 1/5/10
FLOORS = {'easy': (100, 0.1, 1.0), 'medium': (96, 0.1, 2.5), 'hard': (84, 0.3, 5.0)}


@pytest.fixture(scope='module')
def scored():
    spec = importlib.util.spec_from_file_location('score_alvar', os.path.join(FOLDER, 'score_alvar.py'))
    scorer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(scorer)
    with open(os.path.join(FOLDER, 'frames.json')) as file:
        truth = json.load(file)
    results = score_cli.run(FOLDER)['frames']
    out = {}
    for frame in truth['frames']:
        found = results[frame['name']]['detections']
        rows, false, wrong, double = scorer.compare(frame, truth['cameras'][frame['camera']], found)
        sums = out.setdefault(frame['difficulty'], {'rows': [], 'false': 0, 'wrong': 0, 'double': 0, 'unflagged': []})
        sums['rows'] += rows
        for key, value in (('false', false), ('wrong', wrong), ('double', double)):
            sums[key] += value
        flagged = {d['id'] for d in found if d['ambiguous']}
        sums['unflagged'] += [r['id'] for r in rows if r.get('rot_err', 0) > 30 and r['id'] not in flagged]
    return {k: dict(v, **scorer.summary(v['rows'])) for k, v in out.items()}


@pytest.mark.parametrize('difficulty', sorted(FLOORS))
def test_floors(scored, difficulty):
    recall, position, rotation = FLOORS[difficulty]
    s = scored[difficulty]
    assert 100 * s['recall'] >= recall and s['pos_med'] <= position and s['rot_95'] <= rotation


def test_nothing_false_wrong_double_or_flipped_unflagged(scored):
    for s in scored.values():
        assert (s['false'], s['wrong'], s['double'], s['unflagged']) == (0, 0, 0, [])
