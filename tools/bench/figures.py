"""Figures of a bench: from raw samples to a judged table. No ROS, no clock, no processes.

A measurement returns samples under keys (`{'tick_rate': [62.5]}`). The samples of all rounds are pooled; a `Figure`
reduces the pool of one key to one number and names the target of that number.
"""

import operator
from dataclasses import dataclass
from statistics import median
from typing import Optional

import numpy as np

OURS = 'ours'
PEER = 'peer'


def p95(samples):
    """Return the 95th percentile, linearly interpolated."""
    return float(np.percentile(samples, 95))


def p99(samples):
    """Return the 99th percentile, likewise."""
    return float(np.percentile(samples, 99))


def intervals(stamps):
    """Return the differences of neighbouring stamps, in their unit."""
    return np.diff(stamps).tolist()


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


def stratified_phases(count):
    """Return ``count`` phases in [0, 1), one at random in each of ``count`` equal parts, in random order.

    As even as a grid and as free of patterns as chance: a median over them scatters far less than over plain chance.
    """
    rng = np.random.default_rng(1)
    return rng.permutation((np.arange(count) + rng.random(count)) / count).tolist()


NEAR_SHARE = 0.005  # a rate measured over a second or two repeats within that
KINDS = {  # of targets: how they are shown, and compared with a figure or, if it is of the peer, the ratio
    'ratio': ('<= {:,g} x peer', operator.le), 'times': ('>= {:,g} x peer', operator.ge),
    'below': ('< {:,g}', operator.lt), 'at_least': ('>= {:,g}', operator.ge), 'at_most': ('<= {:,g}', operator.le),
    'near': ('= {:,g}', lambda value, limit: abs(value - limit) <= NEAR_SHARE * limit)}


@dataclass(frozen=True)
class Target:
    """The value that a figure must reach; ``kind``: one of KINDS."""

    kind: str
    limit: float

    def __str__(self):
        return KINDS[self.kind][0].format(self.limit)

    def reached(self, ours, ratio):
        """Return True or False, or None without a figure, or for a ratio without a peer."""
        shown, compare = KINDS[self.kind]
        value = ratio if 'peer' in shown else ours
        return None if value is None else compare(value, self.limit)


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
