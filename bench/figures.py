"""Figures of a bench: from raw samples to a judged table. No ROS, no clock, no processes.

A measurement returns samples under keys (`{'tick_rate': [62.5]}`). The samples of all rounds are pooled; a `Figure`
reduces the pool of one key to one number and names the target of that number.
"""

import statistics
from dataclasses import dataclass
from statistics import median
from typing import Optional

OURS = 'ours'
PEER = 'peer'


def p95(samples):
    """Return the 95th percentile, linearly interpolated; raise ValueError without samples."""
    return _quantile(samples, 20)


def p99(samples):
    """Return the 99th percentile, likewise."""
    return _quantile(samples, 100)


def _quantile(samples, parts):
    samples = list(samples)
    if len(samples) == 1:
        return statistics.mean(samples)
    return statistics.quantiles(samples, n=parts, method='inclusive')[-1]


def intervals(stamps):
    """Return the differences of neighbouring stamps, in their unit."""
    return [later - earlier for earlier, later in zip(stamps, stamps[1:])]


def mean_rate(stamps):
    """Return the rate [Hz] of stamps [s]; raise ValueError for fewer than two or no time between them."""
    if len(stamps) < 2 or stamps[-1] <= stamps[0]:
        raise ValueError(f'{len(stamps)} stamps give no rate: at least two, in rising order')
    return (len(stamps) - 1) / (stamps[-1] - stamps[0])


def rate_in_window(stamps, window, edge):
    """Events a second [Hz] in a window [s], without the error of whole events at its ends.

    Up to `edge` [s], which should hold a few events, may pass before the first and after the last stamp together;
    more is a stall, and counts as time without events. 0 for fewer than two stamps.
    """
    if len(stamps) < 2:
        return 0.0
    return (len(stamps) - 1) / max(stamps[-1] - stamps[0], window - edge)


def stratified_phases(count, rng):
    """`count` phases in [0, 1), one at random in each of `count` equal parts, in random order.

    As even as a grid and as free of patterns as chance: a median over them scatters far less than over plain chance.
    """
    phases = [(index + rng.random()) / count for index in range(count)]
    rng.shuffle(phases)
    return phases


@dataclass(frozen=True)
class Target:
    """The value that a figure must reach.

    kind: 'ratio' (ours / peer at most), 'times' (ours / peer at least), 'below', 'at_least', 'at_most', 'near' (within
    0.5 %).
    """

    kind: str
    limit: float

    NEAR_SHARE = 0.005  # a rate measured over a second or two repeats within that

    def __str__(self):
        limit = f'{self.limit:,g}'
        words = {'ratio': f'<= {limit} x peer', 'times': f'>= {limit} x peer', 'below': f'< {limit}',
                 'at_least': f'>= {limit}', 'at_most': f'<= {limit}', 'near': f'= {limit}'}
        return words[self.kind]

    def reached(self, ours, ratio):
        """Return True or False, or None without a figure, or for a ratio without a peer."""
        value = ratio if self.kind in ('ratio', 'times') else ours
        if value is None:
            return None
        if self.kind == 'below':
            return value < self.limit
        if self.kind in ('at_least', 'times'):
            return value >= self.limit
        if self.kind in ('at_most', 'ratio'):
            return value <= self.limit
        return abs(value - self.limit) <= self.NEAR_SHARE * self.limit


@dataclass(frozen=True)
class Figure:
    """One line of the table: ``reduce`` makes one number, in ``unit``, of the samples under ``key``."""

    name: str
    key: str
    unit: str
    reduce: object = median
    target: Optional[Target] = None


@dataclass(frozen=True)
class Row:
    """A judged figure; ``ours``, ``peer``, ``ratio`` and ``ok`` are None if nothing was measured."""

    figure: Figure
    ours: Optional[float]
    peer: Optional[float]
    ratio: Optional[float]
    ok: Optional[bool]
    counts: dict
    ranges: dict


def judge(figure, pools):
    """Return the Row of a figure; ``pools``: {'ours': {key: samples}, 'peer': {key: samples}}, or one of them."""
    samples = {side: pools.get(side, {}).get(figure.key, []) for side in (OURS, PEER)}
    value = {side: figure.reduce(pool) if pool else None for side, pool in samples.items()}
    ours, peer = value[OURS], value[PEER]
    ratio = ours / peer if ours is not None and peer else None
    ok = figure.target.reached(ours, ratio) if figure.target else None
    counts = {side: len(pool) for side, pool in samples.items()}
    ranges = {side: [min(pool), max(pool)] if pool else None for side, pool in samples.items()}
    return Row(figure, ours, peer, ratio, ok, counts, ranges)
