"""Slopes with their uncertainty, by hand and on noise whose slope is known."""
import math
import random

import pytest

import growth


def drift(per_day, noise, rng, correlated=0.0, hours=1.0):
    """Samples every 5 s of a line with noise of which each value keeps a share of the last one's."""
    rest, found = 0.0, []
    for number in range(int(hours * 720)):
        rest = correlated * rest + rng.gauss(0.0, noise)
        found.append((5.0 * number, 80.0 + per_day * 5.0 * number / growth.DAY + rest))
    return found


def test_a_line_without_noise():
    found = growth.growth([(float(t), 3.0 + 2.0 * t / growth.DAY) for t in range(200)])
    assert found.slope == pytest.approx(2.0)
    assert found.margin == pytest.approx(0.0, abs=1e-6)


def test_margin_by_hand():
    # 20 samples are 20 blocks: values 0, 1, 0, 1 ... at 0 s to 19 s; the slope of that is 1 / 133 a second:
    # sum (t - 9.5)(v - 0.5) = 10 * 0.5 = 5, sum (t - 9.5)^2 = 665; 5 / 665 = 1 / 133
    found = growth.growth([(float(t), float(t % 2)) for t in range(20)])
    assert found.slope == pytest.approx(growth.DAY / 133.0)
    rest = 20 * 0.25 - 5.0 ** 2 / 665.0  # not explained by the line
    assert found.margin == pytest.approx(growth.DAY * 2.101 * math.sqrt(rest / 18.0 / 665.0))


@pytest.mark.parametrize('correlated', [0.0, 0.9])
def test_interval_holds_the_truth_about_19_times_of_20(correlated):
    rng = random.Random(1)
    held = sum(found.low <= 30.0 <= found.high
               for found in (growth.growth(drift(30.0, 0.1, rng, correlated)) for _ in range(200)))
    assert held >= 176  # 190 are expected; 176 or fewer of 200 come once in 10,000 times


@pytest.mark.parametrize('slope, margin, proven', [
    (0.0, 10.0, False),  # holds 0
    (20.0, 10.0, False),  # grows, by less than is harmful
    (100.0, 120.0, False),  # may be anything
    (100.0, 10.0, True),
    (45.0, 10.0, True),  # may be harmful
    (-100.0, 10.0, False),
])
def test_what_is_proven(slope, margin, proven):
    assert growth.Growth(slope, margin).is_proven(50.0) is proven


def test_too_few_samples():
    with pytest.raises(ValueError, match='at least 20'):
        growth.growth([(0.0, 1.0)] * 19)


def test_warm_up_is_left_out():
    samples = [(float(t), 0.0) for t in range(0, 3601, 10)]
    assert growth.after_warm_up(samples)[0][0] == 600.0
    assert growth.after_warm_up([]) == []


@pytest.mark.parametrize('values, expected', [
    ([5] * 40, 0),
    ([5, 5, 9, 5] * 10, 0),  # comes and goes
    ([5] * 20 + [6] * 20, 1),  # stays
    ([7], 0),
])
def test_step(values, expected):
    assert growth.step(list(enumerate(values))) == expected
