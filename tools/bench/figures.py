"""Figures of a bench: from raw samples to a judged table. No ROS, no clock, no processes.

A measurement returns samples under keys (`{'tick_rate': [62.5]}`). The samples of all rounds are pooled; a `Figure`
reduces the pool of one key to one number and names the target of that number. A table shows them.
"""

import operator
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple, Optional

import numpy as np

OURS, PEER = 'ours', 'peer'
HEADER = ('figure', 'ours', 'peer', 'ratio', 'target', 'ok?')


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


class Row(NamedTuple):
    """A judged figure; ``ours``, ``peer``, ``ratio`` and ``ok`` are None if nothing was measured."""

    figure: Figure
    ours: Optional[float]
    peer: Optional[float]
    ratio: Optional[float]
    ok: Optional[bool]


def judge(figure, pools):
    """Return the Row of a figure; ``pools``: {'ours': {key: samples}, 'peer': {key: samples}}, or one of them."""
    samples = (pools.get(side, {}).get(figure.key) for side in (OURS, PEER))
    ours, peer = (figure.reduce(pool) if pool else None for pool in samples)
    ratio = ours / peer if ours is not None and peer else None
    return Row(figure, ours, peer, ratio, figure.target.reached(ours, ratio) if figure.target else None)


def number(value):
    """Return a figure as text: four significant digits, a comma for thousands, '-' for none."""
    if value is None:
        return '-'
    if abs(value) >= 1000.0:
        return f'{value:,.0f}'
    return f'{value:.4g}' if abs(value) < 100.0 else f'{value:.1f}'


def cells(row):
    """Return the six texts of a row of the table."""
    figure = row.figure
    ratio = '-' if row.ratio is None else f'{row.ratio:.2f}'
    target = str(figure.target) if figure.target else ''
    verdict = {True: 'yes', False: 'NO', None: '-' if figure.target else ''}[row.ok]
    name = f'{figure.name} [{figure.unit}]' if figure.unit else figure.name
    return (name, number(row.ours), number(row.peer), ratio, target, verdict)


def aligned(rows, right=(), rule=False):
    """Return rows of texts as aligned columns, those of ``right`` at the right; ``rule``: a line below the first."""
    widths = [max(map(len, column)) for column in zip(*rows)]
    if rule:
        rows = [rows[0], ['-' * width for width in widths], *rows[1:]]
    return '\n'.join('  '.join(text.rjust(width) if column in right else text.ljust(width) for column, (text, width)
                               in enumerate(zip(row, widths))).rstrip() for row in rows)


def table(rows):
    """Return the rows as aligned text, without those of which nothing was measured."""
    return aligned([HEADER, *(cells(row) for row in rows if row.ours is not None or row.peer is not None)],
                   right=(1, 2, 3), rule=True)


def verdict(rows):
    """Return the closing sentence: how many targets were reached, missed, and could not be judged."""
    judged = [row for row in rows if row.figure.target]
    reached = sum(row.ok is True for row in judged)
    missed = [row.figure.name for row in judged if row.ok is False]
    text = f'{reached} of {len(judged)} targets reached'
    if missed:
        text += f', {len(missed)} missed ({"; ".join(missed)})'
    open_ones = len(judged) - reached - len(missed)
    if open_ones:
        text += f', {open_ones} not judged (not measured, or a ratio without --peer)'
    return text + '.'
