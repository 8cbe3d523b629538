"""Acceptance of candidates as markers: a clear one, and the cost of each weakness."""
import pytest

from alvar_core.detection.acceptance import Features, shortfall

CLEAR = Features(likeness=0.97, outside=-0.02, correlation=0.97, fit=0.97, score_gap=0.15, inlier_share=0.85,
                 bad_inside=0, bad_rim=0, contrast=150.0, noise=1.5, blur=1.0)


@pytest.mark.parametrize('features, expected', [
    ({}, True),
    ({'score_gap': 0.02}, False),  # another word is as good
    ({'fit': 0.85}, False), ({'correlation': 0.8}, False), ({'inlier_share': 0.6}, False),
    ({'fit': 0.9, 'score_gap': 0.06}, False),  # margin ratio 0.06 / 0.13 = 0.46
    ({'fit': 0.9, 'score_gap': 0.08}, True),  # 0.62
    ({'fit': 0.9, 'score_gap': 0.08, 'likeness': 0.85}, False),
    ({'fit': 0.9, 'score_gap': 0.12, 'likeness': 0.85}, True),
    ({'fit': 0.9, 'score_gap': 0.08, 'bad_rim': 3}, False), ({'fit': 0.9, 'score_gap': 0.12, 'bad_rim': 3}, True),
    ({'bad_rim': 7, 'fit': 0.9}, False), ({'bad_rim': 7}, True),
    ({'fit': 0.9, 'score_gap': 0.11, 'bad_inside': 2, 'correlation': 0.8}, True),  # a cover that no other word explains
    # a part of a marker; one touched by a bar
    ({'outside': -0.4, 'likeness': 0.9, 'score_gap': 0.08}, False), ({'outside': -0.4, 'score_gap': 0.08}, True),
    # bent paper, with a code that is surely read: margin ratio 0.15 / 0.06 = 2.5; one that is not
    ({'outside': -0.4, 'likeness': 0.9, 'inlier_share': 0.65}, True),
    ({'inlier_share': 0.65, 'score_gap': 0.08}, False),
    # paper that ends flush with one side before something dark; with two sides
    ({'outside': -0.9, 'likeness': 0.9}, True), ({'outside': -0.9, 'outside_but_one': -0.6, 'likeness': 0.9}, False),
    ({'fit': 1.04}, True),
])
def test_candidate_is_accepted(features, expected):
    assert (shortfall(CLEAR._replace(**features)) is None) is expected
