"""Growth of a quantity over a long run, with its uncertainty. No ROS, no clock.

Samples of a process's memory are correlated over minutes, so a plain regression would underestimate its error. The
samples are therefore averaged in BLOCKS blocks, each longer than the correlation; the regression uses these means.
"""

import math
from typing import NamedTuple

BLOCKS = 20
STUDENT_95 = 2.101  # two-sided 95 % quantile of Student's t with BLOCKS - 2 degrees of freedom
DAY = 86400.0  # [s]
WARM_UP = 1.0 / 6.0  # share of a run that is left out: 10 minutes of an hour


class Growth(NamedTuple):
    """A slope per day, and half the width of its 95 % interval."""

    slope: float
    margin: float

    @property
    def low(self):
        return self.slope - self.margin

    @property
    def high(self):
        return self.slope + self.margin

    def is_proven(self, harmless):
        """Return whether the whole interval is above 0 and reaches ``harmless`` per day."""
        return self.low > 0.0 and self.high >= harmless


def after_warm_up(samples):
    """Return the (time [s], value) samples without the first WARM_UP of the time that they span."""
    if not samples:
        return []
    start = samples[0][0] + WARM_UP * (samples[-1][0] - samples[0][0])
    return [sample for sample in samples if sample[0] >= start]


def block_means(samples):
    """Return (time, value) of BLOCKS means of equally many neighbours; ValueError for fewer samples than blocks."""
    if len(samples) < BLOCKS:
        raise ValueError(f'{len(samples)} samples are too few: at least {BLOCKS}')
    edges = [round(number * len(samples) / BLOCKS) for number in range(BLOCKS + 1)]
    return [tuple(math.fsum(column) / len(column) for column in zip(*samples[start:end]))
            for start, end in zip(edges, edges[1:])]


def growth(samples):
    """Return the Growth per day of (time [s], value) samples, in the unit of the values."""
    means = block_means(samples)
    middle_t, middle_v = (math.fsum(column) / BLOCKS for column in zip(*means))
    spread = math.fsum((t - middle_t) ** 2 for t, _ in means)
    slope = math.fsum((t - middle_t) * (v - middle_v) for t, v in means) / spread
    rest = math.fsum((v - middle_v - slope * (t - middle_t)) ** 2 for t, v in means)
    error = math.sqrt(rest / (BLOCKS - 2) / spread)
    return Growth(DAY * slope, DAY * STUDENT_95 * error)


def step(samples):
    """Return the median of the last quarter of the values minus that of the first quarter: what stayed open."""
    values = [value for _, value in samples]
    quarter = max(1, len(values) // 4)
    return sorted(values[-quarter:])[quarter // 2] - sorted(values[:quarter])[quarter // 2]
