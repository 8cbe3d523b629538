"""The results of a bench: a table for people, JSON for programs. No ROS."""

import json
import os
import platform
import re
import time

from figures import OURS, PEER

HEADER = ('figure', 'ours', 'peer', 'ratio', 'target', 'ok?')


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


def machine():
    """Return the facts of this machine that figures depend on; no names, no paths."""
    with open('/proc/cpuinfo', encoding='utf-8', errors='replace') as file:
        model = re.search(r'^(?:model name|Model|Hardware)\s*:\s*(.*)$', file.read(), re.MULTILINE)
    return {'cores': os.cpu_count(), 'cpu': model[1] if model else 'unknown',  # as on some ARM boards
            'architecture': platform.machine(), 'python': platform.python_version(),
            'load_before': round(os.getloadavg()[0], 2)}


def as_json(suite, rows, failures, settings, facts):
    """Return the whole run as JSON text; rows without samples are null."""
    figures = [{'name': row.figure.name, 'key': row.figure.key, 'unit': row.figure.unit, 'ours': row.ours,
                'peer': row.peer, 'ratio': row.ratio, 'target': row.figure.target and str(row.figure.target),
                'ok': row.ok, **{f'{side}_samples': row.counts[side] for side in (OURS, PEER)},
                **{f'{side}_range': row.ranges[side] for side in (OURS, PEER)}} for row in rows]
    return json.dumps({'suite': suite, 'when': time.strftime('%Y-%m-%dT%H:%M:%SZ', time.gmtime()), 'machine': facts,
                       'settings': settings, 'figures': figures, 'failures': failures}, indent=2) + '\n'
