"""The video of a course: it shows what it says, and the bench compares answers with that."""
import os

import numpy as np
import pytest

import course_video
import suite_ar_track


def test_a_video_has_its_frames_and_the_bench_scores_them(monkeypatch):
    monkeypatch.setattr(suite_ar_track, 'LENGTHS', {True: 0.2, False: 0.2})
    monkeypatch.setattr(suite_ar_track, '_made', [])
    samples = suite_ar_track.detectors(None, suite_ar_track.QUICK)
    made, truth = suite_ar_track._made[:2]
    assert len(course_video.frames_of(made.path)) == len(made.shown) == 6 and os.path.exists(truth)
    assert made.codec in suite_ar_track.preface({})
    for tool in ('tracker', 'detector', 'aruco'):
        assert samples[f'other_{tool}'] == [0] and len(samples[f'frame_cpu_{tool}']) == 6
    assert samples['found_detector'] == [100.0] and np.median(samples['off_detector']) < 1.5
    keys = {figure.key for figure in suite_ar_track.FIGURES}
    assert set(samples) <= keys


@pytest.mark.parametrize('answers, expected', [
    ([({'3': [0, 0, 1]}, [(3, (0, 0, 1.01)), (14, (0, 0, 1))])], {'seen': 1, 'found': 1, 'other': 0}),
    ([({'3': [0, 0, 1], '14': [0, 0, 1]}, [(14, (0, 0, 1)), (99, (0, 0, 1))])], {'seen': 2, 'found': 1, 'other': 1}),
    ([({}, [])], {'seen': 0, 'found': 0, 'other': 0}),
])
def test_answers_are_compared_with_what_was_shown(answers, expected):
    found = course_video.compared(answers)
    assert {key: found[key] for key in expected} == expected and len(found['off']) == expected['found']
