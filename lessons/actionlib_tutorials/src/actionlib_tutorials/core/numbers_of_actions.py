"""The numbers that both actions compute."""
import math
from typing import Iterator, List

LONGEST = 47  # numbers: the next one of the Fibonacci sequence does not fit into an int32
SEEDS = (0, 1)


def fibonacci(length: int) -> 'Iterator[List[int]]':
    """Yield the Fibonacci sequence from 3 to ``length`` numbers, as a list that grows by one each time."""
    sequence = list(SEEDS)
    while len(sequence) < length:
        sequence.append(sequence[-1] + sequence[-2])
        yield sequence


class Average:
    """Mean and standard deviation of the numbers that were added."""

    def __init__(self) -> None:
        self.count = 0
        self._sum = self._sum_of_squares = 0.0

    def add(self, number: float) -> None:
        """Add a finite number."""
        self.count += 1
        self._sum += number
        self._sum_of_squares += number * number

    @property
    def mean(self) -> float:
        """Return the mean of at least one number."""
        return self._sum / self.count

    @property
    def deviation(self) -> float:
        """Return the standard deviation, that of the numbers themselves (divided by their count)."""
        return math.sqrt(abs(self._sum_of_squares / self.count - self.mean ** 2))
