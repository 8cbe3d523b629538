"""The numbers that the actions compute."""
import statistics

import pytest

from actionlib_tutorials.core.numbers_of_actions import LONGEST, Average, fibonacci


def test_sequence_grows_by_one_number():
    assert [list(sequence) for sequence in fibonacci(5)] == [[0, 1, 1], [0, 1, 1, 2], [0, 1, 1, 2, 3]]


@pytest.mark.parametrize('length', [0, 1, 2])
def test_the_seeds_need_no_step(length):
    assert list(fibonacci(length)) == []


def test_the_longest_sequence_is_that_of_an_int32():
    *_, sequence = fibonacci(LONGEST + 1)
    assert sequence[LONGEST - 1] < 2 ** 31 <= sequence[LONGEST]


def test_average():
    numbers, average = [4.0, 5.5, 7.25, 5.0], Average()
    for number in numbers:
        average.add(number)
    assert (average.count, average.mean) == (4, statistics.fmean(numbers))
    assert average.deviation == pytest.approx(statistics.pstdev(numbers))
