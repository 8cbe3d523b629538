"""The sweep of the detector's thresholds: changed numbers, reported differences, a bad threshold that is noticed."""
import math

import pytest

import sensitivity
from alvar_core.detection import thresholds
from sensitivity import Part

pytestmark = pytest.mark.slow


@pytest.mark.parametrize('part, down, up', [
    (Part('A', (), 'A', 0.5), 0.45, 0.55), (Part('A', (), 'A', -0.3), -0.27, -0.33),
    (Part('A', (), 'A', 3), 2, 4), (Part('A', (), 'A', 40), 36, 44), (Part('A', (0, 1), 'A[0].window', 13), 11, 15),
])
def test_a_number_changes_by_a_tenth_a_whole_one_by_at_least_one(part, down, up):
    assert sensitivity.changed(part, -1) == pytest.approx(down) and sensitivity.changed(part, 1) == pytest.approx(up)


def row(recall=90.0, rotation=1.0, **counts):
    return {'recall': recall, 'rotation': rotation, 'false': 0, 'wrong': 0, 'flips': 0, **counts}


@pytest.mark.parametrize('after, text', [
    (row(), '='), (row(rotation=1.04), '='), (row(recall=89.5), 'hard: recall -0.5'),
    (row(false=2, flips=1), 'hard: false +2, flips +1'), (row(rotation=1.5), 'hard: rotation +0.50'),
    (row(recall=math.nan, rotation=math.nan), '='),
])
def test_what_changed_is_named(after, text):
    assert sensitivity.differences({'hard': row(), 'easy': row()}, {'hard': after}) == text


class NoFrames:
    truth = {'set': 'none'}

    def __iter__(self):
        return iter(())


@pytest.mark.nightly
def test_a_bad_threshold_shows():
    """The markers of the rendered scenes are found, but for covered ones; a likeness that nothing has finds none."""
    scenes = sensitivity.Scenes(NoFrames(), every=6)
    found = {}
    for only in ('', *sensitivity.OWN_SCENES.values()):
        found.update(sensitivity.figures(scenes.run(only)))
    assert found['tracking']['recall'] == found['bundles']['recall'] == 100 and found['7x7']['recall'] >= 50
    assert all(each[key] == 0 for each in found.values() for key in sensitivity.COUNTS)
    part, = (part for part in sensitivity.parts() if part.name == 'MIN_LIKENESS')
    with sensitivity.set_to(part, 1.5):
        assert sensitivity.figures(scenes.run())['7x7']['recall'] == 0
    assert thresholds.MIN_LIKENESS == part.number
