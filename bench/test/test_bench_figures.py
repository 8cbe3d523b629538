"""Statistics and judgement of bench/figures.py; every expected value is derived by hand beside it."""
import random

import pytest

from figures import (
    Figure,
    Target,
    intervals,
    judge,
    mean_rate,
    median,
    median_rate,
    p95,
    p99,
    rate_in_window,
    stratified_phases,
)

ROUNDING = 1e-12


@pytest.mark.parametrize('samples, expected', [
    ([7.0], 7.0),
    ([10.0, 0.0], 9.5),  # sorted first
    (list(range(101)), 95.0),
    ([1.0, 2.0, 3.0, 4.0], 3.85),  # 1 + 0.95 * 3
])
def test_p95(samples, expected):
    assert p95(samples) == pytest.approx(expected, abs=ROUNDING)


def test_p99():
    assert p99(range(201)) == pytest.approx(198.0, abs=ROUNDING)
    assert p99([3.0]) == 3.0


def test_p95_of_nothing_is_refused():
    with pytest.raises(ValueError):
        p95([])


def test_one_outlier_moves_neither_median_nor_p95_far():
    samples = [10.0] * 99 + [1000.0]
    assert median(samples) == 10.0
    assert p95(samples) == 10.0


def test_rate_and_intervals():
    stamps = [10.0, 10.5, 11.5, 12.0]  # 3 intervals in 2 s
    assert intervals(stamps) == [0.5, 1.0, 0.5]
    assert mean_rate(stamps) == 1.5


@pytest.mark.parametrize('stamps', [[], [1.0], [1.0, 1.0], [2.0, 1.0]])
def test_no_rate(stamps):
    with pytest.raises(ValueError):
        mean_rate(stamps)


@pytest.mark.parametrize('stamps, expected', [
    ([0.1 * tick + 0.01 for tick in range(10)], 10.0),  # 9 intervals of 0.1 s; 10 in 1 s is right by luck
    ([0.1 * tick + 0.1 for tick in range(9)], 10.0),  # the same rate, one event less by another phase
    ([0.0, 0.1, 0.2, 0.3], 3 / 0.8),  # stalled after 0.3 s: 3 intervals in 1 s less the edge of 0.2 s
    ([0.6, 0.7, 0.8, 0.9], 3 / 0.8),  # began late
    ([0.5], 0.0),
    ([], 0.0),
])
def test_rate_in_window(stamps, expected):
    assert rate_in_window(stamps, 1.0, 0.2) == pytest.approx(expected, rel=1e-9)


def test_phases_lie_one_in_each_part():
    phases = stratified_phases(50, random.Random(3))
    assert sorted(int(phase * 50) for phase in phases) == list(range(50))
    assert phases != sorted(phases)
    assert phases == stratified_phases(50, random.Random(3))


@pytest.mark.parametrize('kind, limit, ours, ratio, expected', [
    ('ratio', 1.05, 9.0, 1.05, True),
    ('ratio', 1.05, 9.0, 1.051, False),
    ('ratio', 1.05, 9.0, None, None),  # no peer
    ('times', 2.0, 9.0, 2.0, True),
    ('times', 2.0, 9.0, 1.99, False),
    ('times', 2.0, 9.0, None, None),
    ('below', 0.6, 0.59, None, True),
    ('below', 0.6, 0.6, None, False),
    ('below', 0.6, None, None, None),  # not measured
    ('at_least', 150000.0, 150000.0, None, True),
    ('at_least', 150000.0, 149999.0, None, False),
    ('near', 62.5, 62.2, None, True),  # 0.48 % below
    ('near', 62.5, 62.1, None, False),  # 0.64 % below
    ('near', 62.5, 63.0, None, False),  # too fast is wrong as well
])
def test_target(kind, limit, ours, ratio, expected):
    assert Target(kind, limit).reached(ours, ratio) is expected


def test_target_in_words():
    words = [str(Target('ratio', 1.05)), str(Target('below', 80.0)), str(Target('at_least', 150000.0)),
             str(Target('near', 62.5)),
             str(Target('times', 2.0))]
    assert words == ['<= 1.05 x peer', '< 80', '>= 150,000', '= 62.5', '>= 2 x peer']


def test_judge_pools_and_compares():
    figure = Figure('time', 'a', 'ms', median, Target('ratio', 1.5))
    row = judge(figure, {'ours': {'a': [2.0, 3.0, 4.0]}, 'peer': {'a': [2.0]}})
    assert (row.ours, row.peer, row.ratio, row.ok) == (3.0, 2.0, 1.5, True)
    assert row.counts == {'ours': 3, 'peer': 1}
    assert row.ranges == {'ours': [2.0, 4.0], 'peer': [2.0, 2.0]}


@pytest.mark.parametrize('pools, ours, peer', [
    ({}, None, None),
    ({'ours': {}}, None, None),
    ({'ours': {'a': [1.0]}}, 1.0, None),
    ({'peer': {'a': [1.0]}}, None, 1.0),
    ({'ours': {'a': [1.0]}, 'peer': {'a': [0.0]}}, 1.0, 0.0),  # nothing to divide by
])
def test_judge_without_a_pair(pools, ours, peer):
    row = judge(Figure('time', 'a', 'ms', median, Target('ratio', 1.5)), pools)
    assert (row.ours, row.peer, row.ratio, row.ok) == (ours, peer, None, None)


def test_median_rate_leaves_out_a_stall_and_what_is_caught_up():
    stamps = [0.1 * number for number in range(100)]
    late = [stamps[50] - 1e-3 * (50 - number) if 40 <= number < 50 else stamp for number, stamp in enumerate(stamps)]
    assert median_rate(late, 10) == pytest.approx(10.0)
    assert median_rate([1.1 * stamp for stamp in late], 10) == pytest.approx(10.0 / 1.1)
    assert median_rate(stamps[:10], 10) == 0.0
